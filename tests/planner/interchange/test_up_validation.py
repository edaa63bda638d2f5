"""unified-planning's validator as a second opinion, on plan-nets longer than one stretch."""

from dataclasses import replace

import pytest

from planner import Fact, KnowledgeBase, PlanNet, PlanningProblem
from planner.interchange.up_validation import STRETCH, up_fault
from planner.plan_nets.assembly import assemble
from planner.plan_nets.extraction import extract
from tests.planner.large_store import LargeStore
from tests.planner.store import inside


@pytest.fixture(scope="module")
def solved(knowledge_base: KnowledgeBase) -> tuple[PlanningProblem, PlanNet]:
    store = LargeStore(aisles=4, samples=16)
    problem = store.problem()
    order = extract(store.sequence(problem, knowledge_base), problem.facts, problem.goals)
    return problem, assemble(order, problem.goals, knowledge_base, {})


def without(plan_net: PlanNet, place: int) -> PlanNet:
    return replace(plan_net, actions=(*plan_net.actions[:place], *plan_net.actions[place + 1 :]))


def test_a_valid_plan_net_has_no_fault(
    knowledge_base: KnowledgeBase, solved: tuple[PlanningProblem, PlanNet]
) -> None:
    problem, plan_net = solved
    assert len(plan_net.actions) > STRETCH
    assert up_fault(knowledge_base, problem, plan_net) is None


@pytest.mark.parametrize("place", [0, STRETCH - 1, STRETCH, -1])
def test_a_missing_action_is_missed_in_whatever_stretch(
    knowledge_base: KnowledgeBase, solved: tuple[PlanningProblem, PlanNet], place: int
) -> None:
    problem, plan_net = solved
    fault = up_fault(knowledge_base, problem, without(plan_net, place % len(plan_net.actions)))
    assert fault is not None
    assert "not satisfied" in fault


def test_an_action_that_claims_more_than_its_operator_is_found_out(
    knowledge_base: KnowledgeBase, solved: tuple[PlanningProblem, PlanNet]
) -> None:
    problem, plan_net = solved
    first, *others = plan_net.actions
    boast = replace(first, other_effects=(*first.other_effects, inside("sample_0", "bay_0")))
    fault = up_fault(knowledge_base, problem, replace(plan_net, actions=(boast, *others)))
    assert fault is not None
    assert "other_effects are not those of" in fault


def test_a_robot_without_the_ability_is_found_out(
    knowledge_base: KnowledgeBase, solved: tuple[PlanningProblem, PlanNet]
) -> None:
    problem, plan_net = solved
    ability = Fact("can", ("store_1", "DOCK"))
    fault = up_fault(knowledge_base, replace(problem, facts=problem.facts - {ability}), plan_net)
    assert fault is not None
    assert str(ability) in fault


def test_a_goal_met_by_the_way_only_is_not_achieved(
    knowledge_base: KnowledgeBase, solved: tuple[PlanningProblem, PlanNet]
) -> None:
    """A place becomes vacant when an object is taken from it, which no action intends."""
    problem, plan_net = solved
    vacated = Fact("vacant", ("door_0",))
    fault = up_fault(knowledge_base, problem, replace(plan_net, goals=(*plan_net.goals, vacated)))
    assert fault is not None
    assert "i_vacant" in fault


def test_a_plan_of_nothing_is_valid_only_if_the_goals_hold(knowledge_base: KnowledgeBase) -> None:
    problem = LargeStore(aisles=1, samples=1).problem()
    idle = PlanNet(goals=problem.goals, actions=(), causal_links=(), orderings=(), recruitment={})
    assert up_fault(knowledge_base, problem, idle) is not None
    home = (inside("sample_0", "door_0"),)
    assert up_fault(knowledge_base, problem, replace(idle, goals=home)) is None
