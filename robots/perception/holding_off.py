"""Where a robot holds off a place: near it, but neither before another place nor beside another robot.

Our choice: of points on rings about the place's approach point the cheapest, by the way over it, and by how far it is
short of the distances below. Robots do not know walls; the points lie between the approach points of places that they
know, where the floor is free.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from robots.physical.profile import BeaconSpec, RobotProfile

RINGS_M = (1.1, 1.3, 1.5, 1.75, 2.0)
"""From the approach point: beyond what a robot that leaves it needs to turn."""
DIRECTIONS = 24
APART_M = 0.85
"""From the approach points of other places, and from other robots: two robots touch at 0.44 m, and one is to pass."""
ABOUT_M = 4.0
"""Places farther from the place do not count."""
BESIDE_M = 0.3
"""How far beside the places that the robot knows the floor is taken to be free."""
SHORT_COST = 4.0
"""Metres of way that a metre nearer than `APART_M` is worth."""
RING_COST = 0.3
"""Likewise a metre farther from the place, which costs time once it is clear."""

Points = NDArray[np.complex128]
_RINGS = np.outer(RINGS_M, np.exp(2j * np.pi * np.arange(DIRECTIONS) / DIRECTIONS))


def hold_off_point(
    profile: RobotProfile, place: str, here: complex, robots: Iterable[complex]
) -> complex | None:
    """The point in the world's frame; None if the place is unknown.

    :param here: where the robot is, and `robots` those that it sees, in the world's frame, metres.
    """
    beacon = profile.places.get(place)
    if beacon is None:
        return None
    point = _nearest(beacon, here)
    of_places = (_nearest(one, point) for name, one in profile.beacons.items() if name != place)
    others = [one for one in of_places if abs(one - point) <= ABOUT_M]
    candidates = _between([here, point, *others], (point + _RINGS).ravel())
    costs = abs(candidates - here) + (1 + RING_COST) * abs(candidates - point)
    costs += _crowding(candidates, [*others, *robots])
    return complex(candidates[np.argmin(costs)])


def _nearest(beacon: BeaconSpec, to: complex) -> complex:
    return min(beacon.approach_points, key=lambda point: abs(point - to))


def _between(known: Sequence[complex], candidates: Points) -> Points:
    """Those of the candidates that lie between what is known to be free floor; all if none does."""
    inside = np.ones(len(candidates), bool)
    for along, free in ((candidates.real, np.real(known)), (candidates.imag, np.imag(known))):
        inside &= (along >= free.min() - BESIDE_M) & (along <= free.max() + BESIDE_M)
    return candidates[inside] if inside.any() else candidates


def _crowding(candidates: Points, about: Sequence[complex]) -> NDArray[np.float64]:
    if not about:
        return np.zeros(len(candidates))
    nearest_m: NDArray[np.float64] = np.abs(candidates[:, None] - np.array(about)).min(axis=1)
    return SHORT_COST * np.maximum(0.0, APART_M - nearest_m)
