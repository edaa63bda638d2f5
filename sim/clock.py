"""The simulation's time step, the world's clock, and the one place that reads the wall clock."""

import time
from typing import Protocol

from robots.clock import Clock

TICK_S = 1 / 60
"""The time step of the physics."""
TICKS_PER_CONTROL = 3
"""Agents sense and act at 20 Hz."""
CONTROL_S = TICKS_PER_CONTROL * TICK_S


class WorldClock:
    """A world's clock: the number of ticks, in seconds. Implements `robots.clock.Clock`."""

    def __init__(self) -> None:
        self.ticks = 0

    def now_s(self) -> float:
        return self.ticks * TICK_S


class SleepingClock(Clock, Protocol):
    """A clock that can also wait."""

    def sleep(self, seconds: float) -> None: ...


class WallClock:
    """Monotonic wall-clock time. Implements `SleepingClock`."""

    def now_s(self) -> float:
        return time.monotonic()

    def sleep(self, seconds: float) -> None:
        time.sleep(seconds)
