"""VAL as a third opinion; skipped where it is not installed."""

from collections.abc import Sequence
from dataclasses import replace

import pytest

from benchmarks.planner.val_validation import is_installed, val_fault
from planner import Fact, KnowledgeBase, PlanNet, PlanNetAction, PlanningProblem
from planner.plan_nets.assembly import assemble
from planner.plan_nets.extraction import extract
from tests.planner.large_store import LargeStore

pytestmark = pytest.mark.skipif(not is_installed(), reason="VAL is not installed")


@pytest.fixture(scope="module")
def solved(knowledge_base: KnowledgeBase) -> tuple[PlanningProblem, PlanNet]:
    store = LargeStore(aisles=2, samples=4)
    problem = store.problem()
    order = extract(store.sequence(problem, knowledge_base), problem.facts, problem.goals)
    return problem, assemble(order, problem.goals, knowledge_base, {})


def with_actions(plan_net: PlanNet, actions: Sequence[PlanNetAction]) -> PlanNet:
    """The plan-net of these actions alone."""
    names = {action.id for action in actions}
    orderings = tuple(o for o in plan_net.orderings if {o.before, o.after} <= names)
    return replace(plan_net, actions=tuple(actions), orderings=orderings)


def test_a_valid_plan_net_has_no_fault(
    knowledge_base: KnowledgeBase, solved: tuple[PlanningProblem, PlanNet]
) -> None:
    problem, plan_net = solved
    assert val_fault(knowledge_base, problem, plan_net) is None


def test_a_missing_action_is_missed(
    knowledge_base: KnowledgeBase, solved: tuple[PlanningProblem, PlanNet]
) -> None:
    problem, plan_net = solved
    fault = val_fault(knowledge_base, problem, with_actions(plan_net, plan_net.actions[1:]))
    assert fault is not None
    assert "unsatisfied precondition" in fault


def test_an_action_longer_than_the_knowledge_base_says_is_found_out(
    knowledge_base: KnowledgeBase, solved: tuple[PlanningProblem, PlanNet]
) -> None:
    problem, plan_net = solved
    slow = replace(plan_net.actions[0], duration_s=plan_net.actions[0].duration_s + 1)
    fault = val_fault(knowledge_base, problem, with_actions(plan_net, [slow, *plan_net.actions[1:]]))
    assert fault is not None
    assert "duration" in fault


def test_a_robot_that_does_two_things_at_once_is_found_out(
    knowledge_base: KnowledgeBase, solved: tuple[PlanningProblem, PlanNet]
) -> None:
    problem, plan_net = solved
    fault = val_fault(knowledge_base, problem, replace(plan_net, orderings=()))
    assert fault is not None


def test_a_goal_that_is_not_reached_is_missed(
    knowledge_base: KnowledgeBase, solved: tuple[PlanningProblem, PlanNet]
) -> None:
    problem, plan_net = solved
    unmet = Fact("tracked", ("yard_0", "yard_1"))
    fault = val_fault(knowledge_base, replace(problem, goals=(*problem.goals, unmet)), plan_net)
    assert fault is not None
    assert "tracked yard_0 yard_1" in fault
