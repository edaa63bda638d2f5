"""Virtual sensors of two robots that carry a long object side by side (MACTA §5: "an articulated unit").

Each robot steers the whole formation by its own sensors: the object's centre and direction by its tag, obstacles by its
whiskers. They do not communicate; the object on the capture heads couples them. All of it is our choice.
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
"""Both robots turn left towards what lies farther round than this."""
BESIDE_M = 0.35
"""An obstacle this near to the partner's place is the partner."""

PointOrPoints = TypeVar("PointOrPoints", complex, Points)


@dataclass(frozen=True, slots=True, kw_only=True)
class Formation:
    """The formation in the robot's frame.

    `middle`: midway between the robots, where a single robot with the object in its jaws would stand. `heading_rad`:
    square to the object, relative to the robot's heading. `length_m`: the object's.
    """

    middle: complex
    heading_rad: float
    length_m: float

    @property
    def radius_m(self) -> float:
        """The radius of a disc around the formation."""
        return self.length_m / 2 + RADIUS_M

    @property
    def offset_m(self) -> float:
        """The robot's own offset to the left of the middle."""
        return self.to_formation(0j).imag

    @property
    def partner(self) -> complex:
        """The place of the other robot; robot's frame."""
        return 2 * self.middle

    def to_formation(self, point: PointOrPoints) -> PointOrPoints:
        """One or several points of the robot's frame in the formation's frame."""
        return (point - self.middle) * rect(1.0, -self.heading_rad)


def formation_with(percepts: Percepts, thing: str) -> Formation | None:
    """The formation that carries an object; None if it is not in the robot's jaws or not in view."""
    at = percepts.locate(thing)
    axis = percepts.axis(thing)
    length_m = percepts.profile.lengths_m.get(thing)
    if percepts.holding != thing or at is None or axis is None or length_m is None:
        return None
    middle = at + rect(GRIPPER_REACH_M, axis)
    return Formation(middle=middle, heading_rad=wrap(axis + pi), length_m=length_m)


def guide_formation(percepts: Percepts, thing: str, place: str) -> Guidance | None:
    """Guidance of the formation to the approach point of a place, with the object towards the place."""
    return percepts.once(("formation", thing, place), lambda: _guide(percepts, thing, place))


def _guide(percepts: Percepts, thing: str, place: str) -> Guidance | None:
    whole = formation_with(percepts, thing)
    point = percepts.approach_point(place)
    beacon = percepts.locate(place)
    if whole is None or point is None or beacon is None:
        return None
    in_the_way = _obstacles(percepts, whole)
    found = guidance(whole.to_formation(point), whole.to_formation(beacon), in_the_way)
    # NOTE: straight behind, noise alone would decide the side, for each robot differently.
    return replace(found, turn_rad=pi) if found is not None and found.turn_rad < -BEHIND_RAD else found


def _obstacles(percepts: Percepts, whole: Formation) -> Obstacles:
    """The obstacles without the partner, enlarged by what the formation is wider than one robot."""
    about = percepts.obstacles
    wider_m = whole.radius_m - RADIUS_M
    others = np.abs(about.at - whole.partner) > BESIDE_M
    at = whole.to_formation(about.at[others])
    radii_m = about.radii_m[others] + wider_m
    return Obstacles(at, radii_m, np.zeros(len(at), np.bool_))


def put_down_point(percepts: Percepts, thing: str, place: str) -> complex | None:
    """The place as seen if the object's centre were in the jaws; robot's frame."""
    middle = percepts.locate(thing)
    at = percepts.locate(place)
    return None if middle is None or at is None else at - middle + GRIPPER_REACH_M
