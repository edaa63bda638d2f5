"""Stimuli for carrying a long object by two robots, and for putting it down."""

from cmath import phase
from math import cos, pi
from typing import Annotated

from pydantic import Field

from robots.perception.formation import formation_with, guide_formation, put_down_point
from robots.perception.percepts import LOCATING, SURROUNDINGS, Percepts
from robots.physical.body import GRIPPER_REACH_M
from robots.physical.geometry import clip
from robots.reactive.stimuli import Stimulus


class JointWayOn(Stimulus, needs=SURROUNDINGS):
    """The speed at which the formation goes to a place: 1 is the robot's full speed.

    The middle goes at `cruise`, less within `full_m` of the point; in a bend the inner robot is slower than the middle,
    the outer one faster.
    """

    object: str
    place: str
    cruise: Annotated[float, Field(gt=0, le=1)] = 0.5
    full_m: Annotated[float, Field(gt=0, le=5)] = 0.5
    full_rad: Annotated[float, Field(gt=0, le=pi)] = 0.6
    turn_rad_s: Annotated[float, Field(gt=0, le=2)] = 0.45

    def read(self, percepts: Percepts) -> float | None:
        whole = formation_with(percepts, self.object)
        guidance = guide_formation(percepts, self.object, self.place)
        if whole is None or guidance is None:
            return None
        middle = self.cruise * clip(guidance.advance_m / self.full_m)
        turn_rad_s = self.turn_rad_s * clip(guidance.turn_rad / self.full_rad)
        return clip(middle - turn_rad_s * whole.offset_m / percepts.profile.speed_at(percepts.pose))


class JointWayRound(Stimulus, needs=SURROUNDINGS):
    """The turn rate at which the formation goes to a place: 1 is the robot's full turn rate."""

    object: str
    place: str
    full_rad: Annotated[float, Field(gt=0, le=pi)] = 0.6
    turn_rad_s: Annotated[float, Field(gt=0, le=2)] = 0.45

    def read(self, percepts: Percepts) -> float | None:
        guidance = guide_formation(percepts, self.object, self.place)
        if guidance is None:
            return None
        return clip(self.turn_rad_s * clip(guidance.turn_rad / self.full_rad) / percepts.profile.turn_rad_s)


class Askew(Stimulus, needs=LOCATING):
    """The robot's angle off square to the long object it holds; 1 if it has to turn `full_rad` to the left."""

    object: str
    full_rad: Annotated[float, Field(gt=0, le=pi)] = 0.6

    def read(self, percepts: Percepts) -> float | None:
        whole = formation_with(percepts, self.object)
        return None if whole is None else clip(whole.heading_rad / self.full_rad)


class PutAhead(Stimulus, needs=LOCATING):
    """How far ahead the middle of the held object has to go to lie at a place; 1 at `full_m`."""

    object: str
    place: str
    full_m: Annotated[float, Field(gt=0, le=5)] = 0.4

    def read(self, percepts: Percepts) -> float | None:
        at = put_down_point(percepts, self.object, self.place)
        if at is None:
            return None
        return clip((abs(at) - GRIPPER_REACH_M) * max(0.0, cos(phase(at))) ** 4 / self.full_m)


class PutAside(Stimulus, needs=LOCATING):
    """The direction that the held object's middle has to go to lie at a place; 1 at `full_rad` to the left."""

    object: str
    place: str
    full_rad: Annotated[float, Field(gt=0, le=pi)] = 0.6

    def read(self, percepts: Percepts) -> float | None:
        at = put_down_point(percepts, self.object, self.place)
        return None if at is None else clip(phase(at) / self.full_rad)
