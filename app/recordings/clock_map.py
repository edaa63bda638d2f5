"""Converts wall-clock times to times of a world's clock, because logged events only have wall-clock times."""

from bisect import bisect_right
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from datetime import datetime

from app.domain.clock import SYSTEM_CLOCK, WallClock
from robots.clock import Clock

INTERVAL_S = 1.0
KEPT_READINGS = 7200
"""Two hours of readings of each world's clock; earlier times map to the oldest reading."""


class ClockMap:
    """Reads the wall clock and the worlds' clocks together, once a second, and interpolates between readings."""

    def __init__(self, clocks: Mapping[str, Clock], *, wall: WallClock = SYSTEM_CLOCK) -> None:
        self._clocks = clocks
        self._wall = wall
        self._readings: dict[str, deque[tuple[float, float]]] = {}
        self._read_at_s = 0.0

    def read(self) -> None:
        """Read all clocks, unless that was done less than `INTERVAL_S` ago."""
        wall_s = self._wall.epoch_s()
        if abs(wall_s - self._read_at_s) < INTERVAL_S:
            return
        self._read_at_s = wall_s
        for world in tuple(self._clocks):
            with suppress(KeyError):  # it was removed just now
                self._of(world).append((wall_s, self._clocks[world].now_s()))
        for world in self._readings.keys() - self._clocks.keys():
            while len(self._readings[world]) > 1:
                self._readings[world].popleft()

    def knows(self, world: str) -> bool:
        """True while the world runs."""
        return world in self._clocks

    def now_s(self, world: str) -> float:
        """The world's clock; of one that was removed, as it was last read."""
        if world in self._clocks or not self._readings.get(world):
            return self._clocks[world].now_s()
        return self._readings[world][-1][1]

    def _of(self, world: str) -> deque[tuple[float, float]]:
        return self._readings.setdefault(world, deque(maxlen=KEPT_READINGS))

    def at_s(self, world: str, wall_time: str) -> float:
        """The world's clock at a wall-clock time, given as ISO 8601."""
        wall_s = datetime.fromisoformat(wall_time).timestamp()
        readings = [*self._of(world), (self._wall.epoch_s(), self.now_s(world))]
        after = bisect_right(readings, (wall_s,))
        if after == 0:
            return readings[0][1]
        if after == len(readings):
            return readings[-1][1]
        (wall_0_s, world_0_s), (wall_1_s, world_1_s) = readings[after - 1], readings[after]
        return world_0_s + (world_1_s - world_0_s) * (wall_s - wall_0_s) / (wall_1_s - wall_0_s)
