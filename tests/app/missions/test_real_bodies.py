"""A robot's mind is handed over between the simulation and the robot's own software, whichever program is killed."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.agents import RobotBoard
from app.cli.embody import embody
from app.composition import Service
from app.domain.errors import Invalid
from app.missions import embodiments
from robots.wire import WORLD, MindVerb, Program
from tests.app.api.test_rules import told
from tests.app.fake_robots import DOCUMENT, FakeTeam
from tests.app.missions.test_embodiments import EMBODIMENT, ROBOT, ended, move, refused
from tests.app.missions.test_factsheets import CHANGES, started
from tests.app.missions.trial import Trial
from tests.databases import ON_BOTH
from tests.waiting import ENDED, in_state, read_until

Follow = Callable[..., dict[str, Any]]
THERE = [
    (MindVerb.REST, Program.WORLD),
    (MindVerb.REST, Program.WORLD),
    (MindVerb.REST, Program.WORLD),
    (MindVerb.REST, Program.WORLD),
    (MindVerb.GO_ON, Program.OWN),
]
"""The document has four pieces."""
BACK = [(verb, Program.OWN if to is Program.WORLD else Program.WORLD) for verb, to in THERE]


def orders(team: FakeTeam) -> list[tuple[MindVerb, Program | None]]:
    return [(order.verb, order.to) for order in team.robots[ROBOT].orders]


def is_external(api: TestClient) -> bool:
    layout = api.get("/v1/worlds/sample_store").json()["layout"]
    return next(bool(one.get("external")) for one in layout["robots"] if one["name"] == ROBOT)


def connect(api: TestClient, team: FakeTeam) -> None:
    team.tell(ROBOT, battery=1.0)
    read_until(api, f"/v1/robots/{ROBOT}", lambda one: one["connection"] == "online")


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Worlds of the fake team run fast."""
    monkeypatch.setattr(embodiments, "PATIENCE_S", 1e9)
    return


@ON_BOTH
def test_a_mind_moves_into_the_real_body_and_back_while_its_mission_needs_it(
    api: TestClient, team: FakeTeam, service: Service, follow: Follow, patient: None
) -> None:
    api.put(f"/v1/robots/{ROBOT}/tuning", json={"tuning": {}}).raise_for_status()
    read_until(api, f"/v1/robots/{ROBOT}/tuning", lambda one: one["delivery"] == "acknowledged")
    team.faults.stuck.add(ROBOT)
    mission = started(api, follow, f"send {ROBOT} to door_2")
    follow(mission, "dispatching", "running", "unknown")
    move(api, "real").raise_for_status()
    attempt = ended(api, "embodied")
    assert (attempt["body"]["kind"], attempt["former"]["kind"], attempt["edition"]) == ("real", "velocity", 1)
    known = api.get(EMBODIMENT).json()
    assert (known["kind"], known["since"]) == ("real", attempt["ended_at"])
    assert is_external(api)
    assert orders(team) == THERE
    tuning = api.get(f"/v1/robots/{ROBOT}/tuning").json()
    assert tuning["delivery"] == "acknowledged", "it went with the mind"

    connect(api, team)
    move(api, "velocity").raise_for_status()
    assert ended(api, "embodied")["fence"] == 2
    assert not is_external(api)
    assert orders(team) == [*THERE, *BACK]
    assert team.minds == [{}, {ROBOT: DOCUMENT}]
    team.faults.stuck.discard(ROBOT)
    assert in_state(api, mission, *ENDED)["state"] == "completed"
    assert [deed[0] for deed in team.robots[ROBOT].deeds] == ["NAVIGATE"]
    states = ["requested", "handing_over", "moving", "going_on", "embodied"]
    assert [len(told(service, f"embodiment.{state}")) for state in states] == [2] * 5


def test_a_mind_that_its_own_software_cannot_take_goes_on_where_it_was(
    api: TestClient, team: FakeTeam, patient: None
) -> None:
    team.faults.unfit[ROBOT] = "no packet DOCK"
    move(api, "real").raise_for_status()
    attempt = ended(api, "returned")
    assert (attempt["reason"], attempt["edition"]) == ("no packet DOCK", None)
    assert orders(team)[-1] == (MindVerb.GO_ON, Program.WORLD)
    assert not team.robots[ROBOT].rests
    with pytest.raises(Invalid, match="yard_1 is in a simulated body, velocity: no packet DOCK"):
        embody(api, ROBOT, "real")
    team.faults.unfit.clear()
    assert embody(api, ROBOT, "real") == "yard_1 is in a real body"


def test_a_mind_goes_on_where_it_was_if_its_own_software_does_not_run(
    api: TestClient, team: FakeTeam
) -> None:
    team.faults.own_is_off.add(ROBOT)
    move(api, "real").raise_for_status()
    attempt = ended(api, "returned")
    assert (
        "the software of yard_1's real body has not taken its mind within 30 s; start it" in attempt["reason"]
    )
    assert not is_external(api)
    assert not team.robots[ROBOT].rests


def test_a_move_that_waits_for_the_robots_own_software_is_withdrawn_by_the_present_body(
    api: TestClient, team: FakeTeam, patient: None
) -> None:
    team.faults.own_is_off.add(ROBOT)
    move(api, "real").raise_for_status()
    ended(api, "handing_over")
    assert refused(move(api, "wheeled")) == (409, "embodiment-under-way")
    move(api, "velocity").raise_for_status()
    assert ended(api, "returned")["reason"] == "withdrawn"
    assert not team.robots[ROBOT].rests


