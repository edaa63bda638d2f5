"""What is in the way, as discs in the robot's frame: columns, and one disc for who asks for one. Compiled (numba).

Arrays: at: shape (N,), complex, metres; radii_m: shape (N,); robots: shape (N,), which of them are other robots.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import cos, hypot, inf, nan, pi, sin
from typing import overload

import numba
import numpy as np
from numpy.typing import NDArray

from robots.physical.body import RADIUS_M

SAMPLE_RADIUS_M = 0.06
WHISKER_RADIUS_M = 0.02
LONG_SHARES = (-0.5, -0.25, 0.0, 0.25, 0.5)
"""Where along a long object it is taken to be in the way."""

ROBOT, NOTHING_SOLID = -1.0, nan
"""Stand for the length of what is no sample."""

Points = NDArray[np.complex128]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Obstacle:
    """Something in the way: a disc in the robot's frame, metres."""

    at: complex
    radius_m: float
    is_robot: bool = False

    @property
    def gap_m(self) -> float:
        """Free space between its edge and the robot's hull."""
        return max(0.0, abs(self.at) - self.radius_m - RADIUS_M)


class Obstacles(Sequence[Obstacle]):
    """Discs in the robot's frame; not to be changed."""

    __slots__ = ("at", "radii_m", "robots")

    def __init__(self, at: Points, radii_m: Floats, robots: Flags) -> None:
        self.at, self.radii_m, self.robots = at, radii_m, robots

    @classmethod
    def of(cls, discs: Iterable[Obstacle]) -> "Obstacles":
        """From discs one by one."""
        each = tuple(discs)
        return cls(
            np.array([one.at for one in each], dtype=np.complex128),
            np.array([one.radius_m for one in each], dtype=np.float64),
            np.array([one.is_robot for one in each], dtype=np.bool_),
        )

    def nearest(self, sector_rad: float, *, robots_only: bool = False) -> tuple[float, complex] | None:
        """The least gap to the hull among what lies within a sector to either side of ahead, and where that is."""
        gap_m, at = _nearest(self.at, self.radii_m, self.robots, RADIUS_M, sector_rad, robots_only)
        return None if gap_m == inf else (gap_m, at)

    @overload
    def __getitem__(self, number: int) -> Obstacle: ...
    @overload
    def __getitem__(self, number: slice) -> "Obstacles": ...
    def __getitem__(self, number: int | slice) -> "Obstacle | Obstacles":
        if isinstance(number, slice):
            return Obstacles(self.at[number], self.radii_m[number], self.robots[number])
        return Obstacle(
            at=complex(self.at[number]),
            radius_m=float(self.radii_m[number]),
            is_robot=bool(self.robots[number]),
        )

    def __iter__(self) -> Iterator[Obstacle]:
        columns = (self.at.tolist(), self.radii_m.tolist(), self.robots.tolist())
        for at, radius_m, is_robot in zip(*columns, strict=True):
            yield Obstacle(at=at, radius_m=radius_m, is_robot=is_robot)

    def __len__(self) -> int:
        return len(self.at)


class Surroundings:
    """What sightings and whiskers tell stands in the way, put together disc by disc."""

    def __init__(self, things: Floats, lengths_m: Floats, whiskers: int) -> None:
        """Begin with the bodies in view.

        :param things: shape (N, 3), as of `Sightings`.
        :param lengths_m: shape (N,): a sample's length, 0 of a compact one; `ROBOT` or `NOTHING_SOLID`.
        :param whiskers: how many there are.
        """
        # NOTE: room for all is made here, so that bodies are the first part of what is about, and nothing is copied.
        most = len(LONG_SHARES) * len(things) + whiskers + 1
        self._at, self._radii_m = np.empty(most, np.complex128), np.empty(most)
        self._robots = np.empty(most, np.bool_)
        self._count = _put_bodies(things, lengths_m, RADIUS_M, self._at, self._radii_m, self._robots)

    def add_hits(self, ranges_m: Floats, least_m: float) -> None:
        """Add where whiskers meet something that is none of the robots in view.

        The least that a whisker can read only says that something is nearer: it is taken to be half as far (our
        choice).

        :param ranges_m: shape (W,), from the hull, beam 0 ahead, counter-clockwise, inf where nothing is met.
        """
        columns = (self._at, self._radii_m, self._robots)
        self._count = _put_hits(ranges_m, least_m, RADIUS_M, *columns, self._count)

    def add(self, at: complex, radius_m: float) -> None:
        """Add one thing more that is no robot."""
        self._at[self._count], self._radii_m[self._count], self._robots[self._count] = at, radius_m, False
        self._count += 1

    def so_far(self) -> Obstacles:
        many = self._count
        return Obstacles(self._at[:many], self._radii_m[:many], self._robots[:many])


# NOTE: the compiler's cache does not see that a number changes which is imported: such are handed to what is compiled.
@numba.njit(cache=True)
def _nearest(
    at: Points, radii_m: Floats, robots: Flags, hull_m: float, sector_rad: float, robots_only: bool
) -> tuple[float, complex]:
    least_m, nearest = inf, 0j
    for n in range(len(at)):
        if robots_only and not robots[n]:
            continue
        if abs(np.arctan2(at[n].imag, at[n].real)) > sector_rad:
            continue
        gap_m = max(0.0, hypot(at[n].real, at[n].imag) - radii_m[n] - hull_m)
        if gap_m < least_m:
            least_m, nearest = gap_m, at[n]
    return least_m, nearest


@numba.njit(cache=True)
def _put_bodies(
    read: Floats, lengths_m: Floats, robot_m: float, at: Points, radii_m: Floats, robots: Flags
) -> int:
    """Fill in a disc around a robot or a compact sample, several along a long one; how many."""
    found = 0
    for n in range(len(read)):
        if np.isnan(lengths_m[n]):
            continue
        middle = _rect(read[n, 0], read[n, 1])
        if lengths_m[n] <= 0:
            at[found], robots[found] = middle, lengths_m[n] < 0
            radii_m[found] = robot_m if robots[found] else SAMPLE_RADIUS_M
            found += 1
            continue
        along = _rect(lengths_m[n], read[n, 1] - read[n, 2])
        for share in LONG_SHARES:
            at[found], robots[found], radii_m[found] = middle + share * 1j * along, False, SAMPLE_RADIUS_M
            found += 1
    return found


@numba.njit(cache=True)
def _put_hits(
    ranges_m: Floats,
    least_m: float,
    robot_m: float,
    at: Points,
    radii_m: Floats,
    robots: Flags,
    bodies: int,
) -> int:
    """Fill in, after the bodies, a disc at every hit that is none of the robots; how many there are then."""
    found = bodies
    for beam in range(len(ranges_m)):
        range_m = ranges_m[beam] if ranges_m[beam] > least_m else least_m / 2
        if range_m == inf:
            continue
        hit = _rect(robot_m + range_m, 2 * pi * beam / len(ranges_m))
        for n in range(bodies):
            if robots[n] and hypot(at[n].real - hit.real, at[n].imag - hit.imag) < robot_m + 0.1:
                break
        else:
            at[found], robots[found], radii_m[found] = hit, False, WHISKER_RADIUS_M
            found += 1
    return found


@numba.njit(cache=True)
def _rect(size: float, angle_rad: float) -> complex:
    return complex(size * cos(angle_rad), size * sin(angle_rad))
