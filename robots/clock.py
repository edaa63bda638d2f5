"""The clock protocol, from which all code that measures time reads it."""

from typing import Protocol


class Clock(Protocol):
    """A source of time. A world's clock may run faster than real time, or stand still."""

    def now_s(self) -> float:
        """Seconds since the clock's own start."""
        ...


class ManualClock:
    """A clock that moves only by `advance`."""

    def __init__(self, start_s: float = 0.0) -> None:
        self._now_s = start_s

    def now_s(self) -> float:
        return self._now_s

    def advance(self, step_s: float) -> None:
        if step_s < 0:
            raise ValueError(f"a clock does not run backwards: step {step_s} s")
        self._now_s += step_s
