"""Virtual sensors for steering: the free course to a point, and the guidance to the approach point of a place."""

from cmath import phase
from dataclasses import dataclass
from math import asin, atan2, cos, hypot, inf, isnan, nan, pi, radians
from operator import itemgetter

import numpy as np

from robots.compiled import kernel, part
from robots.perception.obstacles import Flags, Floats, Obstacles, Points
from robots.perception.percepts import Percepts
from robots.physical.body import RADIUS_M
from robots.physical.geometry import wrap

LOOK_AHEAD_M = 1.2
LOOK_AHEAD_ROBOT_M = 2.0
MARGIN_M = 0.07
MARGIN_ROBOT_M = 0.15
KEEP_RIGHT_RAD = radians(25)
"""By how much the shadow of a robot is wider on its left: two that meet head-on both pass on the right."""
STEP_RAD = radians(5)
CLOSE_M = 0.3
"""Within this distance of the approach point the robot goes there straight, ahead or back."""
ARRIVED_M = 0.08
"""Within this distance it faces the beacon and corrects along its own axis only."""
_STEPS = round(2 * pi / STEP_RAD)
_CANDIDATES = tuple(sorted(((k, min(k, _STEPS - k) * STEP_RAD) for k in range(_STEPS)), key=itemgetter(1)))
"""Candidate directions: steps to the left of the target's, and the angle from it; the nearest first."""


def clear_course(target: complex, obstacles: Obstacles) -> float | None:
    """The free direction closest to a target's, radians in the robot's frame; None if every way is blocked.

    Our choice: the paper's robots only turn away from what is near. Every disc between robot and target
    blocks the directions in which the hull would touch it; of the free ones the one nearest to the target's
    direction and, less, to the present heading is taken.
    """
    course = _clear(target, obstacles.at, obstacles.radii_m, obstacles.robots, RADIUS_M)
    return None if isnan(course) else course


@kernel
def _clear(target: complex, at: Points, radii_m: Floats, robots: Flags, hull_m: float) -> float:
    """`clear_course`, compiled; NaN for None. `hull_m`: the robot's radius."""
    low, width = _shadows(hypot(target.real, target.imag), at, radii_m, robots, hull_m)
    straight = atan2(target.imag, target.real)
    best = nan
    least = inf
    for n in range(len(_CANDIDATES)):
        steps, off_rad = _CANDIDATES[n]
        if off_rad > least:
            break  # no later candidate can cost less
        angle = wrap(straight + steps * STEP_RAD) if steps else straight
        cost = abs(wrap(angle - straight)) + 0.2 * abs(angle) + (0.01 if angle > 0 else 0)
        if cost < least and not np.any((angle - low) % (2 * pi) < width):
            best = angle
            least = cost
    return best


@part
def _shadows(
    distance_m: float, at: Points, radii_m: Floats, robots: Flags, hull_m: float
) -> tuple[Floats, Floats]:
    """The directions that discs block: start and width of each interval, counter-clockwise."""
    low = np.empty(len(at))
    width = np.empty(len(at))
    found = 0
    for n in range(len(at)):
        away_m = hypot(at[n].real, at[n].imag)
        reach_m = LOOK_AHEAD_ROBOT_M if robots[n] else LOOK_AHEAD_M
        if away_m - radii_m[n] >= min(reach_m, distance_m + hull_m):
            continue
        margin_m = MARGIN_ROBOT_M if robots[n] else MARGIN_M
        half = asin(max(-1.0, min(1.0, (radii_m[n] + hull_m + margin_m) / max(away_m, 1e-6))))
        middle = atan2(at[n].imag, at[n].real)
        low[found] = middle - half
        width[found] = middle + half + (KEEP_RIGHT_RAD if robots[n] else 0.0) - low[found]
        found += 1
    return low[:found], width[:found]


@dataclass(frozen=True, slots=True, kw_only=True)
class Guidance:
    """How to reach an approach pose: turn (radians) and advance (metres, negative back)."""

    turn_rad: float
    advance_m: float


def guide(percepts: Percepts, place: str) -> Guidance | None:
    """Guidance to the approach point of a place; None if it is unknown or every way is blocked.

    Far off it is the clear course, close to the point straight ahead or back, whichever is nearer; at the point the
    robot only faces the beacon.
    """
    return percepts.once(("guide", place), lambda: _guide(percepts, place))


def _guide(percepts: Percepts, place: str) -> Guidance | None:
    point = percepts.approach_point(place)
    beacon = percepts.locate(place)
    if point is None or beacon is None:
        return None
    return guidance(point, beacon, percepts.obstacles)


def guidance(point: complex, beacon: complex, obstacles: Obstacles) -> Guidance | None:
    """As `guide`, for points and obstacles in the frame of whatever moves there."""
    distance_m = abs(point)
    if distance_m <= ARRIVED_M:
        return Guidance(turn_rad=phase(beacon), advance_m=point.real)
    if distance_m <= CLOSE_M:
        way = 1 if point.real >= 0 else -1
        turn_rad = phase(way * point)
        return Guidance(turn_rad=turn_rad, advance_m=way * distance_m * cos(turn_rad) ** 2)
    course = clear_course(point, obstacles)
    if course is None:
        return None
    return Guidance(turn_rad=course, advance_m=distance_m * max(0.0, cos(course)) ** 2)
