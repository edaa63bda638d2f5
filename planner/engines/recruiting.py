"""Holds engines that do not know who may be recruited for a goal to it."""

from dataclasses import replace

from planner.engines.wrapping import WrappingEngine
from planner.explanation.legs import actions_of_others
from planner.problem.interface import (
    UNOBSERVED,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)


class RecruitingEngine(WrappingEngine):
    """An engine whose plans count as not found if other robots serve a goal than may be recruited for it.

    Its proof that there is no plan stands: it has looked among all robots.
    """

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        result = self._engine.plan(problem, request, observer)
        if result.plan_net is None:
            return result
        wrong = actions_of_others(result.plan_net, problem, self._base)
        if not wrong:
            return result
        agents = [one.agents for one in result.plan_net.actions if one.id in wrong]
        names = ", ".join(sorted({name for those in agents for name in those}))
        reason = f"its plan has {names} do what other robots are to be recruited for"
        return replace(result, status=PlanningStatus.NOT_FOUND, plan_net=None, reason=reason)