def test_software_that_has_lost_the_mind_is_handed_it_again(
    api: TestClient, team: FakeTeam, patient: None
) -> None:
    team.faults.silent.add(WORLD)
    move(api, "real").raise_for_status()
    ended(api, "moving")
    team.robots[ROBOT].taken = {}
    team.faults.silent.clear()
    assert ended(api, "embodied")["edition"] == 1
    assert orders(team) == [*THERE[:-1], THERE[-1], THERE[-1]]


def test_software_that_has_lost_the_mind_and_takes_it_no_more_leaves_it_to_the_simulation(
    api: TestClient, team: FakeTeam, patient: None
) -> None:
    team.faults.silent.add(WORLD)
    move(api, "real").raise_for_status()
    ended(api, "moving")
    team.robots[ROBOT].taken = {}
    team.faults.unfit[ROBOT] = "no packet DOCK"
    team.faults.silent.clear()
    attempt = ended(api, "returned")
    assert (attempt["reason"], attempt["edition"]) == ("no packet DOCK", 2)
    assert not is_external(api)
    assert team.minds[-1] == {ROBOT: DOCUMENT}
    assert orders(team)[-1] == (MindVerb.GO_ON, Program.WORLD)


def test_a_mind_stays_with_the_real_body_if_the_world_refuses_it(
    api: TestClient, team: FakeTeam, patient: None
) -> None:
    assert embody(api, ROBOT, "real") == "yard_1 is in a real body"
    connect(api, team)
    team.faults.world_refuses = True
    move(api, "wheeled").raise_for_status()
    assert ended(api, "returned")["reason"] == "it cannot be made"
    assert is_external(api)
    assert orders(team)[-1] == (MindVerb.GO_ON, Program.OWN)


@pytest.fixture
def connected(monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """Who speaks for a robot as far as the service knows."""
    names: set[str] = set()
    monkeypatch.setattr(RobotBoard, "is_connected", lambda _board, robot: robot in names)
    return names


def test_the_robots_own_software_may_be_offline_once_it_has_handed_the_mind_over(
    connected: set[str], api: TestClient, team: FakeTeam, patient: None
) -> None:
    assert embody(api, ROBOT, "real") == "yard_1 is in a real body"
    assert refused(move(api, "velocity")) == (409, "robot-offline")
    team.faults.silent.add(ROBOT)
    connected.add(ROBOT)
    move(api, "velocity").raise_for_status()
    connected.clear()
    team.faults.silent.discard(ROBOT)
    assert ended(api, "embodied")["fence"] == 2


def test_what_a_body_cannot_carry_on_is_refused(api: TestClient, team: FakeTeam, patient: None) -> None:
    held = {"predicate": "in", "args": ["sample_1", ROBOT]}
    api.put("/v1/worlds/sample_store/facts", json={"facts": [held]}).raise_for_status()
    assert refused(move(api, "real")) == (409, "robot-holds-sample")
    edit = {"edit": "change_robot", "name": "yard_2", "external": True}
    api.post(CHANGES, json={"edits": [edit], "reason": "a trial"}).raise_for_status()
    offline = api.post("/v1/robots/yard_2:embody", json={"body": "velocity"})
    assert refused(offline) == (409, "robot-offline")
    assert "connect it" in offline.json()["detail"]


@pytest.mark.parametrize("state", ["requested", "handing_over", "moving", "going_on"])
def test_a_mind_comes_into_the_real_body_though_the_service_ends_at_any_step(
    state: str,
    trial: Trial,
    team: FakeTeam,
    patient: None,
) -> None:
    with trial.running() as api:
        team.faults.silent |= {ROBOT} if state == "requested" else set()
        team.faults.silent |= {WORLD} if state == "moving" else set()
        team.faults.own_is_off |= {ROBOT} if state == "handing_over" else set()
        if state == "going_on":
            team.faults.silent.add(WORLD)
        move(api, "real").raise_for_status()
        if state == "going_on":
            ended(api, "moving")
            team.faults.own_is_off.add(ROBOT)
            team.faults.silent.clear()
        ended(api, state)
    with trial.running() as api:
        team.faults.silent.clear()
        team.faults.own_is_off.clear()
        ended(api, "embodied")
        assert orders(team) == THERE
        assert is_external(api)


@pytest.mark.parametrize("state", ["requested", "moving", "going_on", "returning"])
def test_a_mind_comes_back_into_the_simulation_though_the_service_ends_at_any_step(
    state: str,
    trial: Trial,
    team: FakeTeam,
    patient: None,
) -> None:
    with trial.running() as api:
        embody(api, ROBOT, "real")
        connect(api, team)
        if state == "requested":
            team.faults.own_is_off.add(ROBOT)
        else:
            team.faults.silent.add(WORLD)
        move(api, "wheeled").raise_for_status()
        if state in ("going_on", "returning"):
            ended(api, "moving")
            team.faults.world_refuses = state == "returning"
            team.faults.own_is_off.add(ROBOT)
            team.faults.silent = {ROBOT}
        ended(api, state)
    with trial.running() as api:
        team.faults.silent.clear()
        team.faults.own_is_off.clear()
        team.faults.world_refuses = False
        ended(api, "returned" if state == "returning" else "embodied")
        assert is_external(api) is (state == "returning")
        went_on = Program.OWN if state == "returning" else Program.WORLD
        assert orders(team)[len(THERE) :] == [*BACK[:-1], (MindVerb.GO_ON, went_on)]
