"""Holds engines that do not know who and what may be used for a goal to it."""

from dataclasses import replace

from planner.engines.wrapping import WrappingEngine
from planner.explanation.legs import barred_actions
from planner.problem.interface import (
    UNOBSERVED,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)


class RecruitingEngine(WrappingEngine):
    """An engine whose plans count as not found if other robots or places serve a goal than may be used for it.

    Its proof that there is no plan stands: it has looked among all robots.
    """

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        result = self._engine.plan(problem, request, observer)
        if result.plan_net is None:
            return result
        wrong = barred_actions(result.plan_net, problem, self._base)
        if not wrong:
            return result
        reason = f"it found only a plan that is not permitted: {', '.join(dict.fromkeys(wrong.values()))}"
        return replace(result, status=PlanningStatus.NOT_FOUND, plan_net=None, reason=reason)
