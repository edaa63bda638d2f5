"""Two robots side by side with a long object in their jaws, as each senses it (MACTA §5: "an articulated unit").

Each steers the whole by what it senses itself: the object's middle and direction by its tag, what is in the way by its
whiskers. Nothing is agreed between them; where they differ, the object on their capture heads tells them. All of it
is our choice.
"""

from cmath import rect
from dataclasses import dataclass, replace
from math import pi
from typing import TypeVar

import numpy as np

from robots.perception.course import Guidance, guidance
from robots.perception.obstacles import Obstacles, Points
from robots.perception.percepts import Percepts
from robots.physical.body import GRIPPER_REACH_M, RADIUS_M
from robots.physical.geometry import wrap

BEHIND_RAD = 2.4
"""To what lies farther round than this both turn by the left."""
BESIDE_M = 0.35
"""What is met this near to where the partner stands is the partner."""

PointOrPoints = TypeVar("PointOrPoints", complex, Points)


@dataclass(frozen=True, slots=True, kw_only=True)
class Formation:
    """`middle`: between the two robots, where one would stand that carried the object in its own jaws; robot's frame.

    `heading_rad`: how the whole heads, square to the object; relative to my heading. `length_m`: the object's.
    """

    middle: complex
    heading_rad: float
    length_m: float

    @property
    def radius_m(self) -> float:
        """Of a disc around all of it."""
        return self.length_m / 2 + RADIUS_M

    @property
    def offset_m(self) -> float:
        """How far to the left of the middle I stand."""
        return self.to_formation(0j).imag

    @property
    def partner(self) -> complex:
        """Where the other robot stands; robot's frame."""
        return 2 * self.middle

    def to_formation(self, point: PointOrPoints) -> PointOrPoints:
        """A point of the robot's frame, or several, as from the middle: x ahead of the whole, y to its left."""
        return (point - self.middle) * rect(1.0, -self.heading_rad)


def formation_with(percepts: Percepts, thing: str) -> Formation | None:
    """The formation of whom carry an object; None if it is not in my jaws or not in view."""
    at, axis, length_m = percepts.locate(thing), percepts.axis(thing), percepts.profile.lengths_m.get(thing)
    if percepts.holding != thing or at is None or axis is None or length_m is None:
        return None
    middle = at + rect(GRIPPER_REACH_M, axis)
    return Formation(middle=middle, heading_rad=wrap(axis + pi), length_m=length_m)


def guide_formation(percepts: Percepts, thing: str, place: str) -> Guidance | None:
    """How the whole is to turn and go on to come to stand near a place with the object between place and robots."""
    return percepts.once(("formation", thing, place), lambda: _guided(percepts, thing, place))


def _guided(percepts: Percepts, thing: str, place: str) -> Guidance | None:
    whole = formation_with(percepts, thing)
    point, beacon = percepts.approach_point(place), percepts.locate(place)
    if whole is None or point is None or beacon is None:
        return None
    in_the_way = _obstacles(percepts, whole)
    found = guidance(whole.to_formation(point), whole.to_formation(beacon), in_the_way)
    # NOTE: what lies behind is as far to the left as to the right: by noise each would take another way round.
    return replace(found, turn_rad=pi) if found is not None and found.turn_rad < -BEHIND_RAD else found


def _obstacles(percepts: Percepts, whole: Formation) -> Obstacles:
    """What stands about without the partner, as wide as if the formation were no wider than one robot."""
    about, wider_m = percepts.obstacles, whole.radius_m - RADIUS_M
    others = np.abs(about.at - whole.partner) > BESIDE_M
    at, radii_m = whole.to_formation(about.at[others]), about.radii_m[others] + wider_m
    return Obstacles(at, radii_m, np.zeros(len(at), np.bool_))


def put_down_point(percepts: Percepts, thing: str, place: str) -> complex | None:
    """Where the place would be seen if the object's middle were in the jaws; robot's frame."""
    middle, at = percepts.locate(thing), percepts.locate(place)
    return None if middle is None or at is None else at - middle + GRIPPER_REACH_M
