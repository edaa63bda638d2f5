"""Constraints that plans may break at a cost, through the API."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from planner import load_knowledge_base, warm_up
from planner.engines.registry import engine_named
from tests.app.scripted import InProcessWorker
from tests.waiting import read_until

Follow = Callable[..., dict[str, Any]]
STORE = "move sample_1 to bay_7"
STORED = {"predicate": "in", "args": ["sample_1", "bay_7"]}


@pytest.fixture(scope="module")
def worker() -> InProcessWorker:
    """Plans with the engine that ships: which plans are shorter is what counts here."""
    engine = engine_named("macta", load_knowledge_base())
    warm_up(engine)
    return InProcessWorker(engine)


def planned(api: TestClient, follow: Follow, text: str, **more: Any) -> dict[str, Any]:
    answer = api.post("/v1/goals", json={"text": text, **more})
    assert answer.status_code == 202, answer.text
    return follow(f"/v1/goals/{answer.json()['id']}", "planned", "unsolvable")


def plan_of(api: TestClient, goal: dict[str, Any]) -> dict[str, Any]:
    assert goal["state"] == "planned", goal["reason"]
    plan: dict[str, Any] = api.get(f"/v1/plans/{goal['plan_id']}").json()
    return plan


def busy_yard_robot(api: TestClient, follow: Follow) -> str:
    """The yard robot of the shortest plan."""
    (robot,) = [one for one in plan_of(api, planned(api, follow, STORE))["robots"] if one.startswith("yard")]
    return str(robot)


def test_what_costs_more_than_the_detour_is_kept_and_explained(api: TestClient, follow: Follow) -> None:
    robot = busy_yard_robot(api, follow)
    goal = planned(api, follow, f"{STORE} preferably without {robot} (cost 100)")
    plan = plan_of(api, goal)
    assert robot not in plan["robots"]
    assert plan["preferences"] == {
        "outcomes": [
            {
                "preference": f"preferably without {robot}",
                "cost_s": 100.0,
                "kept": True,
                "reason": "",
                "longer_s": None,
                "longer_at_least_s": 0.0,
            }
        ],
        "cost_s": 0.0,
        "bound_s": pytest.approx(plan["makespan_s"], abs=0.1),
        "cut_short": False,
    }
    assert goal["constraints"]["preferences"][0]["without"] == [robot]
    explained = api.get(f"/v1/plans/{plan['id']}/explanation").json()
    (cost,) = explained["constraints"]
    assert cost["constraint"] == f"preferably without {robot}"
    assert cost["at_least_s"] > 1.0


def test_what_costs_less_is_broken_and_told_to_the_end(api: TestClient, follow: Follow) -> None:
    robot = busy_yard_robot(api, follow)
    goal = planned(api, follow, f"{STORE} preferably without {robot} (cost 2)")
    plan = plan_of(api, goal)
    assert robot in plan["robots"]
    (outcome,) = plan["preferences"]["outcomes"]
    assert not outcome["kept"]
    assert plan["preferences"]["cost_s"] == 2.0
    assert outcome["longer_s"] > 2.0
    assert outcome["longer_at_least_s"] > 2.0
    assert goal["reason"] == f"does not keep “preferably without {robot}” ({outcome['reason']})"
    explained = api.get(f"/v1/plans/{plan['id']}/explanation").json()
    assert explained["constraints"] == [], "what is not kept costs the plan nothing"
    approved = api.post(f"/v1/plans/{plan['id']}:approve", json={}).json()
    mission = follow(f"/v1/missions/{approved['mission_id']}", "completed", "failed", "partially_completed")
    assert mission["state"] == "completed"


def test_what_cannot_be_kept_is_left_out_with_the_reason_and_a_check_says_so(
    api: TestClient, follow: Follow
) -> None:
    text = "send yard_2 to door_2 preferably without yard_2 and preferably avoiding bay_1 (cost 5)"
    checked = api.post("/v1/goals:check", json={"text": text}).json()
    assert checked["issue"] is None
    impossible, possible = checked["preferences"]
    assert (impossible["preference"], impossible["cost_s"]) == ("preferably without yard_2", 60.0)
    assert impossible["conflict"] == "near(yard_2, door_2) needs yard_2, which is not to act"
    assert (possible["preference"], possible["conflict"]) == ("preferably avoiding bay_1", "")
    first, second = plan_of(api, planned(api, follow, text))["preferences"]["outcomes"]
    assert not first["kept"]
    assert first["reason"].startswith("no plan keeps it: ")
    assert second["kept"]


def test_preferences_are_stated_as_facts_and_checked(api: TestClient, follow: Follow) -> None:
    given = {"goal": [STORED], "constraints": {"preferences": [{"keep_empty": ["bay_7"]}]}}
    answer = api.post("/v1/goals", json=given)
    goal = follow(f"/v1/goals/{answer.json()['id']}", "planned", "unsolvable")
    (outcome,) = plan_of(api, goal)["preferences"]["outcomes"]
    assert (outcome["preference"], outcome["cost_s"], outcome["kept"]) == (
        "preferably keeping empty: bay_7",
        60.0,
        False,
    )
    for wrong in ({}, {"avoid": ["bay_1"], "without": ["yard_1"]}, {"avoid": ["bay_1"], "cost_s": 0}):
        refused = api.post("/v1/goals", json={"goal": [STORED], "constraints": {"preferences": [wrong]}})
        assert refused.status_code == 422
    unknown = {"goal": [STORED], "constraints": {"preferences": [{"without": ["yard_9"]}]}}
    assert api.post("/v1/goals", json=unknown).json()["type"] == "urn:macta:problem:unknown-robot"
    many = [{"avoid": [f"bay_{number}"]} for number in range(1, 10)]
    refused = api.post("/v1/goals", json={"goal": [STORED], "constraints": {"preferences": many}})
    assert (refused.status_code, refused.json()["type"]) == (
        422,
        "urn:macta:problem:too-many-preferences",
    )


def test_alternatives_keep_what_the_proposed_plan_keeps(api: TestClient, follow: Follow) -> None:
    robot = busy_yard_robot(api, follow)
    goal = planned(
        api, follow, f"{STORE} preferably without {robot} (cost 100) preferably without store_2 (cost 1)"
    )
    api.post(f"/v1/goals/{goal['id']}:alternatives", json={"count": 3})
    read_until(api, f"/v1/goals/{goal['id']}", lambda goal: goal["alternatives"]["state"] != "seeking")
    plans = api.get(f"/v1/goals/{goal['id']}/plans").json()["items"]
    assert plans
    for one in plans:
        plan = api.get(f"/v1/plans/{one['id']}").json()
        assert robot not in plan["robots"]
        assert [outcome["kept"] for outcome in plan["preferences"]["outcomes"]] == [
            True,
            "store_2" not in plan["robots"],
        ]


def test_an_edit_goes_before_a_preference(api: TestClient, follow: Follow) -> None:
    robot = busy_yard_robot(api, follow)
    goal = planned(api, follow, f"{STORE} preferably without {robot} (cost 100)")
    plan = plan_of(api, goal)
    moved = next(action for action in plan["actions"] if action["tag"] == "TRANSPORT")
    edit = {"edits": [{"action": moved["id"], "robot": robot}]}
    answer = api.post(f"/v1/plans/{plan['id']}:edit", json=edit)
    assert answer.status_code == 202, answer.text
    found = read_until(
        api, f"/v1/goals/{goal['id']}", lambda goal: goal["alternatives"]["state"] != "seeking"
    )
    assert found["alternatives"]["state"] == "found", found["alternatives"]["reason"]
    others = [
        api.get(f"/v1/plans/{one['id']}").json()
        for one in api.get(f"/v1/goals/{goal['id']}/plans").json()["items"]
        if one["id"] != plan["id"]
    ]
    (edited,) = others
    assert robot in edited["robots"]
    assert [outcome["kept"] for outcome in edited["preferences"]["outcomes"]] == [False]
