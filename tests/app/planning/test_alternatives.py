"""A goal's plans to choose from, and why a plan is as it is, through the API."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from tests.waiting import read_until

Follow = Callable[..., dict[str, Any]]
GOAL = {"text": "move sample_1 to bay_7"}


def planned(api: TestClient, follow: Follow, **more: Any) -> dict[str, Any]:
    answer = api.post("/v1/goals", json=GOAL | more)
    assert answer.status_code == 202, answer.text
    return follow(f"/v1/goals/{answer.json()['id']}", "planned")


def searched(api: TestClient, goal_id: str, count: int = 4) -> dict[str, Any]:
    """The goal once alternatives were sought."""
    answer = api.post(f"/v1/goals/{goal_id}:alternatives", json={"count": count})
    assert answer.status_code == 202, answer.text
    assert answer.json()["alternatives"]["count"] == count
    return read_until(api, f"/v1/goals/{goal_id}", lambda goal: goal["alternatives"]["state"] != "seeking")


def choices(api: TestClient, goal_id: str) -> list[dict[str, Any]]:
    items: list[dict[str, Any]] = api.get(f"/v1/goals/{goal_id}/plans").json()["items"]
    return items


def test_alternatives_are_plans_of_which_one_is_approved_and_the_others_are_superseded(
    api: TestClient, follow: Follow
) -> None:
    goal = planned(api, follow)
    (proposed,) = choices(api, goal["id"])
    assert (proposed["id"], proposed["label"]) == (goal["plan_id"], "")
    found = searched(api, goal["id"])
    assert (found["state"], found["plan_id"]) == ("planned", goal["plan_id"])
    assert found["alternatives"] == {"state": "found", "count": 4, "reason": "", "edited": None}
    beside = choices(api, goal["id"])
    assert beside[0]["label"].startswith("shortest time")
    assert goal["plan_id"] in [one["id"] for one in beside]
    (other,) = [one for one in beside if "without yard_1" in one["label"]]
    assert other["robots"] == ["store_2", "yard_2"]
    assert "yard_2 instead of yard_1" in other["comparison"]
    assert other["makespan_s"] > beside[0]["makespan_s"]
    whole = api.get(f"/v1/plans/{other['id']}").json()
    spells = [
        [action["earliest_start_s"], action["earliest_end_s"], action["tag"]]
        for action in whole["actions"]
        if "yard_2" in action["agents"]
    ]
    assert other["lanes"]["yard_2"] == sorted(spells)
    assert (whole["state"], whole["label"]) == ("proposed", other["label"])
    answer = api.post(f"/v1/plans/{other['id']}:approve")
    assert answer.status_code == 202
    assert set(answer.json()["robots"]) == {"store_2", "yard_2"}
    committed = api.get(f"/v1/goals/{goal['id']}").json()
    assert committed["plan_id"] == other["id"]
    assert committed["alternatives"] is None
    for one in beside:
        plan = api.get(f"/v1/plans/{one['id']}").json()
        if one["id"] != other["id"]:
            assert (plan["state"], plan["reason"]) == ("superseded", f"plan {other['id']} was approved")
            assert api.post(f"/v1/plans/{one['id']}:approve").status_code == 409


def test_asking_again_keeps_the_plans_that_are_still_the_best(api: TestClient, follow: Follow) -> None:
    goal = planned(api, follow)
    searched(api, goal["id"])
    before = choices(api, goal["id"])
    searched(api, goal["id"], count=5)
    assert choices(api, goal["id"]) == before
    searched(api, goal["id"], count=1)
    assert len(choices(api, goal["id"])) < len(before)


def test_a_goal_is_withdrawn_with_the_last_of_its_plans(api: TestClient, follow: Follow) -> None:
    goal = planned(api, follow)
    searched(api, goal["id"])
    left = choices(api, goal["id"])
    while len(left) > 1:
        assert api.post(f"/v1/plans/{left[0]['id']}:reject").status_code == 202
        left = left[1:]
        now = api.get(f"/v1/goals/{goal['id']}").json()
        assert now["state"] == "planned"
        assert now["plan_id"] in [one["id"] for one in left]
        assert [one["id"] for one in choices(api, goal["id"])] == [one["id"] for one in left]
    api.post(f"/v1/plans/{left[0]['id']}:reject")
    assert api.get(f"/v1/goals/{goal['id']}").json()["state"] == "withdrawn"


def test_a_cancelled_goal_has_no_plan_left_to_decide_on(api: TestClient, follow: Follow) -> None:
    goal = planned(api, follow)
    searched(api, goal["id"])
    plans = [one["id"] for one in choices(api, goal["id"])]
    assert api.post(f"/v1/goals/{goal['id']}:cancel").json()["state"] == "withdrawn"
    assert {api.get(f"/v1/plans/{plan}").json()["state"] for plan in plans} == {"expired"}


def test_only_an_open_plan_has_alternatives(api: TestClient, follow: Follow) -> None:
    goal = planned(api, follow)
    api.post(f"/v1/plans/{goal['plan_id']}:reject")
    refusal = api.post(f"/v1/goals/{goal['id']}:alternatives")
    assert (refusal.status_code, refusal.json()["type"]) == (409, "urn:macta:problem:no-open-plan")
    assert api.post("/v1/goals/nothing:alternatives").status_code == 404
    assert api.get("/v1/goals/nothing/plans").status_code == 404
    assert api.post(f"/v1/goals/{goal['id']}:alternatives", json={"count": 0}).status_code == 422
    assert [one["state"] for one in choices(api, goal["id"])] == ["rejected"]


def test_when_the_world_has_changed_all_open_plans_expire_together(api: TestClient, follow: Follow) -> None:
    goal = planned(api, follow)
    searched(api, goal["id"])
    plans = [one["id"] for one in choices(api, goal["id"])]
    moved = {"facts": [{"predicate": "in", "args": ["sample_1", "interchange_1"]}]}
    assert api.put("/v1/worlds/sample_store/facts", json=moved).status_code == 200
    assert api.post(f"/v1/plans/{plans[-1]}:approve").status_code == 409
    assert {api.get(f"/v1/plans/{plan}").json()["state"] for plan in plans} == {"expired"}
    again = follow(f"/v1/goals/{goal['id']}", "planned", "unsolvable")
    assert again["alternatives"] is None
    assert again["plan_id"] not in plans


def test_a_plan_explains_itself_and_what_its_robots_are_worth(api: TestClient, follow: Follow) -> None:
    goal = planned(api, follow)
    path = f"/v1/plans/{goal['plan_id']}"
    plan, why = api.get(path).json(), api.get(f"{path}/explanation").json()
    assert [one["action"] for one in why["actions"]] == [action["id"] for action in plan["actions"]]
    assert set(why["robots"]) == set(plan["robots"])
    assert "yard_2 instead of yard_1: +" in why["robots"]["yard_1"]
    assert "no robot reaches bay_7" in why["robots"]["store_2"]
    last = plan["actions"][-1]["id"]
    one = api.get(f"{path}/actions/{last}/explanation").json()
    assert one == why["actions"][-1]
    assert one["goals"] == [{"predicate": "in", "args": ["sample_1", "bay_7"]}]
    assert one["because"][-1].endswith("sample_1 is in bay_7: a goal")
    missing = api.get(f"{path}/actions/a99/explanation")
    assert (missing.status_code, last in missing.json()["choices"]) == (404, True)
    assert api.get("/v1/plans/nothing/explanation").status_code == 404


def test_a_plan_explains_what_each_of_its_constraints_costs(api: TestClient, follow: Follow) -> None:
    given = {"without": ["yard_1"], "avoid": ["bay_3"], "keep_empty": ["bay_9"]}
    free, goal = planned(api, follow), planned(api, follow, constraints=given)
    path = f"/v1/plans/{goal['plan_id']}"
    saved_s = (
        api.get(path).json()["makespan_s"] - api.get(f"/v1/plans/{free['plan_id']}").json()["makespan_s"]
    )
    costs = {one["constraint"]: one for one in api.get(f"{path}/explanation").json()["constraints"]}
    assert list(costs) == ["without yard_1", "avoiding bay_3", "keeping empty: bay_9"]
    assert costs["without yard_1"]["at_least_s"] == pytest.approx(saved_s)
    assert [one["at_least_s"] for one in costs.values()][1:] == [0.0, 0.0]
    assert all(one["words"] for one in costs.values())


def test_an_explanation_is_kept_and_one_asked_for_too_late_leaves_the_costs_out(
    api: TestClient, follow: Follow
) -> None:
    kept, late = planned(api, follow), planned(api, follow)
    path = f"/v1/plans/{kept['plan_id']}/explanation"
    before = api.get(path).json()
    for goal in (kept, late):
        api.post(f"/v1/plans/{goal['plan_id']}:reject")
    assert api.get(path).json() == before
    why = api.get(f"/v1/plans/{late['plan_id']}/explanation").json()
    assert why["robots"] == {}
    assert why["makespan"] == before["makespan"]
