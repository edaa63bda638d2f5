"""Common frame of all engines: checks the problem, turns invalid input and plans into results, measures time."""

import time
from collections.abc import Callable
from dataclasses import replace

from planner.errors import InvalidPlan, KnowledgeBaseError
from planner.knowledge import KnowledgeBase
from planner.plan_nets.plan_net import PlanNet
from planner.problem.interface import PlanningProblem, PlanningResult, PlanningStatus

Outcome = tuple[PlanningStatus, PlanNet | None, str]
"""How planning ended, the plan-net if there is one, else why there is none."""


def timed_result(
    engine: str, knowledge_base: KnowledgeBase, problem: PlanningProblem, plan: Callable[[], PlanningResult]
) -> PlanningResult:
    """What `plan` answers, with the time it took; `FAILED` if the problem or its plan is not of the knowledge base."""
    begun = time.monotonic()
    try:
        for fact in (*sorted(problem.facts), *problem.goals):
            knowledge_base.check(fact, problem.objects)
        result = plan()
    except (KnowledgeBaseError, InvalidPlan) as error:
        result = to_result(engine, (PlanningStatus.FAILED, None, str(error)))
    return replace(result, planning_s=round(time.monotonic() - begun, 4))


def to_result(engine: str, outcome: Outcome) -> PlanningResult:
    """The outcome as an engine's result; `timed_result` fills in the time."""
    status, plan_net, reason = outcome
    return PlanningResult(status=status, engine=engine, planning_s=0.0, plan_net=plan_net, reason=reason)
