"""Goals for which only some robots may be recruited."""

from dataclasses import replace

import pytest

from app.domain.world_model import planning_problem
from planner import Fact, PlanningProblem, PlanningRequest, PlanningStatus, faults_of
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.explanation.legs import barred_actions, legs_in
from planner.repair import NOT_BEGUN, Course, repair
from tests.app.sample_store import Store
from tests.planner.store import inside, store_problem

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


def test_a_robot_that_is_not_recruited_makes_way_for_the_one_that_is() -> None:
    """yard_1 stands at the interchange at which yard_2 is to take the sample over."""
    goal = inside("sample_1", "door_1")
    stated = store_problem([goal], samples={"sample_1": "bay_5"}, robots_at={"yard_1": "interchange_1"})
    limited = replace(stated, recruits={goal: frozenset({"store_1", "store_2", "yard_2"})})
    found = HierarchicalEngine(STORE.base).plan(limited, PlanningRequest(effort_s=0.0)).plan_net
    assert found is not None
    assert not faults_of(found, limited.facts, STORE.base)
    assert [action.tag for action in found.of_robot("yard_1")] == ["NAVIGATE"]
    assert not barred_actions(found, limited, STORE.base)


def test_a_leg_is_what_robots_do_for_a_goal_without_the_way_there(problem: PlanningProblem) -> None:
    result = HierarchicalEngine(STORE.base).plan(problem, PlanningRequest(effort_s=0.0))
    assert result.plan_net is not None
    legs = [leg for leg in legs_in(result.plan_net, problem, STORE.base) if leg.goal == FIRST]
    assert [[action.tag for action in actions] for leg in legs for actions in leg.actions.values()] == [
        ["DOCK", "TRANSPORT", "RELEASE2"]
    ] * 2


def test_a_leg_is_for_the_goal_about_what_it_handles() -> None:
    """store_1 makes way for its second leg by the first: each is for the goal of its own sample all the same."""
    goals = (STORE.fact("in(sample_3, bay_1)"), STORE.fact("in(sample_2, bay_7)"))
    problem = planning_problem(STORE.world, STORE.facts, goals, knowledge_base=STORE.base)
    result = HierarchicalEngine(STORE.base).plan(problem, PlanningRequest(effort_s=0.0))
    assert result.plan_net is not None
    for leg in legs_in(result.plan_net, problem, STORE.base):
        handled = {
            action.arguments["object"]
            for actions in leg.actions.values()
            for action in actions
            if "object" in action.arguments
        }
        assert handled == {leg.goal.args[0]}


def test_a_repair_keeps_no_action_of_a_robot_that_is_no_longer_recruited_for_its_goal(
    problem: PlanningProblem,
) -> None:
    engine = HierarchicalEngine(STORE.base)
    request = PlanningRequest(effort_s=0.0)
    made = engine.plan(replace(problem, recruits={FIRST: frozenset({"yard_1", "store_2"})}), request)
    assert made.plan_net is not None
    kept = repair(engine, STORE.base, made.plan_net, problem, NOT_BEGUN, request)
    assert kept.course is Course.KEPT
    others = replace(problem, recruits={FIRST: frozenset({"yard_2", "store_2"})})
    mended = repair(engine, STORE.base, made.plan_net, others, NOT_BEGUN, request)
    assert mended.plan_net is not None
    assert mended.plan_net.robots == ("store_1", "store_2", "yard_2")
