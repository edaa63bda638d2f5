"""A robot is replaced by its simulated twin and back, while it is idle."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient
from httpx2 import Client

from app.cli.twin import twin
from app.composition import Service
from app.domain.errors import Invalid
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


def test_whoever_speaks_for_a_robot_from_now_on_gets_its_tuning_and_rules_anew(
    api: TestClient, team: FakeTeam
) -> None:
    tuning, rules = "/v1/robots/yard_2/tuning", "/v1/robots/yard_2/rules"
    api.put(tuning, json={"tuning": {}}).raise_for_status()
    api.put(rules, json={"files": {}}).raise_for_status()
    for path, end in ((tuning, "acknowledged"), (rules, "refused")):
        read_until(api, path, lambda one, end=end: one["delivery"] == end)
    team.faults.silent.add("yard_2")
    replace(api, "yard_2", external=True).raise_for_status()
    assert [api.get(path).json()["delivery"] for path in (tuning, rules)] == ["pending", "pending"]


def test_a_robot_that_is_connected_gets_no_twin(api: TestClient, team: FakeTeam) -> None:
    replace(api, "yard_2", external=True).raise_for_status()
    team.tell("yard_2", battery=1.0)
    read_until(api, "/v1/robots/yard_2", lambda one: one["connection"] == "online")
    assert problem(replace(api, "yard_2", external=False)) == (409, "robot-connected")


def test_a_robot_that_holds_a_sample_is_not_replaced(api: TestClient, team: FakeTeam) -> None:
    held = {"predicate": "in", "args": ["sample_1", "yard_2"]}
    api.put("/v1/worlds/sample_store/facts", json={"facts": [held]}).raise_for_status()
    assert problem(replace(api, "yard_2", external=True)) == (409, "robot-holds-sample")


def test_the_command_replaces_a_robot_there_and_back_and_says_why_it_may_not(
    api: TestClient, team: FakeTeam, follow: Follow
) -> None:
    assert twin(api, "yard_2", is_simulated=None) == "yard_2 is simulated"
    real = "real: software of its own speaks for it"
    assert twin(api, "yard_2", is_simulated=False) == f"yard_2 is now {real}"
    assert twin(api, "yard_2", is_simulated=False) == f"yard_2 is {real}", "nothing is changed twice"
    assert twin(api, "yard_2", is_simulated=True) == "yard_2 is now simulated"
    changes = api.get(CHANGES).json()["items"]
    assert [one["reason"] for one in changes] == [
        "replaced by its simulated twin",
        "takes the place of its simulated twin",
    ]
    with pytest.raises(Invalid, match="yard_9"):
        twin(api, "yard_9", is_simulated=True)
    twin(api, "yard_2", is_simulated=False)
    team.tell("yard_2", battery=1.0)
    read_until(api, "/v1/robots/yard_2", lambda one: one["connection"] == "online")
    with pytest.raises(Invalid, match=r"yard_2 is connected .*; disconnect it first"):
        twin(api, "yard_2", is_simulated=True)
    held = {"predicate": "in", "args": ["sample_1", "store_1"]}
    api.put("/v1/worlds/sample_store/facts", json={"facts": [held]}).raise_for_status()
    with pytest.raises(Invalid, match="store_1 holds sample_1"):
        twin(api, "store_1", is_simulated=False)
    team.faults.silent.add("yard_1")
    follow(started(api, follow, "send yard_1 to door_2"), "dispatching", "running", "unknown")
    with pytest.raises(Invalid, match=r"mission .* still needs yard_1; cancel it, or wait for its end"):
        twin(api, "yard_1", is_simulated=False)


def test_the_command_says_that_no_service_answers() -> None:
    with Client(base_url="http://127.0.0.1:9") as nobody, pytest.raises(Invalid, match="state --service"):
        twin(nobody, "yard_1", is_simulated=True)


def test_the_command_says_where_the_token_is_stated(api: TestClient) -> None:
    api.headers["authorization"] = "Bearer another"
    with pytest.raises(Invalid, match="set MACTA_TOKEN"):
        twin(api, "yard_1", is_simulated=None)
