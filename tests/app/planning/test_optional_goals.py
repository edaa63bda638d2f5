"""Goals of which some may be left out, through the API."""

from collections.abc import Callable
from typing import Any

from fastapi.testclient import TestClient

from tests.waiting import read_until

Follow = Callable[..., dict[str, Any]]
STORED = {"predicate": "in", "args": ["sample_1", "bay_7"]}
OTHER = {"predicate": "in", "args": ["sample_2", "bay_3"]}
THIRD = {"predicate": "in", "args": ["sample_4", "bay_8"]}


def stated(api: TestClient, follow: Follow, worth: list[float | None], **more: Any) -> dict[str, Any]:
    """The goal of storing sample_1, moving two samples to other bays, once it is planned."""
    goal = {"goal": [STORED, OTHER, THIRD], "constraints": {"worth": worth}, **more}
    answer = api.post("/v1/goals", json=goal)
    assert answer.status_code == 202, answer.text
    return follow(f"/v1/goals/{answer.json()['id']}", "planned", "unsolvable")


def plan_of(api: TestClient, goal: dict[str, Any]) -> dict[str, Any]:
    plan: dict[str, Any] = api.get(f"/v1/plans/{goal['plan_id']}").json()
    return plan


def test_with_time_enough_everything_is_achieved(api: TestClient, follow: Follow) -> None:
    plan = plan_of(api, stated(api, follow, [None, 5, 2], deadline_s=3600))
    assert plan["goals"] == [STORED, OTHER, THIRD]
    assert (plan["value"], plan["value_bound"], plan["left_out"]) == (7, 7, [])


def test_what_is_left_out_for_the_deadline_is_told_and_stays_out_to_the_end(
    api: TestClient, follow: Follow
) -> None:
    goal = stated(api, follow, [5, None, 2], deadline_s=40)
    plan = plan_of(api, goal)
    assert plan["goals"] == [OTHER, THIRD]
    (left_out,) = plan["left_out"]
    assert (left_out["goal"], left_out["value"]) == (STORED, 5)
    assert left_out["reason"] == "no plan is quick enough for it"
    assert (plan["value"], plan["value_bound"]) == (2, 2)
    assert goal["reason"].endswith("leaves out in(sample_1, bay_7) (no plan is quick enough for it)")
    assert goal["constraints"]["worth"] == [5, None, 2]
    explained = api.get(f"/v1/plans/{plan['id']}/explanation")
    assert explained.status_code == 200, explained.text
    approved = api.post(f"/v1/plans/{plan['id']}:approve", json={}).json()
    mission = follow(f"/v1/missions/{approved['mission_id']}", "completed", "failed", "partially_completed")
    assert mission["state"] == "completed"
    facts = api.get("/v1/worlds/sample_store/facts").json()["items"]
    lying = {tuple(fact["args"]) for fact in facts if fact["predicate"] == "in"}
    assert ("sample_2", "bay_3") in lying
    assert ("sample_1", "bay_7") not in lying


def test_alternatives_leave_out_what_the_proposed_plan_does(api: TestClient, follow: Follow) -> None:
    goal = stated(api, follow, [5, None, 2], deadline_s=40)
    api.post(f"/v1/goals/{goal['id']}:alternatives", json={"count": 3})
    read_until(api, f"/v1/goals/{goal['id']}", lambda goal: goal["alternatives"]["state"] != "seeking")
    for one in api.get(f"/v1/goals/{goal['id']}/plans").json()["items"]:
        plan = api.get(f"/v1/plans/{one['id']}").json()
        assert plan["goals"] == [OTHER, THIRD]
        assert [left_out["goal"] for left_out in plan["left_out"]] == [STORED]


def test_if_nothing_optional_can_be_achieved_there_is_no_plan(api: TestClient, follow: Follow) -> None:
    goal = stated(api, follow, [5, 5, 5], deadline_s=0.5)
    assert (goal["state"], goal["outcome"]) == ("unsolvable", "not_found")
    assert "none of the optional goals" in goal["reason"]


def test_worth_is_checked(api: TestClient) -> None:
    few = api.post("/v1/goals", json={"goal": [STORED, OTHER], "constraints": {"worth": [1]}})
    assert (few.status_code, few.json()["type"]) == (422, "urn:macta:problem:worth-of-other-goals")
    for wrong in (0, -1, "much"):
        answer = api.post("/v1/goals", json={"goal": [STORED], "constraints": {"worth": [wrong]}})
        assert answer.status_code == 422
    tendered = api.post(
        "/v1/goals",
        json={"goal": [STORED], "constraints": {"worth": [1]}, "allocation": "contract_net"},
    )
    assert tendered.json()["type"] == "urn:macta:problem:optional-goals-not-tendered"
