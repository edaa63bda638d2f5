"""Plans that operators edit, through the API."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from tests.waiting import read_until

Follow = Callable[..., dict[str, Any]]
Plan = dict[str, Any]
GOAL = {"text": "move sample_1 to bay_7 and sample_2 to bay_3"}


@pytest.fixture
def goal(api: TestClient, follow: Follow) -> dict[str, Any]:
    answer = api.post("/v1/goals", json=GOAL)
    assert answer.status_code == 202, answer.text
    return follow(f"/v1/goals/{answer.json()['id']}", "planned")


@pytest.fixture
def plan(api: TestClient, goal: dict[str, Any]) -> Plan:
    return read(api, goal["plan_id"])


def read(api: TestClient, plan_id: str) -> Plan:
    found: Plan = api.get(f"/v1/plans/{plan_id}").json()
    return found


def handling(plan: Plan, sample: str, robot: str = "yard") -> dict[str, Any]:
    """The first action of a robot of that kind with the sample."""
    return next(
        action
        for action in plan["actions"]
        if sample in action["arguments"].values() and action["agents"][0].startswith(robot)
    )


def hauler(plan: Plan, sample: str) -> str:
    name: str = handling(plan, sample)["agents"][0]
    return name


def other_than(robot: str) -> str:
    return {"yard_1": "yard_2", "yard_2": "yard_1"}[robot]


def edited(api: TestClient, plan: Plan, *edits: dict[str, Any]) -> dict[str, Any]:
    """The goal once the plan was edited."""
    answer = api.post(f"/v1/plans/{plan['id']}:edit", json={"edits": edits})
    assert answer.status_code == 202, answer.text
    assert answer.json()["alternatives"]["edited"] == plan["id"]
    return read_until(
        api, f"/v1/goals/{plan['goal_id']}", lambda goal: goal["alternatives"]["state"] != "seeking"
    )


def newest(api: TestClient, plan: Plan) -> Plan:
    """The open plan of the goal that was made last."""
    items = api.get(f"/v1/goals/{plan['goal_id']}/plans").json()["items"]
    plans = [read(api, one["id"]) for one in items]
    return max(plans, key=lambda one: str(one["created_at"]))


def test_an_edited_plan_waits_for_a_decision_beside_the_plan(api: TestClient, plan: Plan) -> None:
    other = other_than(hauler(plan, "sample_1"))
    goal = edited(api, plan, {"action": handling(plan, "sample_1")["id"], "robot": other})
    assert goal["alternatives"]["state"] == "found"
    assert (goal["state"], goal["plan_id"]) == ("planned", plan["id"])
    new = newest(api, plan)
    assert hauler(new, "sample_1") == other
    assert (new["state"], new["label"]) == ("proposed", f"{other} for in(sample_1, bay_7)")
    assert (new["repairs"]["plan_id"], new["repairs"]["course"]) == (plan["id"], "edited")
    assert new["comparison"] == new["repairs"]["difference"]["words"][0]
    (pin,) = new["edits"]
    assert (pin["goal"]["args"], pin["barred"]) == (["sample_1", "bay_7"], [hauler(plan, "sample_1")])
    assert read(api, plan["id"])["state"] == "proposed"
    answer = api.post(f"/v1/plans/{new['id']}:approve")
    assert answer.status_code == 202
    assert read(api, plan["id"])["state"] == "superseded"


def test_what_is_pinned_stays_pinned_when_the_edited_plan_is_edited(api: TestClient, plan: Plan) -> None:
    mine = hauler(plan, "sample_1")
    edited(api, plan, {"action": handling(plan, "sample_1")["id"], "without": mine})
    first = newest(api, plan)
    action = handling(first, "sample_2", "")["id"]
    edited(api, first, {"action": action, "not_before_s": 3_000})
    second = newest(api, plan)
    assert second["id"] != first["id"]
    assert hauler(second, "sample_1") != mine
    assert second["makespan_s"] > 2_000, "the world's clock goes on while it is planned"
    assert {tuple(pin["goal"]["args"]): pin["barred"] for pin in second["edits"]} == {
        ("sample_1", "bay_7"): [mine],
        ("sample_2", "bay_3"): [],
    }


def achiever(plan: Plan, goal: list[str]) -> dict[str, Any]:
    """The action that achieves a goal with these arguments."""
    link = next(
        one for one in plan["causal_links"] if one["consumer"] == "goal" and one["fact"]["args"] == goal
    )
    return next(action for action in plan["actions"] if action["id"] == link["producer"])


def is_after(plan: Plan, later: list[str], earlier: list[str]) -> bool:
    before = achiever(plan, earlier)
    return bool(achiever(plan, later)["earliest_start_s"] >= before["earliest_end_s"] - 0.01)


FIRST, SECOND = ["sample_1", "bay_7"], ["sample_2", "bay_3"]


def in_another_order(plan: Plan) -> tuple[list[str], list[str], dict[str, Any]]:
    """The goal that the plan achieves first, the other one, and the edit that has it come after that."""
    later, earlier = sorted((FIRST, SECOND), key=lambda goal: achiever(plan, goal)["earliest_end_s"])
    edit = {"action": handling(plan, later[0], "")["id"], "after": handling(plan, earlier[0], "")["id"]}
    return later, earlier, edit


def test_a_goal_comes_true_after_another_and_the_plan_says_why(api: TestClient, plan: Plan) -> None:
    later, earlier, edit = in_another_order(plan)
    assert not is_after(plan, later, earlier)
    assert edited(api, plan, edit)["alternatives"]["state"] == "found"
    new = newest(api, plan)
    assert is_after(new, later, earlier)
    words = f"in({', '.join(later)}) after in({', '.join(earlier)})"
    assert new["label"] == words
    (pin,) = new["edits"]
    assert pin["goal"]["args"] == later
    assert [one["args"] for one in pin["after"]] == [earlier]
    (ordering,) = [one for one in new["orderings"] if one["reason"] == "order"]
    assert ordering["kept_by"] == "clearance"
    action = achiever(new, later)["id"]
    told = api.get(f"/v1/plans/{new['id']}/actions/{action}/explanation").json()
    assert any("the plan is edited so that" in line for line in told["order"])


def test_an_order_stays_pinned_through_edits_and_repairs(api: TestClient, plan: Plan, follow: Follow) -> None:
    later, earlier, edit = in_another_order(plan)
    edited(api, plan, edit)
    first = newest(api, plan)
    edited(api, first, {"action": handling(first, earlier[0], "")["id"], "not_before_s": 3_000})
    second = newest(api, plan)
    assert is_after(second, later, earlier)
    assert achiever(second, later)["earliest_start_s"] > 2_000
    moved = {"facts": [{"predicate": "in", "args": ["sample_1", "door_2"]}]}
    assert api.put("/v1/worlds/sample_store/facts", json=moved).status_code == 200
    assert api.post(f"/v1/plans/{second['id']}:approve").status_code == 409
    follow(f"/v1/goals/{plan['goal_id']}", "planned")
    repaired = newest(api, plan)
    assert repaired["repairs"]["plan_id"] == second["id"]
    assert is_after(repaired, later, earlier)
    assert repaired["edits"] == second["edits"]


def test_an_order_that_contradicts_one_pinned_before_is_refused_with_both(
    api: TestClient, plan: Plan
) -> None:
    later, earlier, edit = in_another_order(plan)
    edited(api, plan, edit)
    new = newest(api, plan)
    against = {"action": handling(new, earlier[0], "")["id"], "after": handling(new, later[0], "")["id"]}
    answer = api.post(f"/v1/plans/{new['id']}:edit", json={"edits": [against]})
    assert (answer.status_code, answer.json()["type"]) == (422, "urn:macta:problem:cannot-edit")
    one, other = (f"in({', '.join(goal)}) ({achiever(new, goal)['id']})" for goal in (later, earlier))
    detail = answer.json()["detail"]
    assert detail.startswith("these orders contradict each other: ")
    assert f"{one} after {other}" in detail
    assert f"{other} after {one}" in detail


def test_orders_of_one_request_that_contradict_each_other_are_refused(api: TestClient, plan: Plan) -> None:
    one, other = (handling(plan, sample, "")["id"] for sample in ("sample_1", "sample_2"))
    edits = [{"action": one, "after": other}, {"action": other, "after": one}]
    answer = api.post(f"/v1/plans/{plan['id']}:edit", json={"edits": edits})
    assert answer.status_code == 422
    assert answer.json()["detail"].startswith("these orders contradict each other: ")


def test_alternatives_found_later_leave_edited_plans_open(api: TestClient, plan: Plan) -> None:
    edited(
        api, plan, {"action": handling(plan, "sample_1")["id"], "robot": other_than(hauler(plan, "sample_1"))}
    )
    new = newest(api, plan)
    api.post(f"/v1/goals/{plan['goal_id']}:alternatives", json={"count": 2})
    read_until(
        api,
        f"/v1/goals/{plan['goal_id']}",
        lambda goal: goal["alternatives"] | {"state": "found"} == goal["alternatives"],
    )
    assert read(api, new["id"])["state"] == "proposed"


def test_a_repair_of_an_edited_plan_keeps_to_the_edit(api: TestClient, plan: Plan, follow: Follow) -> None:
    mine = hauler(plan, "sample_1")
    edited(api, plan, {"action": handling(plan, "sample_1")["id"], "without": mine})
    new = newest(api, plan)
    moved = {"facts": [{"predicate": "in", "args": ["sample_1", "door_2"]}]}
    assert api.put("/v1/worlds/sample_store/facts", json=moved).status_code == 200
    assert api.post(f"/v1/plans/{new['id']}:approve").status_code == 409
    follow(f"/v1/goals/{plan['goal_id']}", "planned")
    repaired = newest(api, plan)
    assert repaired["repairs"]["plan_id"] == new["id"]
    assert hauler(repaired, "sample_1") != mine
    assert repaired["edits"] == new["edits"]


def test_an_edit_without_a_plan_leaves_all_as_it_is_and_says_why(api: TestClient, plan: Plan) -> None:
    goal = edited(api, plan, {"action": handling(plan, "sample_1")["id"], "avoid": "interchange_2"})
    assert goal["alternatives"]["state"] == "failed"
    assert goal["alternatives"]["reason"].startswith("avoiding interchange_2 for in(sample_1, bay_7): ")
    assert read(api, plan["id"])["state"] == "proposed"
    assert len(api.get(f"/v1/goals/{plan['goal_id']}/plans").json()["items"]) == 1


def test_an_interchange_that_leads_elsewhere_is_said_to(api: TestClient, plan: Plan) -> None:
    goal = edited(api, plan, {"action": handling(plan, "sample_1")["id"], "via": "interchange_1"})
    assert goal["alternatives"]["reason"].startswith("via interchange_1 for in(sample_1, bay_7): ")


@pytest.mark.parametrize(
    ("edit", "code", "detail"),
    [
        ({"action": "a99", "robot": "yard_1"}, "cannot-edit", "the plan has no action a99"),
        ({"robot": "store_1"}, "cannot-edit", "store_1 cannot do what yard_"),
        ({"without": "store_1"}, "cannot-edit", "store_1 does nothing for"),
        ({"after": "a99"}, "cannot-edit", "the plan has no action a99"),
        ({"after": "a1", "action": "a1"}, "cannot-edit", "a1 is done for in(sample_"),
        ({"avoid": "nowhere"}, "unknown-place", "there is no place 'nowhere'"),
        ({"avoid": "bay_7"}, "cannot-edit", "is about bay_7, which it cannot avoid"),
        ({"via": "door_1"}, "no-interchange", "samples go through interchange_1 and interchange_2"),
    ],
)
def test_an_edit_that_cannot_be_meant_is_refused_with_what_can(
    api: TestClient, plan: Plan, edit: dict[str, Any], code: str, detail: str
) -> None:
    edit = {"action": handling(plan, "sample_1")["id"]} | edit
    answer = api.post(f"/v1/plans/{plan['id']}:edit", json={"edits": [edit]})
    assert (answer.status_code, answer.json()["type"]) == (422, f"urn:macta:problem:{code}")
    assert detail in answer.json()["detail"]


def test_an_edit_says_something(api: TestClient, plan: Plan) -> None:
    answer = api.post(f"/v1/plans/{plan['id']}:edit", json={"edits": [{"action": "a1"}]})
    assert answer.status_code == 422
    assert "say what is to be otherwise" in answer.text


def test_only_a_plan_that_waits_for_a_decision_is_edited(api: TestClient, plan: Plan) -> None:
    api.post(f"/v1/plans/{plan['id']}:reject")
    body = {"edits": [{"action": "a1", "not_before_s": 9}]}
    answer = api.post(f"/v1/plans/{plan['id']}:edit", json=body)
    assert (answer.status_code, answer.json()["type"]) == (409, "urn:macta:problem:no-open-plan")
    assert api.post("/v1/plans/plan-nobody:edit", json=body).status_code == 404
