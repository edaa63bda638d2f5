"""Conditions on where the robot stands, and what is around it."""

from cmath import phase
from collections.abc import Iterator
from dataclasses import dataclass
from math import pi, sin
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from robots.conditions.verdict import Verdict
from robots.data import Strict
from robots.perception.course import guide
from robots.perception.percepts import LOCATING, SURROUNDINGS, Needs, Percepts
from robots.physical.body import GRIPPER_REACH_M, RADIUS_M


@dataclass(frozen=True, slots=True, kw_only=True)
class Near(Strict):
    """Stands at a place's approach point, facing its beacon."""

    needs: ClassVar[Needs] = LOCATING
    sense: Literal["near"] = "near"
    place: str
    within_m: float = 0.12
    facing_rad: float = 0.16

    def check(self, percepts: Percepts) -> Verdict:
        point = percepts.approach_point(self.place)
        beacon = percepts.locate(self.place)
        if point is None or beacon is None:
            return Verdict(False, f"does not know where {self.place} is")
        holds = abs(point) <= self.within_m and abs(phase(beacon)) <= self.facing_rad
        words = f"is {abs(point):.2f} m off the approach point of {self.place}"
        return Verdict(holds, f"{words}, the beacon at {phase(beacon):+.2f} rad")


@dataclass(frozen=True, slots=True, kw_only=True)
class Closer(Strict):
    """Is less than `m` metres from something, and faces it within `facing_rad`."""

    needs: ClassVar[Needs] = LOCATING
    sense: Literal["closer"] = "closer"
    target: str
    m: float
    facing_rad: float = 3.2

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.target)
        if at is None:
            return Verdict(False, f"does not perceive {self.target}")
        holds = abs(at) < self.m and abs(phase(at)) <= self.facing_rad
        return Verdict(holds, f"is {abs(at):.2f} m from {self.target}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Cramped(Strict):
    """Something other than a robot is so close ahead that the jaws would meet it in a turn."""

    needs: ClassVar[Needs] = SURROUNDINGS
    sense: Literal["cramped"] = "cramped"
    gap_m: float = 0.3
    sector_rad: float = 0.9

    def check(self, percepts: Percepts) -> Verdict:
        ahead = [
            one for one in percepts.obstacles if not one.is_robot and abs(phase(one.at)) <= self.sector_rad
        ]
        gap_m = min((one.gap_m for one in ahead), default=float("inf"))
        return Verdict(gap_m < self.gap_m, f"has {gap_m:.2f} m free ahead")


@dataclass(frozen=True, slots=True, kw_only=True)
class OffPoint(Strict):
    """Is at least `m` metres from a place's approach point."""

    needs: ClassVar[Needs] = LOCATING
    sense: Literal["off_point"] = "off_point"
    place: str
    m: float

    def check(self, percepts: Percepts) -> Verdict:
        point = percepts.approach_point(self.place)
        if point is None:
            return Verdict(False, f"does not know where {self.place} is")
        return Verdict(abs(point) >= self.m, f"is {abs(point):.2f} m off the approach point of {self.place}")


@dataclass(frozen=True, slots=True, kw_only=True)
class OnCourse(Strict):
    """Heads, within `rad`, in the direction that leads to stand near a place."""

    needs: ClassVar[Needs] = SURROUNDINGS
    sense: Literal["on_course"] = "on_course"
    place: str
    rad: float

    def check(self, percepts: Percepts) -> Verdict:
        guidance = guide(percepts, self.place)
        if guidance is None:
            return Verdict(False, f"sees no free way to {self.place}")
        return Verdict(abs(guidance.turn_rad) <= self.rad, f"is {guidance.turn_rad:+.2f} rad off its way")


@dataclass(frozen=True, slots=True, kw_only=True)
class JawsAt(Strict):
    """The jaws' middle is over a place's floor point."""

    needs: ClassVar[Needs] = LOCATING
    sense: Literal["jaws_at"] = "jaws_at"
    place: str
    within_m: float = 0.03

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.place)
        off_m = abs(at - GRIPPER_REACH_M) if at is not None else float("inf")
        return Verdict(off_m <= self.within_m, f"has its jaws {off_m:.2f} m from {self.place}")


