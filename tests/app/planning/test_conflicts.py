"""Goals whose constraints leave no plan though none of the checks before planning finds them too tight."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from planner import (
    UNOBSERVED,
    Fact,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from tests.app.planning.store_engine import StoreEngine
from tests.app.scripted import InProcessWorker

Follow = Callable[..., dict[str, Any]]
YARD_2 = Fact("can", ("yard_2", "DOCK"))
BAY_3 = Fact("vacant", ("bay_3",))
GONE = Fact("vacant", ("bay_99",))
CONSTRAINTS = {"without": ["yard_2"], "keep_empty": ["bay_3", "bay_4"]}


class NarrowEngine(StoreEngine):
    """Finds no plan without both yard_2 and bay_3, nor without what it needs beside; counts its problems."""

    def __init__(self, status: PlanningStatus) -> None:
        super().__init__()
        self.status = status
        self.needs = frozenset[Fact]()
        self.asked = 0

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        self.asked += 1
        if problem.facts.isdisjoint({YARD_2, BAY_3}) or self.needs - problem.facts:
            return PlanningResult(
                status=self.status, engine=self.name, planning_s=0.0, reason="nothing leads there"
            )
        return super().plan(problem, request, observer)


@pytest.fixture(params=[PlanningStatus.UNSOLVABLE, PlanningStatus.NOT_FOUND], ids=str)
def engine(request: pytest.FixtureRequest) -> NarrowEngine:
    return NarrowEngine(request.param)


@pytest.fixture
def worker(engine: NarrowEngine) -> InProcessWorker:
    return InProcessWorker(engine)


def goal_of(api: TestClient, follow: Follow, state: str, **constraints: Any) -> dict[str, Any]:
    body = {"text": "move sample_1 to bay_7", "constraints": constraints}
    answer = api.post("/v1/goals", json=body)
    assert answer.status_code == 202, answer.text
    assert answer.json()["conflict"] is None
    return follow(f"/v1/goals/{answer.json()['id']}", state)


def test_a_goal_without_a_plan_names_the_fewest_constraints_that_leave_none(
    api: TestClient, follow: Follow, engine: NarrowEngine
) -> None:
    goal = goal_of(api, follow, "unsolvable", **CONSTRAINTS)
    assert goal["conflict"] == {
        "constraints": ["without yard_2", "keeping empty: bay_3"],
        "proven": engine.status is PlanningStatus.UNSOLVABLE,
        "complete": True,
    }
    assert goal["reason"] == "nothing leads there, without yard_2 and keeping empty: bay_3"
    assert goal["outcome"] == engine.status
    assert engine.asked == 1 + 1 + 3  # with all of them, without any, without each


def test_a_goal_that_has_no_plan_without_constraints_either_does_not_blame_them(
    api: TestClient, follow: Follow, engine: NarrowEngine
) -> None:
    engine.needs = frozenset({GONE})
    goal = goal_of(api, follow, "unsolvable", **CONSTRAINTS)
    assert goal["conflict"] is None
    assert goal["reason"] == "nothing leads there, without yard_2 and keeping empty: bay_3 and bay_4"
    assert engine.asked == 2


def test_a_goal_without_constraints_is_planned_once(
    api: TestClient, follow: Follow, engine: NarrowEngine
) -> None:
    engine.needs = frozenset({GONE})
    goal = goal_of(api, follow, "unsolvable")
    assert (goal["conflict"], goal["reason"], engine.asked) == (None, "nothing leads there", 1)


def test_a_goal_with_a_plan_has_no_conflict(api: TestClient, follow: Follow, engine: NarrowEngine) -> None:
    goal = goal_of(api, follow, "planned", keep_empty=["bay_3"])
    assert (goal["conflict"], engine.asked) == (None, 1)
