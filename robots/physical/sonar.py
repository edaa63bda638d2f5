"""Virtual sonar: hears simulated robots, chained after the real ring of a robot that does not meet them (SRA)."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import inf, tau
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robots.physical.body import RADIUS_M, Readings


class Activity(Protocol):
    """A module of the reactive controller: takes what those before it have sensed, and hands on its own account."""

    def process(self, readings: Readings) -> Readings: ...


def cascade(readings: Readings, activities: Iterable[Activity]) -> Readings:
    """What all activities make of it, in the order of their installation: each is given what the one before gave."""
    for activity in activities:
        readings = activity.process(readings)
    return readings


Ranges = NDArray[np.float64]
"""Shape (N,), metres from the hull, beam 0 straight ahead, counter-clockwise, inf where nothing is in range."""


class Workbench(Protocol):
    """The shared environment of real and simulated robots (SRA: Virtual Robotic Workbench), as one of them sees it."""

    def simulated_robots(self) -> Sequence[complex]:
        """The middles of the simulated robots around it, in its own frame, metres."""
        ...


class VirtualSonar:
    """Hears simulated robots as a real ring of the same measures would hear solid ones (SRA: VirtualSonar).

    In each beam the nearer echo wins, so that a simulated robot behind a real wall is not heard, nor a wall behind it.
    Our choice: without noise, and simulated robots are as big and round as real ones.

    :param range_m: beyond it nothing is heard; what is nearer than `least_m` reads as that.
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
        turned = (
            around[:, None] / self._beams
        )  # shape (M, N): each beam's own frame, in which it goes along x
        half_m = np.sqrt(np.maximum(RADIUS_M**2 - turned.imag**2, 0.0))
        met = (abs(turned.imag) < RADIUS_M) & (turned.real + half_m > 0)
        range_m = np.where(met, turned.real - half_m - RADIUS_M, inf).min(axis=0)
        return np.where(range_m <= self._range_m, np.maximum(range_m, self._least_m), inf)
