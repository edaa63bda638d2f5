"""What several operators, or one through several replicas, ask at the same instant: the record decides, once."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from threading import Barrier, BrokenBarrierError
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from app.domain.errors import Conflict
from app.planning.approval import Staleness
from app.planning.goal_service import GoalRequest
from tests.databases import ON_BOTH

Follow = Callable[..., dict[str, Any]]
pytestmark = ON_BOTH
AT_ONCE = 4


def at_once(calls: Sequence[Callable[[], Any]]) -> list[Any]:
    """All of them at the same instant, each in a thread; an expected refusal is an answer."""
    together = Barrier(len(calls))

    def call(one: Callable[[], Any]) -> Any:
        together.wait()
        try:
            return one()
        except Conflict as conflict:
            return conflict

    with ThreadPoolExecutor(len(calls)) as threads:
        return list(threads.map(call, calls))


def proposed(api: TestClient, follow: Follow, text: str) -> str:
    goal = api.post("/v1/goals", json={"text": text}).json()
    return str(follow(f"/v1/goals/{goal['id']}", "planned")["plan_id"])


def test_a_plan_approved_several_times_at_once_has_one_mission(
    service: Service, api: TestClient, follow: Follow
) -> None:
    plan_id = proposed(api, follow, "move sample_1 to bay_7")
    answers = at_once([lambda: service.plans.approve(plan_id, actor="someone")[1]] * AT_ONCE)
    assert len(set(answers)) == 1
    assert len(api.get("/v1/missions").json()["items"]) == 1


def test_a_plan_approved_and_rejected_at_once_is_one_of_the_two(
    service: Service, api: TestClient, follow: Follow
) -> None:
    plan_id = proposed(api, follow, "move sample_1 to bay_7")
    answers = at_once(
        [
            lambda: service.plans.approve(plan_id, actor="one"),
            lambda: service.plans.reject(plan_id, actor="other"),
        ]
    )
    assert len([answer for answer in answers if isinstance(answer, Conflict)]) == 1
    approved = api.get(f"/v1/plans/{plan_id}").json()["state"] == "approved"
    assert len(api.get("/v1/missions").json()["items"]) == approved


def test_an_idempotency_key_used_several_times_at_once_is_one_goal(service: Service, api: TestClient) -> None:
    request = GoalRequest(world="sample_store", text="move sample_1 to bay_7")
    goals = at_once([lambda: service.goals.submit(request, actor="someone", key="a key")] * AT_ONCE)
    assert len({goal.id for goal in goals}) == 1
    assert len(api.get("/v1/goals").json()["items"]) == 1


def test_of_two_plans_that_take_the_same_robot_and_are_approved_at_once_one_is_stale(
    service: Service, api: TestClient, follow: Follow, monkeypatch: pytest.MonkeyPatch
) -> None:
    plans = [proposed(api, follow, f"move sample_1 to {place}") for place in ("bay_7", "bay_8")]
    look = Staleness.of
    both_have_looked = Barrier(2)

    def look_and_wait(*given: Any) -> list[str]:
        found = look(*given)
        with suppress(BrokenBarrierError):  # the other cannot look as long as this one holds the world's lock
            both_have_looked.wait(timeout=0.3)
        return found

    monkeypatch.setattr(Staleness, "of", look_and_wait)
    answers = at_once([lambda one=one: service.plans.approve(one, actor="someone") for one in plans])  # type: ignore[misc]
    refused = [answer for answer in answers if isinstance(answer, Conflict)]
    assert [answer.code for answer in refused] == ["plan-stale"]
    assert len(api.get("/v1/missions").json()["items"]) == 1
