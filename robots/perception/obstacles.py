"""Obstacles as discs in the robot's frame, kept as columns for compiled functions (numba).

Arrays: at: shape (N,), complex, metres; radii_m: shape (N,); robots: shape (N,), True of other robots.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import cos, hypot, inf, nan, pi, sin

import numpy as np
from numpy.typing import NDArray

from robots.compiled import kernel, part
from robots.physical.body import RADIUS_M

SAMPLE_RADIUS_M = 0.06
WHISKER_RADIUS_M = 0.02
LONG_OBJECT_DISC_SHARES = (-0.5, -0.25, 0.0, 0.25, 0.5)
"""Centres of the discs that stand for a long object, as shares of its length from its middle."""
ON_ROBOT_M = 0.1
"""A whisker's hit this far outside the hull of a robot in view is taken for that robot (our choice)."""

ROBOT = -1.0
NO_OBSTACLE = nan
"""Values used in place of a length for another robot and for what is no obstacle, such as the object held."""

Points = NDArray[np.complex128]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Obstacle:
    """A disc in the robot's frame, metres."""

    at: complex
    radius_m: float
    is_robot: bool = False

    @property
    def gap_m(self) -> float:
        """Free space between its edge and the robot's hull."""
        return max(0.0, abs(self.at) - self.radius_m - RADIUS_M)


class Obstacles:
    """Discs in the robot's frame; immutable."""

    __slots__ = ("at", "radii_m", "robots")

    def __init__(self, at: Points, radii_m: Floats, robots: Flags) -> None:
        self.at = at
        self.radii_m = radii_m
        self.robots = robots

    @classmethod
    def of(cls, discs: Iterable[Obstacle]) -> "Obstacles":
        """Convert single discs to columns."""
        each = tuple(discs)
        return cls(
            np.array([one.at for one in each], dtype=np.complex128),
            np.array([one.radius_m for one in each], dtype=np.float64),
            np.array([one.is_robot for one in each], dtype=np.bool_),
        )

    def nearest(self, sector_rad: float, *, robots_only: bool = False) -> tuple[float, complex] | None:
        """The smallest gap to the hull in a sector to either side of straight ahead, and the disc's centre."""
        gap_m, at = _nearest(self.at, self.radii_m, self.robots, RADIUS_M, sector_rad, robots_only)
        return None if gap_m == inf else (gap_m, at)

    def __iter__(self) -> Iterator[Obstacle]:
        columns = (self.at.tolist(), self.radii_m.tolist(), self.robots.tolist())
        for at, radius_m, is_robot in zip(*columns, strict=True):
            yield Obstacle(at=at, radius_m=radius_m, is_robot=is_robot)

    def __len__(self) -> int:
        return len(self.at)


class ObstacleCollector:
    """Collects the obstacles of one tick from the bodies in view, the whiskers and the bumper."""

    def __init__(self, things: Floats, lengths_m: Floats, more: int) -> None:
        """Begin with the bodies in view.

        :param things: shape (N, 3): range, bearing and aspect of each body in view, as in `Sightings.read`.
        :param lengths_m: shape (N,): an object's length, 0 for a compact sample, or `ROBOT` or `NO_OBSTACLE`.
        :param more: the most hits of whiskers and other discs to be added, besides the bumper's.
        """
        # NOTE: allocated for the largest number of discs; bodies come first, so that `collected` need not copy.
        capacity = len(LONG_OBJECT_DISC_SHARES) * len(things) + more + 1
        self._at = np.empty(capacity, np.complex128)
        self._radii_m = np.empty(capacity)
        self._robots = np.empty(capacity, np.bool_)
        self._count = _put_bodies(things, lengths_m, RADIUS_M, self._at, self._radii_m, self._robots)

    def add_hits(self, ranges_m: Floats, min_range_m: float) -> None:
        """Add the whiskers' hits, except on robots in view.

        A reading at the shortest range only says that something is nearer: it is placed at half the range (our choice).

        :param ranges_m: shape (W,), from the hull, beam 0 ahead, counter-clockwise, inf where nothing is met.
        """
        columns = (self._at, self._radii_m, self._robots)
        self._count = _put_hits(ranges_m, min_range_m, RADIUS_M, *columns, self._count)

    def add(self, at: complex, radius_m: float) -> None:
        """Add an obstacle that is not a robot."""
        self._at[self._count] = at
        self._radii_m[self._count] = radius_m
        self._robots[self._count] = False
        self._count += 1

    def collected(self) -> Obstacles:
        """The obstacles added up to now."""
        count = self._count
        return Obstacles(self._at[:count], self._radii_m[:count], self._robots[:count])


@kernel
def _nearest(
    at: Points, radii_m: Floats, robots: Flags, hull_m: float, sector_rad: float, robots_only: bool
) -> tuple[float, complex]:
    least_m = inf
    nearest = 0j
    for n in range(len(at)):
        if robots_only and not robots[n]:
            continue
        if abs(np.arctan2(at[n].imag, at[n].real)) > sector_rad:
            continue
        gap_m = max(0.0, hypot(at[n].real, at[n].imag) - radii_m[n] - hull_m)
        if gap_m < least_m:
            least_m = gap_m
            nearest = at[n]
    return least_m, nearest


@kernel
def _put_bodies(
    things: Floats, lengths_m: Floats, robot_m: float, at: Points, radii_m: Floats, robots: Flags
) -> int:
    """Write one disc for a robot or a compact sample, several for a long one; returns their number."""
    found = 0
    for n in range(len(things)):
        if np.isnan(lengths_m[n]):
            continue
        middle = _from_polar(things[n, 0], things[n, 1])
        if lengths_m[n] <= 0:
            at[found] = middle
            robots[found] = lengths_m[n] < 0
            radii_m[found] = robot_m if robots[found] else SAMPLE_RADIUS_M
            found += 1
            continue
        along = _from_polar(lengths_m[n], things[n, 1] - things[n, 2])
        for share in LONG_OBJECT_DISC_SHARES:
            at[found] = middle + share * 1j * along
            robots[found] = False
            radii_m[found] = SAMPLE_RADIUS_M
            found += 1
    return found


@kernel
def _put_hits(
    ranges_m: Floats,
    min_range_m: float,
    robot_m: float,
    at: Points,
    radii_m: Floats,
    robots: Flags,
    bodies: int,
) -> int:
    """Write a disc after the bodies for every hit that is on no robot; returns the number of discs."""
    found = bodies
    for beam in range(len(ranges_m)):
        range_m = ranges_m[beam] if ranges_m[beam] > min_range_m else min_range_m / 2
        if range_m == inf:
            continue
        hit = _from_polar(robot_m + range_m, 2 * pi * beam / len(ranges_m))
        for n in range(bodies):
            if robots[n] and hypot(at[n].real - hit.real, at[n].imag - hit.imag) < robot_m + ON_ROBOT_M:
                break
        else:
            at[found] = hit
            robots[found] = False
            radii_m[found] = WHISKER_RADIUS_M
            found += 1
    return found


@part
def _from_polar(size: float, angle_rad: float) -> complex:
    return complex(size * cos(angle_rad), size * sin(angle_rad))
