"""What operators and clients are shown of reports that contradict each other."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import RunningWorld, Service
from app.settings import Settings
from robots.wire import PacketReport, PacketState
from tests.app.conftest import PATIENCE_S, TOKEN
from tests.app.fake_robots import FakeTeam
from tests.app.missions.test_couplings import store_with
from tests.app.scripted import ScriptedWorker
from tests.waiting import ENDED, awaited, until

ASKED = "mission.robots_asked"
Follow = Callable[..., dict[str, Any]]
STORE = store_with(store_2=())
NET = STORE.store_sample_1()
RELEASE = next(a.id for a in NET.actions if a.tag == "RELEASE2" and a.agents == ("yard_1",))
DOCK = next(a.id for a in NET.actions if a.tag == "DOCK" and a.agents == ("store_2",))


@pytest.fixture
def service(tmp_path: Path, team: FakeTeam) -> Iterator[Service]:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=None, answer_patience_s=PATIENCE_S)
    world = RunningWorld(file=STORE.world, link=team.link, clock=team.clock, rate=None, run=team.run)
    with Service(settings, [world], worker=ScriptedWorker(NET)) as service:
        yield service


def mission_of(api: TestClient, follow: Follow, **more: Any) -> str:
    wanted = {"text": "move sample_1 to bay_7", "auto_approve": True, **more}
    goal = api.post("/v1/goals", json=wanted).raise_for_status().json()
    committed = follow(f"/v1/goals/{goal['id']}", "committed", "finished")
    return f"/v1/missions/{committed['mission_id']}"


def test_the_robot_waits_for_clearance_and_what_it_senses_is_shown(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    mission = mission_of(api, follow)
    assert follow(mission, *ENDED)["state"] == "completed"
    script = team.robots["store_2"].script
    assert script is not None
    assert [(one.awaits, one.after) for one in script.packets if one.id == DOCK] == [((), (RELEASE,))]
    assert api.get("/v1/robots/store_2").json()["senses"] == []
    assert {"in", "clear", "vacant"} <= set(api.get("/v1/robots/yard_1").json()["senses"])
    assert api.get(mission).json()["contradictions"] == []


def test_a_robot_that_docks_uncleared_has_its_mission_stopped_with_both_reports(
    api: TestClient, follow: Follow, team: FakeTeam, service: Service
) -> None:
    team.faults.stuck.add("yard_1")
    mission = mission_of(api, follow, recovery="ask")
    until(lambda: "store_2" in team.robots and len(team.robots["store_2"].executed) == 1)
    script = team.robots["store_2"].script
    assert script is not None
    team.tick_s = 0.0  # or the robots are asked because they are late
    began_s = team.clock.now_s()
    claim = PacketReport(script_id=script.id, packet_id=DOCK, state=PacketState.RUNNING, at_s=began_s)
    team.report("store_2", claim)
    # By its event: the state lasts a third of a second, which a reader may miss.
    (asked,) = awaited(lambda: [row for row in service.events.since(0) if row.type == ASKED], bool)
    assert asked.data["state"] == "unknown"
    assert f"store_2 reports {DOCK} DOCK at {began_s:.1f} s without clearance" in asked.data["reason"]
    assert f"yard_1 has reported nothing of {RELEASE} RELEASE2" in asked.data["reason"]
    team.clock.advance(31.0)
    team.report("store_2", claim)
    until(lambda: api.get(mission).json()["recovery"]["step"] == "stuck")
    shown = api.get(mission).json()
    assert shown["state"] == "recovering"
    (one,) = shown["contradictions"]
    assert (one["later"]["robot"], one["later"]["packet"], one["later"]["at_s"]) == ("store_2", DOCK, began_s)
    assert (one["earlier"]["robot"], one["earlier"]["packet"], one["earlier"]["at_s"]) == (
        "yard_1",
        RELEASE,
        None,
    )
    assert one["detail"] in shown["reason"]
    assert (shown["failure"], shown["recovery"]["attempts"][0]["failure"]) == ("robot", "robot")
    told = [row for row in service.events.since(0) if row.type == "mission.reports_contradict"]
    assert [row.data["detail"] for row in told] == [one["detail"]]
    (lost,) = api.get("/v1/worlds/sample_store/unknown").json()["items"]
    assert lost["name"] == "sample_1"
    assert "contradicting reports of store_2 and yard_1" in lost["reason"]
    assert lost["last_believed"]["source"] == "world file sample_store"
