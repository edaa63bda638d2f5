"""Finds invalid and frozen sensor readings. A redundant one is left out, any other is a fault. All of it our choice.

A reading is invalid if it is out of the sensor's range. It is frozen if it stays identical while the robot moves, since
every sensor has noise.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import hypot, isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robots.compiled import kernel
from robots.errors import SensorFault
from robots.physical.body import Pose, Readings
from robots.physical.geometry import wrap
from robots.physical.sightings import NONE_IN_VIEW, Sightings

MASKED_SHARE = 0.25
"""The largest share of whiskers that may fail without a fault."""
FROZEN_M = 0.3
"""A sensor whose reading is identical over this distance is frozen. A turn counts as the path of a point at `ARM_M`."""
ARM_M = 0.5
BESIDE_M = 0.3
"""A whisker at its shortest range is frozen, not near something, if both neighbours read at least this much more."""


class Defect(NamedTuple):
    """A reading that is left out."""

    sensor: str
    """Names the sensor, or the one reading of it; the same in every tick."""
    words: str


class SensorHealth:
    """Checks the readings of each tick. `degraded`: the readings that are left out.

    :param whisker_least_m: the shortest range that a whisker can read.
    """

    def __init__(self, whisker_least_m: float = 0.0) -> None:
        self._least_m = whisker_least_m
        self._at: Pose | None = None
        self._ranges_m: NDArray[np.float64] | None = None
        self._same_m: NDArray[np.float64] = np.empty(0)
        self._sightings = NONE_IN_VIEW
        self._unchanged_m = 0.0
        self._battery = 1.0
        self.degraded: tuple[Defect, ...] = ()

    def inspect(self, readings: Readings, odometry: Pose) -> Readings:
        """The readings without invalid and frozen ones.

        :raises SensorFault: if the remaining readings do not suffice; names the sensor and its reading.
        """
        if not all(map(isfinite, (odometry.x_m, odometry.y_m, odometry.heading_rad))):
            raise SensorFault(f"odometry reads {odometry}")
        if not all(map(isfinite, readings.capture_head_m or ())):
            raise SensorFault(f"the capture head reads {readings.capture_head_m}")
        moved_m = self._moved_m(odometry)
        defects: list[Defect] = []
        battery = self._gauge(readings.battery, defects)
        sightings = self._beacons(readings.sightings, moved_m, defects)
        ranges_m = self._whiskers(readings.ranges_m, moved_m, defects)
        measured = _finite(readings.measured, defects)
        self.degraded = tuple(defects)
        if not defects:
            return readings
        return replace(readings, battery=battery, sightings=sightings, ranges_m=ranges_m, measured=measured)

    def _moved_m(self, odometry: Pose) -> float:
        last = self._at
        self._at = odometry
        if last is None:
            return 0.0
        way_m = hypot(odometry.x_m - last.x_m, odometry.y_m - last.y_m)
        return way_m + ARM_M * abs(wrap(odometry.heading_rad - last.heading_rad))

    def _gauge(self, battery: float, defects: list[Defect]) -> float:
        if 0 <= battery <= 1:
            self._battery = battery
        else:
            defects.append(Defect("battery", f"the battery reads {battery}"))
        return self._battery

    def _beacons(
        self, sightings: Sightings | None, moved_m: float, defects: list[Defect]
    ) -> Sightings | None:
        if not sightings:
            self._sightings = NONE_IN_VIEW
            self._unchanged_m = 0.0
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
        found = [Defect(name, f"the beacon sensor reads {read} for {name}") for name, read in wrong.items()]
        if len(wrong) == len(sightings):
            raise SensorFault(found[0].words)
        defects += found
        return sightings.only(sightings.rows.keys() - wrong.keys())

    def _whiskers(
        self, ranges_m: NDArray[np.float64] | None, moved_m: float, defects: list[Defect]
    ) -> NDArray[np.float64] | None:
        """Each failed whisker gets the shorter range of its nearest sound neighbours."""
        last = self._ranges_m
        self._ranges_m = ranges_m
        if ranges_m is None:
            self._same_m = np.empty(0)
            return None
        if last is None or len(self._same_m) != len(ranges_m):
            last = np.full(len(ranges_m), np.nan)
            self._same_m = np.zeros(len(ranges_m))
        if not _count_same(ranges_m, last, self._same_m, moved_m, self._least_m):
            return ranges_m
        impossible = ~(ranges_m >= 0)
        failed = impossible | (self._same_m > FROZEN_M)
        found = [
            Defect(
                f"whisker {beam}",
                f"whisker {beam} reads {ranges_m[beam]:.2f}{'' if impossible[beam] else ' wherever it looks'}",
            )
            for beam in np.flatnonzero(failed).tolist()
        ]
        if len(found) > MASKED_SHARE * len(ranges_m):
            raise SensorFault(f"{len(found)} of {len(ranges_m)} whiskers lie: {found[0].words}")
        defects += found
        return _bridged(ranges_m, failed)


@kernel
def _count_same(
    ranges_m: NDArray[np.float64],
    last_m: NDArray[np.float64],
    same_m: NDArray[np.float64],
    moved_m: float,
    least_m: float,
) -> bool:
    """Add up, in place, the distance over which each reading is identical; True if any whisker has failed.

    :param ranges_m, last_m, same_m: shape (N,): readings, previous readings, and the distance so far.
    """
    failed = False
    for beam in range(len(ranges_m)):
        range_m = ranges_m[beam]
        same = range_m == last_m[beam] and np.isfinite(range_m)
        if same and range_m <= least_m:
            # NOTE: readings at the shortest range have no noise.
            beside_m = np.minimum(ranges_m[beam - 1], ranges_m[(beam + 1) % len(ranges_m)])
            same = not beside_m < range_m + BESIDE_M
        same_m[beam] = same_m[beam] + moved_m if same else 0.0
        failed |= same_m[beam] > FROZEN_M or not range_m >= 0
    return failed


def _bridged(ranges_m: NDArray[np.float64], failed: NDArray[np.bool_]) -> NDArray[np.float64]:
    bridged = np.where(failed, np.inf, ranges_m)
    for beam in np.flatnonzero(failed).tolist():
        sound = np.flatnonzero(~failed)
        after = min((sound - beam) % len(failed))
        before = min((beam - sound) % len(failed))
        bridged[beam] = min(ranges_m[(beam + after) % len(failed)], ranges_m[(beam - before) % len(failed)])
    return bridged


def _finite(measured: Mapping[str, float], defects: list[Defect]) -> Mapping[str, float]:
    """Without what is no number."""
    found = {quantity: value for quantity, value in measured.items() if isfinite(value)}
    defects += [
        Defect(quantity, f"{quantity} reads {measured[quantity]}")
        for quantity in measured.keys() - found.keys()
    ]
    return found
