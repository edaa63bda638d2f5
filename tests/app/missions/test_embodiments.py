"""A robot's mind moves into another body while its mission goes on, in one body at a time, whoever is killed."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import select

from app.cli.embody import embody
from app.composition import Service
from app.domain.errors import IllegalTransition, Invalid
from app.domain.lifecycles.embodiment import EmbodimentState, become
from app.store import Database, EmbodimentRow
from robots.wire import WORLD, MindVerb
from robots.world import WorldFile
from robots.world.bodies import WheeledBodySpec
from tests.app.api.test_rules import told
from tests.app.fake_robots import FakeRobot, FakeTeam
from tests.app.missions.test_factsheets import CHANGES, started
from tests.app.missions.trial import Trial
from tests.databases import ON_BOTH
from tests.waiting import ENDED, in_state, read_until, until

Follow = Callable[..., dict[str, Any]]
ROBOT = "yard_1"
EMBODIMENT = f"/v1/robots/{ROBOT}/embodiment"


def move(api: TestClient, body: Any = "avatar", **more: Any) -> Any:
    return api.post(f"/v1/robots/{ROBOT}:embody", json={"body": body, **more})


def ended(api: TestClient, *states: str) -> dict[str, Any]:
    """The newest move once it is in one of the states."""
    known = read_until(api, EMBODIMENT, lambda one: one["attempts"] and one["attempts"][0]["state"] in states)
    attempt: dict[str, Any] = known["attempts"][0]
    return attempt


def refused(answer: Any) -> tuple[int, str]:
    return answer.status_code, answer.json()["type"].rpartition(":")[2]


def body_of(api: TestClient) -> str:
    layout = api.get("/v1/worlds/sample_store").json()["layout"]
    kind: str = next(one["body"]["kind"] for one in layout["robots"] if one["name"] == ROBOT)
    return kind


def verbs(team: FakeTeam) -> list[tuple[MindVerb, int]]:
    return [(order.verb, order.fence) for order in team.robots[ROBOT].orders]


@ON_BOTH
def test_a_mind_moves_while_its_mission_needs_it_and_the_mission_completes(
    api: TestClient, team: FakeTeam, service: Service, follow: Follow
) -> None:
    before = api.get(EMBODIMENT).json()
    assert (before["kind"], before["fence"], before["since"], before["attempts"]) == (
        "simulated",
        0,
        None,
        [],
    )
    team.faults.stuck.add(ROBOT)
    mission = started(api, follow, f"send {ROBOT} to door_2")
    follow(mission, "dispatching", "running", "unknown")
    asked = move(api, comment="a rehearsal")
    assert (asked.status_code, asked.json()["attempts"][0]["former"]["kind"]) == (202, "velocity")
    attempt = ended(api, "embodied")
    assert (attempt["fence"], attempt["edition"], attempt["reason"]) == (1, 1, "")
    known = api.get(EMBODIMENT).json()
    assert (known["kind"], known["body"]["kind"], known["lease_until_s"]) == ("virtual", "avatar", None)
    assert known["since"] == attempt["ended_at"]
    assert api.get(f"/v1/robots/{ROBOT}").json()["body"] == "virtual"
    assert verbs(team) == [(MindVerb.REST, 1), (MindVerb.GO_ON, 1)]
    assert move(api).json()["fence"] == 1, "it is in that body already"
    team.faults.stuck.discard(ROBOT)
    assert in_state(api, mission, *ENDED)["state"] == "completed"
    assert [one["tag"] for one in _finished(team)] == ["NAVIGATE"]
    states = ["requested", "moving", "going_on", "embodied"]
    events = [event for state in states for event in told(service, f"embodiment.{state}")]
    assert [(one["state"], one["body"], one["former"], one["fence"]) for one in events] == [
        (state, "avatar", "velocity", 1) for state in states
    ]


def _finished(team: FakeTeam) -> list[dict[str, str]]:
    return [{"tag": deed[0]} for deed in team.robots[ROBOT].deeds]


def test_a_robot_that_does_not_come_to_rest_stays_as_it_is_with_its_reason(
    api: TestClient, team: FakeTeam
) -> None:
    team.faults.refuses.add(ROBOT)
    move(api).raise_for_status()
    attempt = ended(api, "refused")
    assert (attempt["reason"], attempt["edition"]) == ("yard_1 is not willing", None)
    assert body_of(api) == "velocity"
    assert verbs(team) == [(MindVerb.REST, 1)]
    team.faults.refuses.discard(ROBOT)
    assert embody(api, ROBOT, "avatar") == "yard_1 is in a virtual body, avatar"
    assert embody(api, ROBOT, None) == "yard_1 is in a virtual body, avatar"
    assert verbs(team)[1:] == [(MindVerb.REST, 2), (MindVerb.GO_ON, 2)]


def test_a_mind_goes_on_in_its_former_body_if_the_world_refuses_the_other(
    api: TestClient, team: FakeTeam
) -> None:
    team.faults.world_refuses = True
    team.robots[ROBOT] = FakeRobot()
    with pytest.raises(Invalid, match="yard_1 is in a simulated body, velocity: it cannot be made"):
        embody(api, ROBOT, "wheeled")
    attempt = ended(api, "returned")
    assert (attempt["reason"], attempt["edition"]) == ("it cannot be made", 2)
    assert body_of(api) == "velocity", "the record says so again"
    assert verbs(team) == [(MindVerb.REST, 1), (MindVerb.GO_ON, 1)]


def test_a_refused_edition_ends_the_moves_of_those_before_that_it_contains(
    api: TestClient, team: FakeTeam
) -> None:
    team.faults.silent.add(WORLD)
    team.faults.world_refuses = True
    move(api, "wheeled").raise_for_status()
    ended(api, "moving")
    edit = {"edit": "change_robot", "name": "yard_2", "speaks": []}
    api.post(CHANGES, json={"edits": [edit], "reason": "it is told before the first"}).raise_for_status()
    team.faults.silent.discard(WORLD)
    assert ended(api, "returning", "returned")["reason"] == "it cannot be made"
    told = {one["edition"]: one["delivery"] for one in api.get(CHANGES).json()["items"]}
    assert (told[1], told[2]) == ("refused", "refused")


def test_what_cannot_be_moved_or_moved_back_keeps_no_other_mind_at_rest(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    team.faults.silent.add(WORLD)
    team.faults.world_refuses = True
    move(api, "wheeled").raise_for_status()
    ended(api, "moving")
    with service.database.write() as session:
        odd = {"body": {"kind": "submarine"}, "actor": "test", "world": "sample_store", "reason": ""}
        moving = EmbodimentState.MOVING
        session.add(EmbodimentRow(robot="a_ghost", fence=1, state=moving, edition=1, former={}, **odd))
        session.get_one(EmbodimentRow, ("sample_store", ROBOT, 1)).former = {"kind": "submarine"}
    team.faults.silent.discard(WORLD)
    attempt = ended(api, "returned")
    assert attempt["reason"].startswith("it cannot be made; the record still has that body: ")
    assert not team.robots[ROBOT].rests


def test_the_present_body_with_another_lease_changes_the_lease(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    team.robots[ROBOT] = FakeRobot()
    assert "until" in embody(api, ROBOT, "avatar", lease_s=1000.0)
    since = api.get(EMBODIMENT).json()["since"]
    assert "until" in embody(api, ROBOT, "avatar", lease_s=2000.0)
    known = api.get(EMBODIMENT).json()
    assert (known["lease_s"], known["fence"], known["since"]) == (2000.0, 2, since)
    assert embody(api, ROBOT, "avatar") == "yard_1 is in a virtual body, avatar"
    assert verbs(team) == [
        (MindVerb.REST, 1),
        (MindVerb.GO_ON, 1),
        (MindVerb.GO_ON, 2),
        (MindVerb.GO_ON, 3),
    ]
    team.faults.refuses.add(ROBOT)
    with pytest.raises(Invalid, match="the lease is not in force, yard_1 is not willing"):
        embody(api, ROBOT, "avatar", lease_s=1000.0)
    assert ended(api, "returned")["fence"] == 4
    team.faults.refuses.discard(ROBOT)
    embody(api, ROBOT, "avatar", lease_s=1000.0)
    team.faults.silent.add(ROBOT)
    assert move(api, lease_s=2000.0).json()["attempts"][0]["state"] == "going_on"
    assert refused(move(api, lease_s=3000.0)) == (409, "embodiment-under-way")
    edit = {"edit": "change_robot", "name": ROBOT, "external": True}
    api.post(CHANGES, json={"edits": [edit], "reason": "its own software"}).raise_for_status()
    known = api.get(EMBODIMENT).json()
    assert (known["lease_s"], known["attempts"][0]["state"]) == (None, "returned")
    assert not service.embodiments.due("sample_store"), "its software would refuse"


def test_a_move_that_is_only_requested_is_withdrawn_by_the_present_body(
    api: TestClient, team: FakeTeam
) -> None:
    team.faults.silent.add(ROBOT)
    move(api).raise_for_status()
    assert move(api).json()["fence"] == 1, "a repeated request changes nothing"
    assert refused(move(api, "wheeled")) == (409, "embodiment-under-way")
    withdrawn = move(api, "velocity").json()["attempts"][0]
    assert (withdrawn["state"], withdrawn["reason"]) == ("returning", "withdrawn")
    team.faults.silent.discard(ROBOT)
    assert ended(api, "returned")["edition"] is None
    assert not team.robots[ROBOT].rests


def test_a_robot_that_cannot_be_asked_is_not_moved_before_its_lease_has_run_out(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    move(api, lease_s=20.0).raise_for_status()
    ended(api, "embodied")
    first = api.get(EMBODIMENT).json()["lease_until_s"]
    renewed = read_until(api, EMBODIMENT, lambda one: one["lease_until_s"] > first + 5.0)
    assert (renewed["lease_s"], renewed["fence"]) == (20.0, 1)
    until(lambda: len(team.robots[ROBOT].orders) > 2)
    team.faults.silent.add(ROBOT)
    left = move(api, "velocity").raise_for_status().json()
    assert left["attempts"][0]["state"] == "requested"
    moving = read_until(api, EMBODIMENT, lambda one: one["attempts"][0]["state"] != "requested")
    assert service.clocks["sample_store"].now_s() > left["lease_until_s"]
    assert moving["attempts"][0]["state"] in ("moving", "going_on")
    assert ended(api, "going_on")["edition"] == 2
    team.faults.silent.discard(ROBOT)
    ended(api, "embodied")
    assert api.get(EMBODIMENT).json()["lease_until_s"] is None, "this body was given none"


def test_a_body_in_which_the_robot_cannot_go_on_is_refused(api: TestClient, team: FakeTeam) -> None:
    slow = move(api, {"kind": "wheeled", "speed_rad_s": 0.1})
    assert slow.status_code == 422
    assert "raise body.speed_rad_s" in slow.json()["detail"]
    assert move(api, "submarine").status_code == 422
    held = {"predicate": "in", "args": ["sample_1", ROBOT]}
    api.put("/v1/worlds/sample_store/facts", json={"facts": [held]}).raise_for_status()
    edit = {"edit": "change_robot", "name": "yard_2", "external": True}
    api.post(CHANGES, json={"edits": [edit], "reason": "a trial"}).raise_for_status()
    holding = move(api)
    assert refused(holding) == (409, "robot-holds-sample")
    assert "yard_1 holds sample_1" in holding.json()["detail"]
    assert api.get("/v1/robots/yard_2/embodiment").json()["kind"] == "real"
    assert api.post("/v1/robots/nobody:embody", json={"body": "avatar"}).status_code == 404
    assert api.get(EMBODIMENT).json()["attempts"] == []


def test_a_body_without_what_the_mission_rests_on_is_refused(
    api: TestClient, team: FakeTeam, follow: Follow
) -> None:
    edit = {"edit": "change_robot", "name": "yard_2", "external": True}
    api.post(CHANGES, json={"edits": [edit], "reason": "a trial"}).raise_for_status()
    team.faults.stuck |= {ROBOT, "store_1", "store_2"}
    mission = started(api, follow, f"move sample_1 to bay_7 with {ROBOT} and store_2")
    follow(mission, "dispatching", "running", "unknown")
    needed = move(api)
    assert refused(needed) == (409, "needed-by-mission")
    assert f"can({ROBOT}, DOCK)" in needed.json()["detail"]
    move(api, "wheeled").raise_for_status()
    ended(api, "embodied")


def test_a_simulated_robot_that_is_idle_gets_another_body_by_an_edition(
    api: TestClient, team: FakeTeam
) -> None:
    edit = {"edit": "change_robot", "name": ROBOT, "body": "avatar"}
    api.post(CHANGES, json={"edits": [edit], "reason": "at rest"}).raise_for_status()
    known = api.get(EMBODIMENT).json()
    assert (known["kind"], known["since"], known["attempts"]) == ("virtual", None, [])


@pytest.mark.parametrize("state", ["requested", "moving", "going_on", "returning"])
def test_a_move_comes_to_its_end_though_the_service_ends_at_any_of_its_steps(
    state: str,
    trial: Trial,
    team: FakeTeam,
) -> None:
    team.faults.stuck.add(ROBOT)
    with trial.running() as api:
        wish = {"text": f"send {ROBOT} to door_2", "auto_approve": True}
        goal = f"/v1/goals/{api.post('/v1/goals', json=wish).raise_for_status().json()['id']}"
        mission = read_until(api, goal, lambda one: one["mission_id"])["mission_id"]
        in_state(api, f"/v1/missions/{mission}", "running", "unknown")
        team.faults.silent |= {ROBOT} if state == "requested" else {WORLD}
        move(api).raise_for_status()
        if state != "requested":
            ended(api, "moving")
            if state != "moving":
                team.faults.silent.add(ROBOT)
                team.faults.world_refuses = state == "returning"
                team.faults.silent.discard(WORLD)
        ended(api, state)
    team.faults.world_refuses = False
    with trial.running() as api:
        team.faults.silent.clear()
        ended(api, "returned" if state == "returning" else "embodied")
        assert verbs(team) == [(MindVerb.REST, 1), (MindVerb.GO_ON, 1)]
        team.faults.stuck.clear()
        assert in_state(api, f"/v1/missions/{mission}", *ENDED)["state"] == "completed"
        assert _finished(team) == [{"tag": "NAVIGATE"}]
        assert api.get(EMBODIMENT).json()["kind"] == ("simulated" if state == "returning" else "virtual")


@pytest.mark.parametrize("run", ["another", None])
def test_a_move_ends_in_the_body_that_a_replaced_world_file_gives(
    run: str | None,
    trial: Trial,
    database_url: str,
    world_file: WorldFile,
    team: FakeTeam,
) -> None:
    with trial.running() as api:
        team.faults.silent |= {WORLD, "yard_2"}
        move(api).raise_for_status()
        api.post("/v1/robots/yard_2:embody", json={"body": "avatar"}).raise_for_status()
        ended(api, "moving")
    robots = [
        one.model_copy(update={"body": WheeledBodySpec()}) if one.name == ROBOT else one
        for one in world_file.robots
        if one.name != "yard_2"
    ]
    team.faults.silent.clear()
    with trial.running(run, world_file.model_copy(update={"robots": tuple(robots)})) as api:
        attempt = ended(api, "returned")
        expected = (
            "edition 2 of the world gives it another body"
            if run is None
            else "the simulated world was started again"
        )
        assert attempt["reason"] == expected
        assert body_of(api) == "wheeled"
    database = Database(database_url)
    with database.read() as session:
        assert session.scalars(select(EmbodimentRow.robot)).all() == [ROBOT], "the file has no yard_2"
    database.close()


def test_a_move_goes_only_on_to_a_state_that_may_follow() -> None:
    row = EmbodimentRow(state=EmbodimentState.REQUESTED, reason="")
    with pytest.raises(IllegalTransition):
        become(row, EmbodimentState.EMBODIED)
    become(row, EmbodimentState.REFUSED, "it moves the jaws")
    assert row.reason == "it moves the jaws"
    with pytest.raises(IllegalTransition):
        become(row, EmbodimentState.MOVING)
