"""Measures time since a start and until a limit; the one place of the planner that reads the clock."""

import time
from collections.abc import Callable
from math import inf

Clock = Callable[[], float]
"""Seconds from any origin, never going back."""


class Timer:
    """Starts when it is created; without a limit it is never over."""

    def __init__(self, limit_s: float = inf, clock: Clock = time.monotonic) -> None:
        self.limit_s = limit_s
        self.clock = clock
        self._begun_s = clock()

    @property
    def elapsed_s(self) -> float:
        return self.clock() - self._begun_s

    @property
    def left_s(self) -> float:
        return self.limit_s - self.elapsed_s

    @property
    def is_over(self) -> bool:
        return self.left_s <= 0
