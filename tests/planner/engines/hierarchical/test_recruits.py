"""Goals for which only some robots may be recruited."""

from dataclasses import replace

import pytest

from app.domain.world_model import planning_problem
from planner import Fact, PlanningProblem, PlanningRequest, PlanningStatus
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.explanation.legs import legs_in
from tests.app.sample_store import Store

STORE = Store()
FIRST = STORE.fact("in(sample_1, bay_7)")
SECOND = STORE.fact("in(sample_2, bay_3)")


@pytest.fixture(scope="module")
def problem() -> PlanningProblem:
    return planning_problem(STORE.world, STORE.facts, (FIRST, SECOND), knowledge_base=STORE.base)


def teams(problem: PlanningProblem, **recruits: set[str]) -> dict[Fact, set[str]]:
    """By goal, who works for it."""
    goals = {"first": FIRST, "second": SECOND}
    limited = replace(problem, recruits={goals[name]: frozenset(those) for name, those in recruits.items()})
    result = HierarchicalEngine(STORE.base).plan(limited, PlanningRequest(effort_s=0.0))
    assert result.status is PlanningStatus.SOLVED, result.reason
    assert result.plan_net is not None
    found: dict[Fact, set[str]] = {}
    for leg in legs_in(result.plan_net, problem, STORE.base):
        found.setdefault(leg.goal, set()).update(leg.team)
    return found


@pytest.mark.parametrize("yard", ["yard_1", "yard_2"])
def test_only_those_recruited_for_a_goal_work_for_it(problem: PlanningProblem, yard: str) -> None:
    assert teams(problem, first={yard, "store_2"})[FIRST] == {yard, "store_2"}


def test_a_goal_that_nobody_recruited_can_reach_has_no_plan(problem: PlanningProblem) -> None:
    limited = replace(problem, goals=(FIRST,), recruits={FIRST: frozenset({"yard_1", "store_1"})})
    result = HierarchicalEngine(STORE.base).plan(limited, PlanningRequest(effort_s=0.0))
    assert result.plan_net is None


def test_a_leg_is_what_robots_do_for_a_goal_without_the_way_there(problem: PlanningProblem) -> None:
    result = HierarchicalEngine(STORE.base).plan(problem, PlanningRequest(effort_s=0.0))
    assert result.plan_net is not None
    legs = [leg for leg in legs_in(result.plan_net, problem, STORE.base) if leg.goal == FIRST]
    assert [[action.tag for action in actions] for leg in legs for actions in leg.actions.values()] == [
        ["DOCK", "TRANSPORT", "RELEASE2"]
    ] * 2
