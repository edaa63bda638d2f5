"""Zones for one agent at a time in what other planners read."""

from dataclasses import replace
from importlib.util import find_spec

import pytest

from planner import Fact, KnowledgeBase, PlanningRequest, PlanningStatus, scale_term
from planner.engines.fast_downward import FastDownwardEngine
from planner.interchange.pddl import Form, PddlTask, pddl_of
from planner.interchange.stated_zones import StatedZones
from planner.plan_nets.extraction import fault_of
from planner.problem.interface import Crossing, PlanningProblem
from tests.planner.store import store_problem

CLEAR = Fact("zone_clear", ("gate",))
YARD = {"door_1", "interchange_1", "home_yard_1"}
"""What lies west of a gate across the yard."""


@pytest.fixture
def swapping() -> PlanningProblem:
    """The yard's robots are to change sides; the gate is on every way between them."""
    goals = [
        Fact("robot_position", (robot, "near", door))
        for robot, door in (("yard_1", "door_2"), ("yard_2", "door_1"))
    ]
    problem = store_problem(goals)
    ways = {args for name, args in problem.functions if name == "distance_m"}
    east = {"door_2", "interchange_2", "home_yard_2"}
    through = [(a, b) for a, b in ways if (a in YARD and b in east) or (a in east and b in YARD)]
    return replace(
        problem,
        objects={**problem.objects, "gate": "zone"},
        facts=problem.facts | {CLEAR},
        functions={**problem.functions, scale_term("NAVIGATE", 1): 1.1},  # named with two words, too
        crossings=dict.fromkeys(through, (Crossing(zone="gate", enters=True, leaves=True),)),
    )


def test_a_problem_without_zones_is_left_as_it_is(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([])
    stated = StatedZones(knowledge_base, problem)
    assert stated.knowledge_base is knowledge_base
    assert stated.problem is problem


def test_operators_state_what_zones_ask_for(knowledge_base: KnowledgeBase, swapping: PlanningProblem) -> None:
    domain, problem = pddl_of(knowledge_base, swapping, Form.TEMPORAL)
    _, _, through = domain.partition("(:durative-action navigate_way_1")
    through, _, _ = through.partition("(:durative-action")
    assert "(at start (way_1 ?ref1 ?ref2))" in through
    assert "(at start (zone_clear gate))" in through
    assert "(at start (not (zone_clear gate)))" in through
    assert "(at end (zone_clear gate))" in through
    assert "gate - zone" in domain
    assert "gate - zone" not in problem
    assert "(way_1 home_yard_1 door_2)" in problem
    assert "(way_0 home_yard_1 door_1)" in problem
    free, _, _ = domain.partition("(:durative-action navigate_way_1")
    assert "zone_clear gate" not in free.partition("(:durative-action navigate_way_0")[2]


def test_a_step_of_another_planner_is_the_action_with_its_zone(
    knowledge_base: KnowledgeBase, swapping: PlanningProblem
) -> None:
    task = PddlTask(knowledge_base, swapping, Form.CLASSICAL)
    action = task.ground("navigate_way_1", ["yard_1", "home_yard_1", "door_2", "yard"])
    assert CLEAR in action.preconditions
    assert CLEAR in action.deletes
    assert CLEAR in action.other_effects
    assert not any(fact.predicate.startswith("way_") for fact in action.preconditions)


@pytest.mark.skipif(find_spec("up_fast_downward") is None, reason="Fast Downward is not installed")
def test_fast_downwards_plans_keep_to_zones(knowledge_base: KnowledgeBase, swapping: PlanningProblem) -> None:
    result = FastDownwardEngine(knowledge_base).plan(swapping, PlanningRequest(effort_s=0.0))
    assert result.status is PlanningStatus.SOLVED, result.reason
    assert result.plan_net is not None
    assert fault_of(result.plan_net.actions, swapping.facts, swapping.goals) is None
    assert [(one.before, one.after) for one in result.plan_net.orderings] == [("a1", "a2")]
    held = replace(swapping, facts=swapping.facts - {CLEAR})
    refused = FastDownwardEngine(knowledge_base).plan(held, PlanningRequest(effort_s=0.0))
    assert refused.status is PlanningStatus.UNSOLVABLE, refused.reason
