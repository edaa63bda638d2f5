"""What every engine's answer has in common: the problem is checked first, mistakes are results, time is taken."""

import time
from collections.abc import Callable
from dataclasses import replace

from planner.errors import InvalidPlan, KnowledgeBaseError
from planner.knowledge import KnowledgeBase
from planner.plan_nets.plan_net import PlanNet
from planner.problem.interface import PlanningProblem, PlanningResult, PlanningStatus

Outcome = tuple[PlanningStatus, PlanNet | None, str]
"""How planning ended, the plan-net if there is one, else why there is none."""


def answered(
    engine: str, knowledge_base: KnowledgeBase, problem: PlanningProblem, plan: Callable[[], PlanningResult]
) -> PlanningResult:
    """What `plan` answers, with the time it took; `FAILED` if the problem or its plan is not of the knowledge base."""
    begun = time.monotonic()
    try:
        for fact in (*sorted(problem.facts), *problem.goals):
            knowledge_base.check(fact, problem.objects)
        result = plan()
    except (KnowledgeBaseError, InvalidPlan) as error:
        result = result_of(engine, (PlanningStatus.FAILED, None, str(error)))
    return replace(result, planning_s=round(time.monotonic() - begun, 4))


def result_of(engine: str, outcome: Outcome) -> PlanningResult:
    """The outcome as an engine's result; how long it took is for `answered` to say."""
    status, plan_net, reason = outcome
    return PlanningResult(status=status, engine=engine, planning_s=0.0, plan_net=plan_net, reason=reason)
