"""Plans of engines that do not know who may be recruited for a goal."""

from dataclasses import replace

import pytest

from planner import (
    UNOBSERVED,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    load_knowledge_base,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.engines.recruiting import RecruitingEngine
from tests.planner.store import inside, store_problem

BASE = load_knowledge_base()
REQUEST = PlanningRequest(effort_s=0.0)
STORED = inside("sample_1", "bay_7")


class Unaware:
    """Plans with any robots."""

    name = "unaware"

    def __init__(self) -> None:
        self._engine = HierarchicalEngine(BASE)

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        return self._engine.plan(replace(problem, recruits={}), request, observer)


@pytest.fixture(scope="module")
def anybody() -> tuple[str, ...]:
    """The robots of the plan that an unaware engine makes."""
    plan = Unaware().plan(store_problem([STORED]), REQUEST).plan_net
    assert plan is not None
    return plan.robots


def test_a_plan_with_others_than_may_be_recruited_is_not_found(anybody: tuple[str, ...]) -> None:
    others = {"yard_1", "yard_2", "store_2"} - set(anybody) | {"store_2"}
    problem = replace(store_problem([STORED]), recruits={STORED: frozenset(others)})
    found = RecruitingEngine(Unaware(), BASE).plan(problem, REQUEST)
    (wrong,) = set(anybody) - others
    assert (found.status, found.plan_net) == (PlanningStatus.NOT_FOUND, None)
    assert found.reason.startswith(
        f"it found only a plan that is not permitted: {wrong} may not be recruited for "
    )


def test_a_plan_with_those_who_may_be_recruited_stands(anybody: tuple[str, ...]) -> None:
    problem = replace(store_problem([STORED]), recruits={STORED: frozenset(anybody)})
    assert RecruitingEngine(Unaware(), BASE).plan(problem, REQUEST).plan_net is not None
