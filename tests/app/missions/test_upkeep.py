"""Robots that went home by themselves are believed to be there, and are planned with from there."""

from collections.abc import Callable
from typing import Any

from fastapi.testclient import TestClient

from robots.wire import PacketState, SymbolicFact, UpkeepReport
from tests.app.fake_robots import FakeTeam
from tests.waiting import until

Follow = Callable[..., dict[str, Any]]
NEAR_HOME = SymbolicFact(predicate="near", args=("yard_1", "home_yard_1"))
FACTS = "/v1/worlds/sample_store/facts"


def positions(api: TestClient, robot: str) -> list[tuple[str, str]]:
    facts = api.get(FACTS).json()["items"]
    return [
        (one["predicate"], one["args"][1])
        for one in facts
        if one["args"][:1] == [robot] and len(one["args"]) == 2 and one["predicate"] in ("near", "at")
    ]


def moved(api: TestClient, robot: str, place: str) -> None:
    until(lambda: positions(api, robot) == [("near", place)])


def upkeep(state: PacketState, *perceived: SymbolicFact, at_s: float = 1e6) -> UpkeepReport:
    return UpkeepReport(tag="SEEK_CHARGER", state=state, at_s=at_s, perceived=perceived)


def at_door_1(api: TestClient) -> None:
    said = {"facts": [{"predicate": "near", "args": ["yard_1", "door_1"]}]}
    assert api.put(FACTS, json=said).status_code == 200


def test_a_robot_that_went_home_by_itself_is_believed_there_and_recruited_from_there(
    api: TestClient, team: FakeTeam, follow: Follow
) -> None:
    at_door_1(api)
    team.report("yard_1", upkeep(PacketState.RUNNING))
    moved(api, "yard_1", "yard_1_spot")
    team.report("yard_1", upkeep(PacketState.FINISHED, NEAR_HOME))
    moved(api, "yard_1", "home_yard_1")
    goal = api.post("/v1/goals", json={"goal": [{"predicate": "near", "args": ["yard_1", "door_2"]}]}).json()
    planned = follow(f"/v1/goals/{goal['id']}", "planned")
    actions = api.get(f"/v1/plans/{planned['plan_id']}").json()["actions"]
    assert [(one["arguments"]["ref1"], one["arguments"]["ref2"]) for one in actions] == [
        ("home_yard_1", "door_2")
    ]


def test_a_plan_from_where_the_robot_no_longer_is_is_overtaken(
    api: TestClient, team: FakeTeam, follow: Follow
) -> None:
    at_door_1(api)
    goal = api.post("/v1/goals", json={"text": "move sample_1 to interchange_1"}).json()
    plan = follow(f"/v1/goals/{goal['id']}", "planned")["plan_id"]
    assert "yard_1" in api.get(f"/v1/plans/{plan}").json()["robots"]
    team.report("yard_1", upkeep(PacketState.RUNNING))
    moved(api, "yard_1", "yard_1_spot")
    assert api.post(f"/v1/plans/{plan}:approve", json={}).status_code == 409


def test_what_is_older_than_what_is_known_of_a_robot_changes_nothing(api: TestClient, team: FakeTeam) -> None:
    team.clock.advance(50.0)
    at_door_1(api)
    team.report("yard_1", upkeep(PacketState.FINISHED, NEAR_HOME, at_s=40.0))
    team.report("yard_2", upkeep(PacketState.RUNNING))
    moved(api, "yard_2", "yard_2_spot")
    assert positions(api, "yard_1") == [("near", "door_1")]
