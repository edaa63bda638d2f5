"""Robots of the world `busy_store` meet at one interchange: one drives up while another still leaves it."""

from functools import cache

from app.cli.simulated_mission import simulate_mission
from app.cli.trials.offline_mission import Mission, goal_problem, plan_mission
from app.domain.world_model import initial_facts
from planner import Keeping, PlanningRequest, load_knowledge_base
from planner.engines.registry import portfolio
from robots.world import load_world
from tests.app.sample_store import said

CROSSING = ("in(sample_1, bay_3)", "in(sample_2, door_1)", "in(sample_3, door_2)")
"""Samples that go through the interchange in both directions."""


@cache
def mission() -> Mission:
    """Three samples through the interchange."""
    world = load_world("busy_store")
    base = load_knowledge_base()
    problem = goal_problem(world, initial_facts(world, base), [said(goal) for goal in CROSSING], base)
    request = PlanningRequest(time_limit_s=60, effort_s=0.0)
    return plan_mission(world, problem, portfolio(base), base, request)


def test_a_robot_goes_in_after_the_phase_in_which_another_leaves() -> None:
    net = mission().plan_net
    actions = {action.id: action for action in net.actions}
    handed_over = [
        (actions[o.before], actions[o.after], o.kept_by)
        for o in net.orderings
        if actions[o.before].phase == 1 and actions[o.after].phase == actions[o.after].phases
    ]
    assert handed_over
    for leaves, enters, kept_by in handed_over:
        assert leaves.agents != enters.agents
        assert kept_by in (Keeping.SENSING, Keeping.CLEARANCE)
        assert any(fact.predicate == "clear" and fact in leaves.effects for fact in enters.preconditions)


def test_what_is_asked_for_becomes_true() -> None:
    ended = simulate_mission(mission(), seed=0)
    assert ended.came_true, (ended.words, ended.reason)
