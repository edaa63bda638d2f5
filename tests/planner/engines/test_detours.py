"""Sequences without detours."""

from itertools import pairwise

from planner import Fact, GroundAction, KnowledgeBase, PlanningProblem
from planner.engines.detours import without_detours
from planner.plan_nets.extraction import fault_of
from tests.planner.store import inside, store_problem

NEAR = Fact("robot_position", ("yard_1", "near", "door_1"))


def action(base: KnowledgeBase, problem: PlanningProblem, tag: str, **arguments: str) -> GroundAction:
    return base.ground(tag, arguments, problem.functions, objects=problem.objects)


def navigate(base: KnowledgeBase, problem: PlanningProblem, one: str, other: str) -> GroundAction:
    places = {"rel1": "near", "ref1": one, "rel2": "near", "ref2": other}
    return action(base, problem, "NAVIGATE", robots="yard_1", area="yard", **places)


def transport(base: KnowledgeBase, problem: PlanningProblem, rel: str, one: str, other: str) -> GroundAction:
    places = {"rel1": rel, "ref1": one, "rel2": "near", "ref2": other}
    return action(base, problem, "TRANSPORT", object="sample_1", robots="yard_1", area="yard", **places)


def test_a_way_round_becomes_the_straight_way(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([NEAR])
    stops = ["home_yard_1", "door_2", "interchange_1", "door_1"]
    sequence = [navigate(knowledge_base, problem, *leg) for leg in pairwise(stops)]
    assert without_detours(sequence, problem, knowledge_base) == (
        navigate(knowledge_base, problem, "home_yard_1", "door_1"),
    )


def test_what_comes_after_is_bound_again_to_where_its_robot_came_from(knowledge_base: KnowledgeBase) -> None:
    """RELEASE2 speaks of the whole way a sample was carried."""
    problem = store_problem([inside("sample_1", "interchange_1")], samples={"sample_1": "door_1"})
    dock = {"object": "sample_1", "robots": "yard_1", "rel1": "near", "ref1": "door_1"}
    release = {"object": "sample_1", "robots": "yard_1", "rel2": "near", "ref2": "interchange_1"}
    start = [
        navigate(knowledge_base, problem, "home_yard_1", "door_1"),
        action(knowledge_base, problem, "DOCK", **dock),
    ]
    detour = [
        *start,
        transport(knowledge_base, problem, "at", "door_1", "door_2"),
        transport(knowledge_base, problem, "near", "door_2", "interchange_1"),
        action(knowledge_base, problem, "RELEASE2", rel1="near", ref1="door_2", **release),
    ]
    assert fault_of(detour, problem.facts, problem.goals) is None
    assert without_detours(detour, problem, knowledge_base) == (
        *start,
        transport(knowledge_base, problem, "at", "door_1", "interchange_1"),
        action(knowledge_base, problem, "RELEASE2", rel1="at", ref1="door_1", **release),
    )


def test_a_stop_that_serves_a_goal_stays(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([inside("sample_1", "interchange_1")], samples={"sample_1": "door_1"})
    dock = {"object": "sample_1", "robots": "yard_1", "rel1": "near", "ref1": "door_1"}
    release = {"object": "sample_1", "robots": "yard_1", "rel2": "near", "ref2": "interchange_1"}
    sequence = (
        navigate(knowledge_base, problem, "home_yard_1", "door_1"),
        action(knowledge_base, problem, "DOCK", **dock),
        transport(knowledge_base, problem, "at", "door_1", "interchange_1"),
        action(knowledge_base, problem, "RELEASE2", rel1="at", ref1="door_1", **release),
    )
    assert without_detours(sequence, problem, knowledge_base) == sequence


def test_a_sequence_that_does_not_reach_the_goals_stays_as_it_is(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([NEAR])
    sequence = (
        navigate(knowledge_base, problem, "home_yard_1", "door_2"),
        navigate(knowledge_base, problem, "door_2", "interchange_1"),
    )
    assert without_detours(sequence, problem, knowledge_base) == sequence
