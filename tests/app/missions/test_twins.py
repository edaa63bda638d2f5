"""A robot is replaced by its simulated twin and back, while it is idle."""

from collections.abc import Callable
from typing import Any

from fastapi.testclient import TestClient

from app.composition import Service
from robots.link.mqtt import ConnectionState
from robots.wire import FactsheetState
from tests.app.fake_robots import FakeTeam
from tests.app.missions.test_factsheets import CHANGES, announced, facts, robot, sheet, started, visitor
from tests.waiting import read_until

Follow = Callable[..., dict[str, Any]]


def replace(api: TestClient, name: str, *, external: bool) -> Any:
    edit = {"edit": "change_robot", "name": name, "external": external}
    return api.post(CHANGES, json={"edits": [edit], "reason": "a trial"})


def problem(answer: Any) -> tuple[int, str]:
    return answer.status_code, answer.json()["type"].rpartition(":")[2]


def test_a_robot_and_its_twin_take_turns_and_the_robot_is_told_why_it_does_not_count(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    before = facts(api)
    replace(api, "yard_2", external=True).raise_for_status()
    assert announced(team, "yard_2", sheet(number=7)) is FactsheetState.IN_FORCE
    assert robot(api, "yard_2")["factsheet"]["number"] == 7

    service.board.connected("yard_2", ConnectionState.OFFLINE, now=True)
    replace(api, "yard_2", external=False).raise_for_status()
    assert robot(api, "yard_2")["factsheet"] is None, "it was the robot's, not its twin's"
    assert announced(team, "yard_2", sheet(number=1, edition=2)) is FactsheetState.IN_FORCE
    assert announced(team, "yard_2", sheet(number=8)) is FactsheetState.REFUSED
    assert "yard_2 is simulated now" in team.replies[-1][1].reason
    assert robot(api, "yard_2")["factsheet"]["number"] == 1, "its twin's stays"

    replace(api, "yard_2", external=True).raise_for_status()
    assert announced(team, "yard_2", sheet(number=9)) is FactsheetState.IN_FORCE
    assert facts(api).keys() == before.keys()


def test_a_robot_that_was_never_another_announces_itself_as_before(api: TestClient, team: FakeTeam) -> None:
    assert announced(team, "yard_1", sheet(number=1)) is FactsheetState.IN_FORCE
    assert announced(team, "stranger", visitor()) is FactsheetState.ANNOUNCED


def test_a_robot_is_not_replaced_while_a_mission_needs_it(
    api: TestClient, team: FakeTeam, follow: Follow
) -> None:
    team.faults.silent.add("yard_1")
    mission = started(api, follow, "send yard_1 to door_2")
    follow(mission, "dispatching", "running", "unknown")
    assert problem(replace(api, "yard_1", external=True)) == (409, "needed-by-mission")


def test_a_robot_that_is_connected_gets_no_twin(api: TestClient, team: FakeTeam) -> None:
    replace(api, "yard_2", external=True).raise_for_status()
    team.tell("yard_2", battery=1.0)
    read_until(api, "/v1/robots/yard_2", lambda one: one["connection"] == "online")
    assert problem(replace(api, "yard_2", external=False)) == (409, "robot-connected")


def test_a_robot_that_holds_a_sample_is_not_replaced(api: TestClient, team: FakeTeam) -> None:
    held = {"predicate": "in", "args": ["sample_1", "yard_2"]}
    api.put("/v1/worlds/sample_store/facts", json={"facts": [held]}).raise_for_status()
    assert problem(replace(api, "yard_2", external=True)) == (409, "robot-holds-sample")
