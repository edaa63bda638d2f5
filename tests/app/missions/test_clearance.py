"""Two yard robots use one interchange one after the other: the second is cleared once the first has left.

The plan is made by hand, for what is checked is how it is carried out.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import select

from app.composition import RunningWorld, Service
from app.missions.clearance import action_has_ended, renew_clearances
from app.settings import Settings
from app.store import MissionRow, ScriptRow
from benchmarks.errands import with_sample
from robots.wire import ScriptState
from robots.world import load_world
from tests.app.conftest import PATIENCE_S, TOKEN
from tests.app.fake_robots import FakeTeam
from tests.app.sample_store import Store
from tests.app.scripted import ScriptedWorker
from tests.waiting import ENDED, until

Follow = Callable[..., dict[str, Any]]
STORE = Store(with_sample(load_world("sample_store"), "sample_2", "door_2", vacant="bay_3"))
NET = STORE.one_interchange_twice()
LEAVES = next(a.id for a in NET.actions if a.tag == "NAVIGATE" and a.arguments["ref1"] == "interchange_1")
ARRIVES = next(a.id for a in NET.actions if a.tag == "TRANSPORT" and a.agents == ("yard_2",))


@pytest.fixture
def service(tmp_path: Path, team: FakeTeam) -> Iterator[Service]:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=None, answer_patience_s=PATIENCE_S)
    world = RunningWorld(file=STORE.world, link=team.link, clock=team.clock, rate=None, run=team.run)
    with Service(settings, [world], worker=ScriptedWorker(NET)) as service:
        yield service


@pytest.fixture
def mission(api: TestClient, follow: Follow) -> str:
    """The path of the mission, under way."""
    text = "move sample_1 to bay_1 and sample_2 to bay_3"
    goal = api.post("/v1/goals", json={"text": text, "auto_approve": True}).json()
    committed = follow(f"/v1/goals/{goal['id']}", "committed", "finished")
    return f"/v1/missions/{committed['mission_id']}"


def packet(mission: dict[str, Any], robot: str, action: str) -> dict[str, Any]:
    script = next(script for script in mission["progress"] if script["robot"] == robot)
    found: dict[str, Any] = next(packet for packet in script["packets"] if packet["id"] == action)
    return found


def clearances(team: FakeTeam) -> list[str]:
    return [message_id for message_id in team.arrived if ":clearance:" in message_id]


@pytest.fixture
def stuck(team: FakeTeam) -> None:
    team.faults.stuck.add("yard_1")


@pytest.fixture
def waiting(stuck: None, mission: str, team: FakeTeam) -> str:
    """The mission; yard_2 stands before its transport, and yard_1 has not moved: it is stuck."""
    until(lambda: "yard_2" in team.robots and len(team.robots["yard_2"].executed) == 2)
    return mission


def test_the_second_robot_starts_only_after_the_first_has_left(
    api: TestClient, follow: Follow, waiting: str, team: FakeTeam
) -> None:
    assert packet(api.get(waiting).json(), "yard_2", ARRIVES)["waits_for"] == [f"{LEAVES} of yard_1"]
    assert clearances(team) == []
    team.faults.stuck.clear()
    ended = follow(waiting, *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    assert (
        packet(ended, "yard_2", ARRIVES)["started_at_s"] >= packet(ended, "yard_1", LEAVES)["finished_at_s"]
    )
    assert packet(ended, "yard_2", ARRIVES)["waits_for"] == []
    assert set(clearances(team)) == {f"{waiting.rpartition('/')[2]}-yard_2:clearance:1"}


def test_clearance_is_sent_again_until_the_robot_acknowledges_it(
    follow: Follow, waiting: str, team: FakeTeam
) -> None:
    team.faults.silent.add("yard_2")
    team.faults.stuck.clear()
    until(lambda: len(clearances(team)) >= 2)
    assert len(set(clearances(team))) == 1
    team.faults.silent.clear()
    assert follow(waiting, "completed", "partially_completed", "failed")["state"] == "completed"


def test_a_robot_that_waits_for_clearance_is_asked_and_says_so_and_is_given_time(
    api: TestClient, follow: Follow, waiting: str, team: FakeTeam
) -> None:
    until(lambda: packet(api.get(waiting).json(), "yard_2", ARRIVES)["detail"] == "waits")
    assert follow(waiting, "running")["failure"] is None
    team.faults.stuck.clear()
    assert follow(waiting, *ENDED)["state"] == "completed"


def test_a_mission_paused_while_a_robot_waits_for_clearance_goes_on(
    api: TestClient, follow: Follow, waiting: str, team: FakeTeam, service: Service
) -> None:
    assert api.post(f"{waiting}:pause").status_code == 202
    until(lambda: {robot.state for robot in team.robots.values()} == {ScriptState.PAUSED})
    team.faults.stuck.clear()
    assert api.post(f"{waiting}:resume").status_code == 202
    assert follow(waiting, *ENDED)["state"] == "completed"
    cleared = [row for row in service.events.since(0) if row.type == "script.cleared"]
    assert [row.data["ended"] for row in cleared] == [[LEAVES]]


def test_a_mission_cancelled_while_a_robot_waits_for_clearance_ends(
    api: TestClient, follow: Follow, waiting: str, team: FakeTeam
) -> None:
    assert api.post(f"{waiting}:cancel").status_code == 202
    assert follow(waiting, *ENDED)["state"] == "cancelled"
    assert clearances(team) == []


def test_nobody_is_cleared_in_a_mission_that_is_to_stop(waiting: str, service: Service) -> None:
    for stops in (True, False):
        with service.database.write() as session:
            row = session.get_one(MissionRow, waiting.rpartition("/")[2])
            row.cancel_requested = stops
            scripts = session.scalars(select(ScriptRow).where(ScriptRow.mission_id == row.id)).all()
            one, other = (next(s for s in scripts if s.robot == name) for name in ("yard_1", "yard_2"))
            one.packets = {**one.packets, LEAVES: {"state": "finished"}}
            renew_clearances(session, service.events, row, scripts)
            assert other.cleared == ([] if stops else [LEAVES])
            session.rollback()


def script(robot: str, state: str | None, **packets: str) -> ScriptRow:
    """A script with packets in these states."""
    return ScriptRow(
        id=robot,
        robot=robot,
        state=state,
        body={"packets": [{"id": name, "after": []} for name in packets]},
        packets={name: {"state": told} for name, told in packets.items() if told},
    )


def test_what_robots_do_together_has_ended_when_all_have_said_so() -> None:
    fred, ginger = script("fred", "running", a1="finished"), script("ginger", "running", a1="running")
    bystander = script("gene", "running", a2="running")
    assert not action_has_ended([fred, ginger, bystander], "a1")
    ginger.packets = {"a1": {"state": "finished"}}
    assert action_has_ended([fred, ginger, bystander], "a1")


def test_a_script_that_has_finished_has_ended_its_packets_even_if_their_reports_are_lost() -> None:
    assert action_has_ended([script("fred", "finished", a1="running")], "a1")
    assert not action_has_ended([script("fred", "failed", a1="running")], "a1")
