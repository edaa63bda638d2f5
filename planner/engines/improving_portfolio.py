"""Several engines as one that asks the further ones, too, once there is a plan, and keeps the best."""

from collections.abc import Iterator
from dataclasses import replace

from planner.engines.plan_net_completion import merit
from planner.engines.portfolio import MIN_SHARE_S, Portfolio, Relay, ask
from planner.problem.interface import (
    UNOBSERVED,
    Objective,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    Progress,
)
from planner.problem.solving import ROUNDING_S

PATIENCE = 4.0
"""Without an effort, a further engine gets this many times as long as the first plan took (our choice)."""
MIN_PATIENCE_S = 5.0
"""And at least so long."""
REPEATED = 0.5
"""The engine of the first plan is asked again only if that took no more than this share of its effort."""


class ImprovingPortfolio(Portfolio):
    """A portfolio for problems of which it is not known which engine is good at them.

    Once an engine has found a plan, it and those after it are asked one after the other for a better one while the plan
    is above the proven bound; the best is the answer. The effort is divided equally among the engines that are left,
    what one does not use goes to the others, and with 0 the first plan is the answer. More effort gives each engine
    more, so that the answer is no worse as long as the engines' own answers are not. Without an effort each engine has
    its own; then the answer depends on the clock.
    """

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        timer = request.timer()
        *_, last = self.answers(problem, request, observer)
        return replace(last, planning_s=round(timer.elapsed_s, 3))

    def answers(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> Iterator[PlanningResult]:
        """The first answer, then each that is better, as they are found."""
        relay = Relay(observer, request.timer())
        own_s = None if request.effort_s is None else 0.0
        found = self._first(problem, replace(request, effort_s=own_s), relay)
        yield found.answer
        best = found.answer
        if best.plan_net is None:
            return
        found_s = relay.timer.elapsed_s
        asked = self.engines[found.index + (request.effort_s is None) :]
        for index, engine in enumerate(asked):
            left_s = relay.timer.left_s
            if request.effort_s is not None:
                left_s = min(left_s, found_s + request.effort_s - relay.timer.elapsed_s)
            share_s = left_s / (len(asked) - index)
            if request.effort_s is None:
                share_s = min(share_s, max(MIN_PATIENCE_S, PATIENCE * found_s))
            if share_s < MIN_SHARE_S or relay.should_stop() or _is_optimal(best, request, relay):
                return
            if engine is self.engines[found.index] and found.took_s > share_s * REPEATED:
                continue
            effort_s = None if request.effort_s is None else share_s
            limited = replace(request, time_limit_s=share_s, effort_s=effort_s)
            answer = ask(engine, problem, limited, _Better(relay, best))
            relay.learn(answer.lower_bound_s)
            if _key(answer, request) < _key(best, request):
                best = self.concluded(answer, best.reason, relay)
                yield best


class _Better(Relay):
    """Passes on makespans only if they are better than what there is."""

    def __init__(self, relay: Relay, best: PlanningResult) -> None:
        super().__init__(relay, relay.timer)
        self._best = best

    def progress(self, progress: Progress) -> None:
        known_s = self._best.plan_net.makespan_s if self._best.plan_net is not None else float("inf")
        if progress.makespan_s is not None and progress.makespan_s >= known_s:
            progress = replace(progress, makespan_s=None)
        super().progress(progress)


def _key(answer: PlanningResult, request: PlanningRequest) -> tuple[float, ...]:
    """Quantities to minimise, infinite without a plan; optional goals that are achieved count first."""
    if answer.plan_net is None:
        return (float("inf"),)
    return -(answer.value or 0.0), *merit(answer.plan_net, request.objective)


def _is_optimal(best: PlanningResult, request: PlanningRequest, relay: Relay) -> bool:
    """Whether no plan is shorter; of other objectives there is no bound."""
    bound_s = relay.lower_bound_s
    if best.plan_net is None or bound_s is None or request.objective is not Objective.MAKESPAN:
        return False
    return best.plan_net.makespan_s <= bound_s + ROUNDING_S
