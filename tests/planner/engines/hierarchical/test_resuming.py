"""What is left of a plan is planned from its middle: agents hold things, and others lie where they are passed on."""

import time

import pytest

from benchmarks.planner.instances import FAMILIES
from benchmarks.planner.scheduled_progress import after
from planner import KnowledgeBase, PlanningRequest
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.repair import Remaining


@pytest.mark.parametrize(
    ("family", "goals", "seed", "share"),
    [("two_ways", 6, 3, 0.15), ("store", 10, 1, 0.35), ("mixed", 10, 0, 0.15)],
    ids=["all hands full", "a thing in between", "both"],
)
def test_what_is_left_of_a_plan_is_planned_from_its_middle(
    knowledge_base: KnowledgeBase, family: str, goals: int, seed: int, share: float
) -> None:
    engine = HierarchicalEngine(knowledge_base)
    problem = FAMILIES[family](goals, 700 + seed).problem(knowledge_base)
    plan = engine.plan(problem, PlanningRequest(effort_s=0.0)).plan_net
    assert plan is not None
    now, progress = after(plan, problem, share)
    left = Remaining(plan, now, progress, knowledge_base).problem
    request = PlanningRequest(time_limit_s=10.0, effort_s=0.0, resumes=True, clock=time.process_time)
    found = engine.plan(left, request)
    assert found.plan_net is not None, found.reason
    assert found.plan_net.makespan_s < 1.5 * (plan.makespan_s - progress.elapsed_s)
