"""Stimuli: what a behaviour pattern reacts to, one normalised number s in [-1, 1]; None when it is not sensed.

Some are plain sensors (whiskers, capture head, light barrier), some virtual ones: directions computed from sightings.
"""

from cmath import phase
from dataclasses import dataclass
from math import cos, pi
from typing import Annotated, ClassVar, Literal, Protocol

from pydantic import Field

from robots.data import Strict
from robots.perception.course import guide
from robots.perception.percepts import GRIP, HEAD, LOCATING, NOTHING, SURROUNDINGS, Needs, Percepts
from robots.physical.geometry import clip
from robots.reactive.carrying import Askew, JointWayOn, JointWayRound, PutAhead, PutAside
from robots.reactive.steering import (
    Alongside,
    Astern,
    Course,
    Distance,
    ToAdvance,
    ToGo,
    ToHeading,
    ToTurn,
    Whim,
)


class Stimulus(Protocol):
    """One sensory stimulus (MACTA eq. 1). `needs`: the sensors that it reads."""

    @property
    def needs(self) -> Needs: ...

    def read(self, percepts: Percepts) -> float | None: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Always(Strict):
    """Always 1, without a sensor."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["always"] = "always"

    def read(self, percepts: Percepts) -> float | None:
        return 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class WayOn(Strict):
    """The advance of the guidance to a place; 1 at `full_m` or more, negative: back."""

    needs: ClassVar[Needs] = SURROUNDINGS
    sense: Literal["way_on"] = "way_on"
    place: str
    full_m: Annotated[float, Field(gt=0, le=5)] = 0.6

    def read(self, percepts: Percepts) -> float | None:
        guidance = guide(percepts, self.place)
        return None if guidance is None else clip(guidance.advance_m / self.full_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class WayRound(Strict):
    """The turn of the guidance to a place; 1 at `full_rad` to the left."""

    needs: ClassVar[Needs] = SURROUNDINGS
    sense: Literal["way_round"] = "way_round"
    place: str
    full_rad: Annotated[float, Field(gt=0, le=pi)] = 0.8

    def read(self, percepts: Percepts) -> float | None:
        guidance = guide(percepts, self.place)
        return None if guidance is None else clip(guidance.turn_rad / self.full_rad)


@dataclass(frozen=True, slots=True, kw_only=True)
class Ahead(Strict):
    """How far something is ahead of a point `short_of_m` before the robot's centre; 1 at `full_m`.

    Off to the side it shrinks with the bearing's cosine, so that the robot turns first.
    """

    needs: ClassVar[Needs] = LOCATING
    sense: Literal["ahead"] = "ahead"
    target: str
    short_of_m: Annotated[float, Field(ge=0, le=5)] = 0.0
    full_m: Annotated[float, Field(gt=0, le=5)] = 0.4

    def read(self, percepts: Percepts) -> float | None:
        at = percepts.locate(self.target)
        if at is None:
            return None
        facing = max(0.0, cos(phase(at))) ** 4
        return clip((abs(at) - self.short_of_m) * facing / self.full_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class Bearing(Strict):
    """The direction of something; 1 at `full_rad` to the left."""

    needs: ClassVar[Needs] = LOCATING
    sense: Literal["bearing"] = "bearing"
    target: str
    full_rad: Annotated[float, Field(gt=0, le=pi)] = 0.6

    def read(self, percepts: Percepts) -> float | None:
        at = percepts.locate(self.target)
        return None if at is None else clip(phase(at) / self.full_rad)


@dataclass(frozen=True, slots=True, kw_only=True)
class Proximity(Strict):
    """s1 of table 2: the nearest thing within a sector ahead; 0 at `reach_m` from the hull, 1 at touch.

    `side`: signed, positive when it is to the right, so that turning by s turns away from it; dead ahead
    counts as left (keep right). `robots`: only other robots. `until`: what lies farther than that place's
    approach point is not in the way.
    """

    sense: Literal["proximity"] = "proximity"
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


@dataclass(frozen=True, slots=True, kw_only=True)
class CaptureHead(Strict):
    """s2 of table 2: how far the object is off the capture head's middle; 1 at `full_m` ahead or left."""

    needs: ClassVar[Needs] = HEAD
    sense: Literal["capture_head"] = "capture_head"
    axis: Literal["x", "y"]
    full_m: Annotated[float, Field(gt=0, le=0.5)] = 0.05

    def read(self, percepts: Percepts) -> float | None:
        x, y = percepts.capture_head_m
        return clip((x if self.axis == "x" else y) / self.full_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class Barrier(Strict):
    """The jaws' light barrier: 1 while the object stands between the jaws, -1 otherwise."""

    needs: ClassVar[Needs] = GRIP
    sense: Literal["barrier"] = "barrier"
    object: str

    def read(self, percepts: Percepts) -> float | None:
        return 1.0 if percepts.gripper.between_jaws == self.object else -1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LowBattery(Strict):
    """0 while the battery holds `enough` or more, 1 when it is empty."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["low_battery"] = "low_battery"
    enough: Annotated[float, Field(gt=0, le=1)] = 0.2

    def read(self, percepts: Percepts) -> float | None:
        return clip(1 - percepts.battery / self.enough, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Commanded(Strict):
    """What an operator who drives the robot commands on one axis; None if nobody drives."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["drive_command"] = "drive_command"
    axis: Literal["forward", "left"]

    def read(self, percepts: Percepts) -> float | None:
        command = percepts.drive_command
        if command is None:
            return None
        return command.forward if self.axis == "forward" else command.left


AnyStimulus = Annotated[
    Always
    | WayOn
    | WayRound
    | Ahead
    | Bearing
    | Proximity
    | CaptureHead
    | Barrier
    | LowBattery
    | Commanded
    | ToTurn
    | ToHeading
    | ToAdvance
    | ToGo
    | Course
    | Distance
    | Astern
    | Alongside
    | Whim
    | JointWayOn
    | JointWayRound
    | Askew
    | PutAhead
    | PutAside,
    Field(discriminator="sense"),
]
