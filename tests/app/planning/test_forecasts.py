"""How likely deadlines are kept, through the API."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

Follow = Callable[..., dict[str, Any]]
GOAL = {"text": "move sample_1 to bay_7"}


def planned(api: TestClient, follow: Follow, **terms: Any) -> dict[str, Any]:
    answer = api.post("/v1/goals", json={**GOAL, **terms})
    assert answer.status_code == 202, answer.text
    goal = follow(f"/v1/goals/{answer.json()['id']}", "planned")
    plan: dict[str, Any] = api.get(f"/v1/plans/{goal['plan_id']}").json()
    return plan


@pytest.mark.parametrize(
    ("deadline_s", "least", "most"), [(3600.0, 0.99, 1.0), (60.0, 0.001, 0.95), (5.0, 0.0, 0.0)]
)
def test_a_plan_says_how_likely_its_deadline_is_kept(
    api: TestClient, follow: Follow, deadline_s: float, least: float, most: float
) -> None:
    plan = planned(api, follow, deadline_s=deadline_s, objective="on_time")
    likely = plan["forecast"]
    # It sinks with the seconds that planning and the answers take.
    assert least <= likely["on_time"] <= most
    (goal,) = likely["goals"]
    assert goal["goal"] == plan["goals"][0]
    assert goal["on_time"] == pytest.approx(likely["on_time"], abs=1e-3)
    assert goal["p10_s"] < goal["p50_s"] < goal["p90_s"]
    assert goal["p10_s"] < plan["makespan_s"] < goal["p90_s"]
    (beside,) = api.get(f"/v1/goals/{plan['goal_id']}/plans").json()["items"]
    later = api.get(f"/v1/plans/{plan['id']}").json()["forecast"]
    # The deadline comes nearer from one answer to the next.
    assert later["on_time"] <= beside["on_time"] <= likely["on_time"]


def test_without_a_deadline_it_says_only_when(api: TestClient, follow: Follow) -> None:
    plan = planned(api, follow)
    assert plan["forecast"]["on_time"] is None
    assert plan["forecast"]["goals"][0]["on_time"] is None
    assert plan["forecast"]["goals"][0]["p50_s"] > 0


def test_once_a_mission_runs_the_chance_is_that_of_its_start(api: TestClient, follow: Follow) -> None:
    plan = planned(api, follow, deadline_s=60.0)
    approved = api.post(f"/v1/plans/{plan['id']}:approve", json={}).json()
    follow(f"/v1/missions/{approved['mission_id']}", "completed", "failed", "partially_completed")
    mission = api.get(f"/v1/missions/{approved['mission_id']}").json()
    first, second = (api.get(f"/v1/plans/{plan['id']}").json()["forecast"] for _ in range(2))
    assert first == second
    assert first["delay_s"] == pytest.approx(mission["started_at_s"] - first["made_at_s"], abs=0.01)
    listed = api.get("/v1/plans", params={"goal_id": plan["goal_id"]}).json()["items"]
    assert [one["forecast"] for one in listed] == [first]


def test_an_unknown_objective_is_refused_with_the_choices(api: TestClient) -> None:
    refused = api.post("/v1/goals", json={**GOAL, "objective": "luck"})
    assert refused.status_code == 422
    assert "on_time" in refused.text
