"""What a running mission no longer needs is free again, and goals that wait for it are planned at once."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from tests.app.fake_robots import FakeTeam
from tests.waiting import read_until

Follow = Callable[..., dict[str, Any]]
Thing = dict[str, Any]


def waits(goal: Thing) -> bool:
    return bool(goal["state"] == "waiting")


@pytest.fixture
def half_done(api: TestClient, follow: Follow, team: FakeTeam) -> str:
    """A mission whose yard robot has put sample_1 into interchange_2 while store_2 has not begun."""
    team.faults.stuck.add("store_2")
    mission = start(api, follow, "move sample_1 to bay_7")
    scripts = follow(mission, "running")["progress"]
    (yard,) = (script["robot"] for script in scripts if script["robot"] != "store_2")
    read_until(api, f"/v1/robots/{yard}", lambda robot: robot["mission_id"] is None)
    return f"{mission} {yard}"


def start(api: TestClient, follow: Follow, text: str) -> str:
    goal = post(api, text)
    plan_id = follow(goal, "planned")["plan_id"]
    return f"/v1/missions/{api.post(f'/v1/plans/{plan_id}:approve', json={}).json()['mission_id']}"


def post(api: TestClient, text: str, **more: Any) -> str:
    answer = api.post("/v1/goals", json={"text": text, **more})
    assert answer.status_code == 202, answer.text
    return f"/v1/goals/{answer.json()['id']}"


def ended(goal: dict[str, Any]) -> tuple[str, str]:
    return goal["state"], goal["outcome"]


def test_a_second_mission_starts_on_a_robot_whose_part_of_the_first_is_over(
    api: TestClient, follow: Follow, team: FakeTeam, half_done: str
) -> None:
    first, yard = half_done.split()
    second = read_until(
        api, structured(api, "near", yard, "door_1"), lambda goal: goal["outcome"] or waits(goal)
    )
    assert ended(second) == ("finished", "completed"), second["reason"]
    follow(first, "running")
    assert [robot for robot in api.get(first).json()["progress"] if robot["state"] == "finished"]
    team.faults.stuck.clear()
    assert follow(first, "completed", "failed", "partially_completed")["state"] == "completed"


def structured(api: TestClient, predicate: str, *args: str) -> str:
    body = {"goal": [{"predicate": predicate, "args": args}], "auto_approve": True}
    answer = api.post("/v1/goals", json=body)
    assert answer.status_code == 202, answer.text
    return f"/v1/goals/{answer.json()['id']}"


def test_a_goal_that_waits_for_a_robot_is_planned_when_its_part_is_over_not_when_the_mission_ends(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck |= {"yard_1", "yard_2", "store_2"}
    first = start(api, follow, "move sample_1 to bay_7")
    (yard,) = (
        s["robot"] for s in follow(first, "dispatching", "running")["progress"] if s["robot"] != "store_2"
    )
    goal = structured(api, "near", yard, "door_1")
    waiting = read_until(api, goal, waits)
    assert yard in waiting["reason"]
    team.faults.stuck -= {"yard_1", "yard_2"}
    assert ended(follow(goal, "finished", "unsolvable")) == ("finished", "completed")
    follow(first, "running")


def test_what_the_rest_of_a_mission_needs_stays_its_own(
    api: TestClient, follow: Follow, half_done: str
) -> None:
    first, _ = half_done.split()
    goal = post(api, "move sample_1 to door_2", auto_approve=True)
    waiting = read_until(api, goal, waits)
    for name in ("sample_1", "interchange_2", "store_2", "bay_7"):
        assert name in waiting["reason"]
    assert "door_1" not in waiting["reason"]
    follow(first, "running")


def test_a_goal_that_no_release_would_help_does_not_wait(
    api: TestClient, follow: Follow, half_done: str
) -> None:
    first, _ = half_done.split()
    goal = structured(api, "tracked", "store_1", "yard_1")
    answer = read_until(api, goal, lambda goal: goal["outcome"] or waits(goal))
    assert answer["state"] == "unsolvable", answer["reason"]
    follow(first, "running")
