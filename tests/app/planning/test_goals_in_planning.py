"""Goals while they are planned: progress, stop, cancel, limits."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from app.planning.pool.pool import PlanningWorker
from tests.app.planning.fake_engine import make_patient_engine
from tests.waiting import awaited, read_until, until

Follow = Callable[..., dict[str, Any]]
GOAL = {"text": "move sample_1 to bay_7", "time_limit_s": 120}


@pytest.fixture(scope="module")
def worker() -> Iterator[PlanningWorker]:
    worker = PlanningWorker(make_patient_engine)
    worker.warm_up().result(timeout=300)
    yield worker
    worker.close()


def post(api: TestClient, **goal: Any) -> str:
    answer = api.post("/v1/goals", json=goal)
    assert answer.status_code == 202, answer.text
    return f"/v1/goals/{answer.json()['id']}"


def with_progress(api: TestClient, goal: str) -> dict[str, Any]:
    """The goal, once something is known of its planning."""
    return read_until(api, goal, lambda thing: thing["planning"] is not None)


def test_a_goal_tells_how_its_planning_goes_and_its_best_plan_can_be_taken(
    api: TestClient, follow: Follow, service: Service
) -> None:
    goal = post(api, **GOAL, effort_s=60, objective="robots")
    planning = with_progress(api, goal)["planning"]
    assert planning["engine"] == "patient"
    assert planning["makespan_s"] > planning["lower_bound_s"] > 0
    told = awaited(lambda: told_of(service), lambda told: len(told) >= 2)
    assert api.post(f"{goal}:stop").status_code == 202
    assert api.post(f"{goal}:stop").status_code == 202
    ended = follow(goal, "planned")
    assert ended["planning"] is None
    plan = api.get(f"/v1/plans/{ended['plan_id']}").json()
    assert plan["engine"] == "robots 60.0"
    assert plan["lower_bound_s"] >= told[-1]["lower_bound_s"] > told[0]["lower_bound_s"]


def told_of(service: Service) -> list[dict[str, Any]]:
    return [event.data for event in service.events.since(0) if event.type == "goal.progress"]


def test_a_goal_that_is_cancelled_while_it_is_planned_is_withdrawn_and_its_work_ends(
    api: TestClient, follow: Follow, worker: PlanningWorker
) -> None:
    goal = post(api, **GOAL)
    with_progress(api, goal)
    (before,) = worker.pids
    answer = api.post(f"{goal}:cancel", json={"comment": "not today"})
    assert (answer.status_code, answer.json()["state"]) == (202, "withdrawn")
    assert answer.json()["reason"] == "cancelled: not today"
    assert api.post(f"{goal}:cancel").json()["outcome"] == "cancelled"
    until(lambda: before not in worker.pids)
    after = post(api, text="move sample_1 to bay_8", time_limit_s=0.2)
    assert follow(after, "planned", "unsolvable")["state"] == "planned"
    assert api.get(goal).json()["state"] == "withdrawn"


def test_a_goal_whose_plan_is_proposed_may_be_cancelled_and_its_plan_expires(
    api: TestClient, follow: Follow
) -> None:
    goal = follow(post(api, text="move sample_1 to bay_7", time_limit_s=0.2), "planned")
    assert api.post(f"/v1/goals/{goal['id']}:cancel").json()["state"] == "withdrawn"
    plan = f"/v1/plans/{goal['plan_id']}"
    assert api.get(plan).json()["state"] == "expired"
    assert api.post(f"{plan}:approve").status_code == 409


def test_a_goal_that_is_carried_out_is_cancelled_by_its_mission(api: TestClient, follow: Follow) -> None:
    goal = follow(post(api, text="move sample_1 to bay_7", time_limit_s=0.2), "planned")
    mission_id = api.post(f"/v1/plans/{goal['plan_id']}:approve").json()["mission_id"]
    refusal = api.post(f"/v1/goals/{goal['id']}:cancel")
    assert refusal.status_code == 409
    if "carried out" in refusal.json()["detail"]:
        assert mission_id in refusal.json()["detail"]


def test_limits_beyond_the_installations_are_refused_with_the_bound(api: TestClient) -> None:
    for name in ("time_limit_s", "effort_s"):
        refusal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", name: 601})
        assert refusal.status_code == 422
        assert "600" in refusal.json()["detail"]
    assert (
        api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "objective": "beauty"}).status_code
        == 422
    )
    assert api.post("/v1/goals/nothing:stop").status_code == 404
    assert api.post("/v1/goals/nothing:cancel").status_code == 404


def test_a_goal_whose_turn_has_not_come_can_be_cancelled(api: TestClient, follow: Follow) -> None:
    goals = [post(api, text=f"move sample_1 to bay_{bay}", time_limit_s=120) for bay in (7, 8)]
    until(lambda: any(api.get(goal).json()["planning"] is not None for goal in goals))
    for goal in goals:
        assert api.post(f"{goal}:cancel").json()["state"] == "withdrawn"
    last = follow(post(api, text="move sample_1 to bay_9", time_limit_s=0.2), "planned", "unsolvable")
    assert last["state"] == "planned"


def test_approving_a_plan_ends_the_search_for_others(
    api: TestClient, follow: Follow, worker: PlanningWorker
) -> None:
    goal = post(api, **GOAL)
    with_progress(api, goal)
    api.post(f"{goal}:stop")
    plan_id = follow(goal, "planned")["plan_id"]
    assert api.post(f"{goal}:alternatives").json()["alternatives"]["state"] == "seeking"
    assert api.post(f"{goal}:alternatives", json={"count": 9}).json()["alternatives"]["count"] == 4
    with_progress(api, goal)
    (before,) = worker.pids
    assert api.post(f"/v1/plans/{plan_id}:approve").status_code == 202
    until(lambda: before not in worker.pids and api.get(goal).json()["planning"] is None)
    ended = api.get(goal).json()
    assert (ended["plan_id"], ended["alternatives"]) == (plan_id, None)
