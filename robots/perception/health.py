"""Sensors that lie: what one of many tells can be spared is left out, the rest is a fault. All of it our choice.

A reading that cannot be is no reading. One that stays the same to the last bit while the robot moves is an old one, for
every sensor has noise.
"""

from dataclasses import replace
from math import hypot, isfinite

import numba
import numpy as np
from numpy.typing import NDArray

from robots.errors import SensorFault
from robots.physical.body import Pose, Readings
from robots.physical.geometry import wrap
from robots.physical.sightings import NONE_IN_VIEW, Sightings

MASKED_SHARE = 0.25
"""Of the whiskers, up to this share may fail and the robot goes on."""
FROZEN_M = 0.3
"""A sensor that reads the same over this way is frozen; a turn counts as the way of a point `ARM_M` off."""
ARM_M = 0.5
BESIDE_M = 0.3
"""A whisker at the least it can read is stuck, not near something, if both beside it read this much more."""


class SensorHealth:
    """Judges each instant's readings. `degraded`: what the robot does without, in words.

    :param whisker_least_m: the least that a whisker can read.
    """

    def __init__(self, whisker_least_m: float = 0.0) -> None:
        self._least_m = whisker_least_m
        self._at: Pose | None = None
        self._ranges_m: NDArray[np.float64] | None = None
        self._same_m: NDArray[np.float64] = np.empty(0)
        self._sightings = NONE_IN_VIEW
        self._unchanged_m = 0.0
        self._battery = 1.0
        self.degraded: tuple[str, ...] = ()

    def inspect(self, readings: Readings, odometry: Pose) -> Readings:
        """The readings without what cannot be.

        :raises SensorFault: if what is left does not do; names the sensor and what it reads.
        """
        moved_m = self._moved_m(odometry)
        spared: list[str] = []
        battery = self._gauge(readings.battery, spared)
        sightings = self._beacons(readings.sightings, moved_m, spared)
        ranges_m = self._whiskers(readings.ranges_m, moved_m, spared)
        self.degraded = tuple(spared)
        if not spared:
            return readings
        return replace(readings, battery=battery, sightings=sightings, ranges_m=ranges_m)

    def _moved_m(self, odometry: Pose) -> float:
        last, self._at = self._at, odometry
        if last is None:
            return 0.0
        way_m = hypot(odometry.x_m - last.x_m, odometry.y_m - last.y_m)
        moved_m = way_m + ARM_M * abs(wrap(odometry.heading_rad - last.heading_rad))
        return moved_m if isfinite(moved_m) else 0.0

    def _gauge(self, battery: float, spared: list[str]) -> float:
        if 0 <= battery <= 1:
            self._battery = battery
        else:
            spared.append(f"the battery reads {battery}")
        return self._battery

    def _beacons(self, sightings: Sightings | None, moved_m: float, spared: list[str]) -> Sightings | None:
        if not sightings:
            self._sightings, self._unchanged_m = NONE_IN_VIEW, 0.0
            return sightings
        self._unchanged_m = self._unchanged_m + moved_m if sightings == self._sightings else 0.0
        self._sightings = sightings
        if self._unchanged_m > FROZEN_M:
            raise SensorFault(
                f"the beacon sensor reads the same over {self._unchanged_m:.1f} m, to the last digit"
            )
        if sightings.sound:
            return sightings
        wrong = {name: one.read for name, one in sightings.items() if not one.sound}
        told = [f"the beacon sensor reads {read} for {name}" for name, read in wrong.items()]
        if len(wrong) == len(sightings):
            raise SensorFault(told[0])
        spared += told
        return sightings.only(sightings.rows.keys() - wrong.keys())

    def _whiskers(
        self, ranges_m: NDArray[np.float64] | None, moved_m: float, spared: list[str]
    ) -> NDArray[np.float64] | None:
        """Without those that lie: each reads what the nearer of the whiskers beside it does."""
        last, self._ranges_m = self._ranges_m, ranges_m
        if ranges_m is None:
            self._same_m = np.empty(0)
            return None
        if last is None or len(self._same_m) != len(ranges_m):
            last, self._same_m = np.full(len(ranges_m), np.nan), np.zeros(len(ranges_m))
        if not _count_same(ranges_m, last, self._same_m, moved_m, self._least_m):
            return ranges_m
        impossible = ~(ranges_m >= 0)
        lying = impossible | (self._same_m > FROZEN_M)
        told = [
            f"whisker {beam} reads {ranges_m[beam]:.2f}{'' if impossible[beam] else ' wherever it looks'}"
            for beam in np.flatnonzero(lying).tolist()
        ]
        if len(told) > MASKED_SHARE * len(ranges_m):
            raise SensorFault(f"{len(told)} of {len(ranges_m)} whiskers lie: {told[0]}")
        spared += told
        return _bridged(ranges_m, lying)


@numba.njit(cache=True)
def _count_same(
    ranges_m: NDArray[np.float64],
    last_m: NDArray[np.float64],
    same_m: NDArray[np.float64],
    moved_m: float,
    least_m: float,
) -> bool:
    """Count, in place, the way over which each whisker has read the same; True if any of them lies. Compiled: it is
    asked twenty times a second.

    :param ranges_m, last_m, same_m: shape (N,): what they read, what they read before, and over which way that.
    """
    lies = False
    for beam in range(len(ranges_m)):
        range_m = ranges_m[beam]
        same = range_m == last_m[beam] and np.isfinite(range_m)
        if same and range_m <= least_m:
            # NOTE: the least it can read a whisker reads without noise, as long as something is that near.
            beside_m = np.minimum(ranges_m[beam - 1], ranges_m[(beam + 1) % len(ranges_m)])
            same = not beside_m < range_m + BESIDE_M
        same_m[beam] = same_m[beam] + moved_m if same else 0.0
        lies |= same_m[beam] > FROZEN_M or not range_m >= 0
    return lies


def _bridged(ranges_m: NDArray[np.float64], lying: NDArray[np.bool_]) -> NDArray[np.float64]:
    bridged = np.where(lying, np.inf, ranges_m)
    for beam in np.flatnonzero(lying).tolist():
        sound = np.flatnonzero(~lying)
        after, before = min((sound - beam) % len(lying)), min((beam - sound) % len(lying))
        bridged[beam] = min(ranges_m[(beam + after) % len(lying)], ranges_m[(beam - before) % len(lying)])
    return bridged
