"""Several problems solved by one engine within one time limit."""

from dataclasses import replace
from math import inf

from planner.problem.interface import (
    Objective,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
)

ROUNDING_S = 0.05
"""Makespans that differ by less count as equal: one this close to its lower bound as optimal."""
MIN_SHARE_S = 0.05
"""With less time left, no further problem is started."""


class TimeLimitedEngine:
    """An engine that is asked several times; the request's time limit is for all problems together."""

    def __init__(self, engine: PlanningEngine, request: PlanningRequest, observer: Observer) -> None:
        self._engine = engine
        self._request = request
        self._observer = observer
        self.timer = request.timer()
        self._longest_s = MIN_SHARE_S
        self.last: PlanningResult | None = None
        """The engine's last answer."""

    @property
    def is_over(self) -> bool:
        """True if the time is used up or the observer wants to stop."""
        return self.timer.left_s < MIN_SHARE_S or self._observer.should_stop()

    def plan(
        self,
        problem: PlanningProblem,
        objective: Objective | None = None,
        *,
        at_most_s: float = inf,
        seed: int | None = None,
    ) -> PlanningResult:
        """The engine's answer.

        :param objective: the request's unless given, likewise the seed.
        """
        begun_s = self.timer.elapsed_s
        request = replace(
            self._request,
            objective=objective or self._request.objective,
            seed=self._request.seed if seed is None else seed,
            time_limit_s=max(min(self.timer.left_s, at_most_s), MIN_SHARE_S),
        )
        self.last = self._engine.plan(problem, request, self._observer)
        self._longest_s = max(self._longest_s, self.timer.elapsed_s - begun_s)
        return self.last

    def plan_if_time(
        self, problem: PlanningProblem, objective: Objective | None = None, *, seed: int | None = None
    ) -> PlanningResult | None:
        """The engine's answer; None if less time is left than an earlier problem took, or it is to stop."""
        if self.timer.left_s < self._longest_s or self._observer.should_stop():
            return None
        return self.plan(problem, objective, seed=seed)
