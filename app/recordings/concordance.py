"""Which instant of a world's clock an instant of the wall's was: decisions are dated by the wall's alone."""

import time
from bisect import bisect_right
from collections import deque
from collections.abc import Mapping
from datetime import datetime

from robots.clock import Clock

APART_S = 1.0
KEPT = 7200
"""Readings of each world's clock, two hours of them; what was before is dated as the oldest."""


class Concordance:
    """Readings of both clocks, taken together once a second."""

    def __init__(self, clocks: Mapping[str, Clock]) -> None:
        self._clocks = clocks
        self._readings: dict[str, deque[tuple[float, float]]] = {one: deque(maxlen=KEPT) for one in clocks}
        self._read_at = 0.0

    def read(self) -> None:
        now = time.time()
        if abs(now - self._read_at) < APART_S:
            return
        self._read_at = now
        for world, readings in self._readings.items():
            readings.append((now, self._clocks[world].now_s()))

    def now_s(self, world: str) -> float:
        return self._clocks[world].now_s()

    def at_s(self, world: str, written: str) -> float:
        """What the world's clock showed.

        :param written: the wall's clock as ISO 8601.
        """
        at = datetime.fromisoformat(written).timestamp()
        readings = [*self._readings[world], (time.time(), self.now_s(world))]
        after = bisect_right(readings, (at,))
        if after == 0:
            return readings[0][1]
        if after == len(readings):
            return readings[-1][1]
        (wall_0, world_0), (wall_1, world_1) = readings[after - 1], readings[after]
        return world_0 + (world_1 - world_0) * (at - wall_0) / (wall_1 - wall_0)
