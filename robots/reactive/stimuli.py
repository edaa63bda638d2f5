"""Stimuli: what a behaviour pattern reacts to, one normalised number s in [-1, 1]; None when it is not sensed.

Some are plain sensors (whiskers, capture head, light barrier), some virtual ones: directions computed from sightings.
"""

from abc import ABC, abstractmethod
from cmath import phase
from math import cos, pi
from typing import Annotated, Literal

from pydantic import Field

from robots.perception.course import guide
from robots.perception.percepts import (
    GRIP,
    HEAD,
    LOCATING,
    SURROUNDINGS,
    Needs,
    Percepts,
    SensingVariant,
)
from robots.physical.geometry import clip


class Stimulus(SensingVariant, ABC):
    """One sensory stimulus (MACTA eq. 1): a subclass for each that data may state, `{sense: bearing, target: bay}`."""

    @abstractmethod
    def read(self, percepts: Percepts) -> float | None:
        """s in [-1, 1]; None if it is not sensed."""


class Always(Stimulus):
    """Always 1, without a sensor."""

    def read(self, percepts: Percepts) -> float | None:
        return 1.0


class WayOn(Stimulus, needs=SURROUNDINGS):
    """The advance of the guidance to a place; 1 at `full_m` or more, negative: back."""

    place: str
    full_m: Annotated[float, Field(gt=0, le=5)] = 0.6

    def read(self, percepts: Percepts) -> float | None:
        guidance = guide(percepts, self.place)
        return None if guidance is None else clip(guidance.advance_m / self.full_m)


class WayRound(Stimulus, needs=SURROUNDINGS):
    """The turn of the guidance to a place; 1 at `full_rad` to the left."""

    place: str
    full_rad: Annotated[float, Field(gt=0, le=pi)] = 0.8

    def read(self, percepts: Percepts) -> float | None:
        guidance = guide(percepts, self.place)
        return None if guidance is None else clip(guidance.turn_rad / self.full_rad)


class Ahead(Stimulus, needs=LOCATING):
    """How far something is ahead of a point `short_of_m` before the robot's centre; 1 at `full_m`.

    Off to the side it shrinks with the bearing's cosine, so that the robot turns first.
    """

    target: str
    short_of_m: Annotated[float, Field(ge=0, le=5)] = 0.0
    full_m: Annotated[float, Field(gt=0, le=5)] = 0.4

    def read(self, percepts: Percepts) -> float | None:
        at = percepts.locate(self.target)
        if at is None:
            return None
        facing = max(0.0, cos(phase(at))) ** 4
        return clip((abs(at) - self.short_of_m) * facing / self.full_m)


class Bearing(Stimulus, needs=LOCATING):
    """The direction of something; 1 at `full_rad` to the left."""

    target: str
    full_rad: Annotated[float, Field(gt=0, le=pi)] = 0.6

    def read(self, percepts: Percepts) -> float | None:
        at = percepts.locate(self.target)
        return None if at is None else clip(phase(at) / self.full_rad)


class Proximity(Stimulus):
    """s1 of table 2: the nearest thing within a sector ahead; 0 at `reach_m` from the hull, 1 at touch.

    `side`: signed, positive when it is to the right, so that turning by s turns away from it; dead ahead
    counts as left (keep right). `robots`: only other robots. `until`: what lies farther than that place's
    approach point is not in the way.
    """

    reach_m: Annotated[float, Field(gt=0, le=2)] = 0.3
    sector_rad: Annotated[float, Field(gt=0, le=pi)] = 0.8
    side: bool = False
    robots: bool = False
    until: str | None = None

    @property
    def needs(self) -> Needs:
        return LOCATING if self.robots else SURROUNDINGS

    def read(self, percepts: Percepts) -> float | None:
        about = percepts.bodies if self.robots else percepts.obstacles
        nearest = about.nearest(self.sector_rad, robots_only=self.robots)
        if nearest is None:
            return 0.0
        gap_m, at = nearest
        s = clip(1 - gap_m / self._reach(percepts), 0.0)
        return s if not self.side or phase(at) < 0 else -s

    def _reach(self, percepts: Percepts) -> float:
        point = percepts.approach_point(self.until) if self.until is not None else None
        return self.reach_m if point is None else min(self.reach_m, abs(point) + 0.03)


class CaptureHead(Stimulus, needs=HEAD):
    """s2 of table 2: how far the object is off the capture head's middle; 1 at `full_m` ahead or left."""

    axis: Literal["x", "y"]
    full_m: Annotated[float, Field(gt=0, le=0.5)] = 0.05

    def read(self, percepts: Percepts) -> float | None:
        x, y = percepts.capture_head_m
        return clip((x if self.axis == "x" else y) / self.full_m)


class Barrier(Stimulus, needs=GRIP):
    """The jaws' light barrier: 1 while the object stands between the jaws, -1 otherwise."""

    object: str

    def read(self, percepts: Percepts) -> float | None:
        return 1.0 if percepts.gripper.between_jaws == self.object else -1.0


class LowBattery(Stimulus):
    """0 while the battery holds `enough` or more, 1 when it is empty."""

    enough: Annotated[float, Field(gt=0, le=1)] = 0.2

    def read(self, percepts: Percepts) -> float | None:
        return clip(1 - percepts.battery / self.enough, 0.0)


class DriveCommand(Stimulus):
    """What an operator who drives the robot commands on one axis; None if nobody drives."""

    axis: Literal["forward", "left"]

    def read(self, percepts: Percepts) -> float | None:
        command = percepts.drive_command
        if command is None:
            return None
        return command.forward if self.axis == "forward" else command.left
