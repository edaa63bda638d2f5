"""Several problems solved one after the other within one time limit."""

import time
from dataclasses import replace

from planner.problem.interface import (
    Objective,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
)

MIN_SHARE_S = 0.05
"""With less time left, no further problem is begun."""


class Solving:
    """Solves problems while there is time: none is begun that would take too long, going by those before it."""

    def __init__(self, engine: PlanningEngine, request: PlanningRequest, observer: Observer) -> None:
        """:param request: its time limit is for all problems together."""
        self._engine = engine
        self._request = request
        self._observer = observer
        self._give_up = time.monotonic() + request.time_limit_s
        self._longest_s = MIN_SHARE_S

    def solve(self, problem: PlanningProblem, objective: Objective | None = None) -> PlanningResult | None:
        """The engine's answer; None if there is no time left for it or nobody waits any more.

        :param objective: the request's unless given.
        """
        begun = time.monotonic()
        left_s = self._give_up - begun
        if left_s < self._longest_s or self._observer.should_stop():
            return None
        request = replace(self._request, objective=objective or self._request.objective, time_limit_s=left_s)
        result = self._engine.plan(problem, request, self._observer)
        self._longest_s = max(self._longest_s, time.monotonic() - begun)
        return result
