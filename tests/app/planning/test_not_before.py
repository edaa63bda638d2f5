"""Missions whose goal is not to be true before a time, through the API with robots that finish at once."""

from collections.abc import Callable
from typing import Any

from fastapi.testclient import TestClient

from tests.app.fake_robots import TICK_S, FakeTeam
from tests.waiting import until

Follow = Callable[..., dict[str, Any]]
GOAL = {"text": "move sample_2 to bay_3"}


def test_a_goal_does_not_become_true_before_its_time(api: TestClient, follow: Follow, team: FakeTeam) -> None:
    team.tick_s = 0.0  # planning and delivery take time that is not the world's
    answer = api.post("/v1/goals", json={**GOAL, "not_before_s": 60.0})
    assert answer.status_code == 202, answer.text
    goal = follow(f"/v1/goals/{answer.json()['id']}", "planned")
    at_s = goal["not_before_at_s"]
    plan = api.get(f"/v1/plans/{goal['plan_id']}").json()
    (last,) = [one for one in plan["actions"] if one["not_before_s"] > 0]
    assert last["earliest_start_s"] >= last["not_before_s"] > 30.0
    approved = api.post(f"/v1/plans/{plan['id']}:approve", json={}).json()
    until(lambda: all(name in team.robots and team.robots[name].script for name in plan["robots"]))
    team.tick_s = TICK_S
    mission = follow(f"/v1/missions/{approved['mission_id']}", "completed", "failed", "partially_completed")
    assert mission["state"] == "completed", mission
    packets = [packet for script in mission["progress"] for packet in script["packets"]]
    (waited,) = [packet for packet in packets if packet["id"] == last["id"]]
    assert waited["started_at_s"] >= at_s
    assert all(packet["started_at_s"] < at_s for packet in packets if packet["id"] != last["id"])


def test_it_cannot_be_due_before_it_may_be_true(api: TestClient) -> None:
    refused = api.post("/v1/goals", json={**GOAL, "not_before_s": 60.0, "deadline_s": 30.0})
    assert (refused.status_code, refused.json()["type"]) == (422, "urn:macta:problem:due-before-it-may-be")
