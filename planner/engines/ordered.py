"""Plans goals in an order, for engines that do not plan for one.

A plan that an engine makes without regard to the order often keeps it once its actions wait for each other. Where no
order of its actions does, the goals are planned in the fewest stages that the order allows. The plan-net has only the
orderings asked for, not those of the stages: goals without a part in the order are not bound to them.
"""

from dataclasses import replace

from planner.engines.plan_net_completion import complete_plan_net
from planner.engines.staged import planned_in_stages
from planner.engines.wrapping import WrappingEngine
from planner.errors import CyclicOrder, InvalidPlan
from planner.plan_nets.orders import fewest_stages, orders_among
from planner.plan_nets.plan_net import PlanNet
from planner.plan_nets.stages import goals_by_stage
from planner.plan_nets.validation import broken_orders, sequence_of
from planner.problem.interface import (
    UNOBSERVED,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.problem.solving import TimeLimitedEngine
from planner.problem.static_facts import StaticFacts

FIRST_SHARE = 0.5
"""Share of the time limit for all goals at once; the rest is for stages."""


class OrderedEngine(WrappingEngine):
    """An engine whose plans keep the order among goals (`PlanningProblem.after`).

    A proof that there is no plan stands: one without the order would be a plan of the problem without it. That no plan
    was found in stages is none.
    """

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        after = orders_among(problem.goals, problem.after)
        if not after:
            return self._engine.plan(problem, request, observer)
        planner = TimeLimitedEngine(self._engine, request, observer)
        answer = planner.plan(problem, at_most_s=FIRST_SHARE * request.time_limit_s)
        if answer.plan_net is not None:
            answer = self._ordered(answer, answer.plan_net, problem)
        if answer.plan_net is not None or answer.status is PlanningStatus.UNSOLVABLE or planner.is_over:
            return answer
        try:
            stages = goals_by_stage(problem.goals, fewest_stages(problem.goals, after))
        except CyclicOrder:
            return replace(answer, reason=f"the order of the goals contradicts itself; {answer.reason}")
        try:
            status, plan_net, reason = planned_in_stages(problem, stages, planner, self._base)
        except InvalidPlan as error:
            status, plan_net, reason = PlanningStatus.NOT_FOUND, None, str(error)
        if plan_net is None:
            reason = "; ".join(dict.fromkeys(filter(None, (answer.reason, reason))))
            status = PlanningStatus.NOT_FOUND if status is PlanningStatus.UNSOLVABLE else status
        return PlanningResult(
            status=status,
            engine=self.name,
            planning_s=round(planner.timer.elapsed_s, 4),
            plan_net=plan_net,
            reason=reason,
            lower_bound_s=answer.lower_bound_s,
        )

    def _ordered(self, answer: PlanningResult, plan_net: PlanNet, problem: PlanningProblem) -> PlanningResult:
        """The answer with a plan-net in which the goals are in order; without one if there is no such order of it."""
        if not broken_orders(plan_net, problem.after):
            return answer
        whole = replace(problem, goals=plan_net.goals)
        sequence = sequence_of(plan_net)
        ordered = complete_plan_net(sequence, whole, self._base, StaticFacts(self._base, whole))
        if isinstance(ordered, str):
            return replace(answer, status=PlanningStatus.NOT_FOUND, plan_net=None, reason=ordered)
        return replace(answer, plan_net=ordered)