BEAM_RAD = 0.45
"""To this angle off abeam the side is looked at: three beams of sixteen."""
AHEAD_RAD = 0.6
"""From this angle off straight ahead on it is looked for what goes on at the side."""
SIDES = {1: "left", -1: "right"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Facing(Strict):
    """Faces something; with `keep_m` above 0 also at that distance."""

    needs: ClassVar[Needs] = LOCATING
    sense: Literal["facing"] = "facing"
    target: str
    within_rad: Annotated[float, Field(gt=0)] = 0.06
    keep_m: Annotated[float, Field(ge=0)] = 0.0
    within_m: Annotated[float, Field(gt=0)] = 0.15

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.target)
        if at is None:
            return Verdict(False, f"does not perceive {self.target}")
        holds = abs(phase(at)) <= self.within_rad
        if self.keep_m:
            holds = holds and abs(abs(at) - self.keep_m) <= self.within_m
        return Verdict(holds, f"has {self.target} at {phase(at):+.2f} rad, {abs(at):.2f} m")


@dataclass(frozen=True, slots=True, kw_only=True)
class Reached(Strict):
    """Stands where `stand_off_m` is left to something, or nearer."""

    needs: ClassVar[Needs] = LOCATING
    sense: Literal["reached"] = "reached"
    target: str
    stand_off_m: Annotated[float, Field(ge=0)]
    within_m: Annotated[float, Field(gt=0)]

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.target)
        if at is None:
            return Verdict(False, f"does not perceive {self.target}")
        holds = abs(at) <= self.stand_off_m + self.within_m
        return Verdict(holds, f"is {abs(at):.2f} m from {self.target}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Abeam(Strict):
    """Something stands at a side, at `gap_m` from the hull, or not much farther."""

    needs: ClassVar[Needs] = SURROUNDINGS
    sense: Literal["abeam"] = "abeam"
    side: Literal[-1, 1]
    gap_m: Annotated[float, Field(gt=0)]
    slack_m: Annotated[float, Field(ge=0)] = 0.15

    def check(self, percepts: Percepts) -> Verdict:
        gaps = [
            abs(at) - RADIUS_M for at, off in _at_side(percepts, self.side) if abs(off - pi / 2) <= BEAM_RAD
        ]
        gap_m = min(gaps, default=float("inf"))
        return Verdict(
            gap_m <= self.gap_m + self.slack_m, f"has {gap_m:.2f} m free to its {SIDES[self.side]}"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Opening(Strict):
    """What was followed at a side at a gap from the hull does not go on: ahead on that side is nothing of it."""

    needs: ClassVar[Needs] = SURROUNDINGS
    sense: Literal["opening"] = "opening"
    side: Literal[-1, 1]
    gap_m: Annotated[float, Field(gt=0)]
    beyond_m: Annotated[float, Field(gt=0)] = 0.25

    def check(self, percepts: Percepts) -> Verdict:
        goes_on = any(
            abs(at) <= (self.gap_m + RADIUS_M) / sin(off) + self.beyond_m
            for at, off in _at_side(percepts, self.side)
            if AHEAD_RAD <= off <= pi / 2 - BEAM_RAD / 2
        )
        how = "goes on" if goes_on else "opens"
        return Verdict(not goes_on, f"perceives that what it follows {how} to its {SIDES[self.side]}")


def _at_side(percepts: Percepts, side: int) -> Iterator[tuple[complex, float]]:
    """What stands about, with how far it is off straight ahead towards that side, radians."""
    for one in percepts.obstacles:
        yield one.at, side * phase(one.at)
