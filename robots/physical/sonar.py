"""Virtual sonar: detects simulated robots, or the walls of the map, in a chain with a robot's real sonar ring (SRA)."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import inf, tau
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robots.physical.body import RADIUS_M, Readings


class Activity(Protocol):
    """A module of the reactive controller (SRA): transforms the readings of the modules before it."""

    def process(self, readings: Readings) -> Readings: ...


def cascade(readings: Readings, activities: Iterable[Activity]) -> Readings:
    """Apply the activities in their order, each to the result of the one before."""
    for activity in activities:
        readings = activity.process(readings)
    return readings


Ranges = NDArray[np.float64]
"""Shape (N,), metres from the hull, beam 0 straight ahead, counter-clockwise, inf where nothing is in range."""


Walls = NDArray[np.complex128]
"""Shape (M, 2), the ends of straight walls' middle lines in a robot's own frame, metres."""


class KnowsWalls(Protocol):
    """The map, as a robot at its place has it."""

    def walls(self) -> Walls: ...


class MapSonar:
    """The virtual counterpart of a real ring: the echoes that the walls of the map would give it (SRA).

    What is on no map, such as rocks, samples and solid robots, it does not detect. The nearer echo of it and of the
    modules before it counts. Our choice: without noise.

    :param range_m: the greatest range; `least_m`: the least; `thickness_m`: of the walls.
    """

    def __init__(
        self, known: KnowsWalls, *, beams: int, range_m: float, least_m: float = 0.0, thickness_m: float
    ) -> None:
        self._known = known
        self._beams = np.exp(1j * np.arange(beams) * tau / beams)
        self._range_m = range_m
        self._least_m = least_m
        self._half_m = thickness_m / 2

    def process(self, readings: Readings) -> Readings:
        walls = self._known.walls()
        if readings.ranges_m is None or not walls.size:
            return readings
        return replace(readings, ranges_m=np.minimum(readings.ranges_m, self._ranges(walls)))

    def _ranges(self, walls: Walls) -> Ranges:
        starts = walls[:, :1] / self._beams  # shape (M, N): in each beam's own frame, x along the beam
        ways = walls[:, 1:] / self._beams - starts
        crosses = (starts.imag > 0) != ((starts + ways).imag > 0)
        across = np.where(crosses, ways.imag, 1.0)
        at_m = starts.real - ways.real * starts.imag / across
        near_m = at_m - self._half_m * abs(ways) / abs(across)  # the wall's face, met at a slant
        met = crosses & (at_m > 0)
        range_m = np.where(met, np.maximum(near_m - RADIUS_M, 0.0), inf).min(axis=0)
        return np.where(range_m <= self._range_m, np.maximum(range_m, self._least_m), inf)


class Workbench(Protocol):
    """The shared environment of real and simulated robots (SRA: Virtual Robotic Workbench), as one of them sees it."""

    def simulated_robots(self) -> Sequence[complex]:
        """The middles of the simulated robots around it, in its own frame, metres."""
        ...


class VirtualSonar:
    """Detects simulated robots as a real ring of the same geometry would detect solid ones (SRA: VirtualSonar).

    In each beam the nearer echo counts: a simulated robot behind a real wall is not detected, nor a wall behind it.
    Our choice: without noise, and simulated robots are as big and round as real ones.

    :param range_m: the greatest range; `least_m`: the least, which nearer echoes read as.
    """

    def __init__(self, workbench: Workbench, *, beams: int, range_m: float, least_m: float = 0.0) -> None:
        self._workbench = workbench
        self._beams = np.exp(1j * np.arange(beams) * tau / beams)
        self._range_m = range_m
        self._least_m = least_m

    def process(self, readings: Readings) -> Readings:
        if readings.ranges_m is None:
            return readings
        near_m = self._range_m + 2 * RADIUS_M
        around = [at for at in self._workbench.simulated_robots() if abs(at) <= near_m]
        if not around:
            return readings
        return replace(readings, ranges_m=np.minimum(readings.ranges_m, self._ranges(np.array(around))))

    def _ranges(self, around: NDArray[np.complex128]) -> Ranges:
        """:param around: shape (M,), middles of round bodies in the robot's frame."""
        turned = around[:, None] / self._beams  # shape (M, N): in each beam's own frame, x along the beam
        half_m = np.sqrt(np.maximum(RADIUS_M**2 - turned.imag**2, 0.0))
        met = (abs(turned.imag) < RADIUS_M) & (turned.real + half_m > 0)
        range_m = np.where(met, turned.real - half_m - RADIUS_M, inf).min(axis=0)
        return np.where(range_m <= self._range_m, np.maximum(range_m, self._least_m), inf)
