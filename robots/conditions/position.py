"""Conditions on the robot's position and its surroundings."""

from cmath import phase
from collections.abc import Iterator
from math import pi, sin
from typing import Annotated, Literal

from pydantic import Field

from robots.conditions.verdict import Condition, Verdict
from robots.perception.course import guide
from robots.perception.percepts import LOCATING, SURROUNDINGS, Percepts
from robots.physical.body import GRIPPER_REACH_M, RADIUS_M


class Near(Condition, needs=LOCATING):
    """Stands at a place's approach point, facing its beacon."""

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


class Closer(Condition, needs=LOCATING):
    """Is less than `m` metres from something, and faces it within `facing_rad`."""

    target: str
    m: float
    facing_rad: float = 3.2

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.target)
        if at is None:
            return Verdict(False, f"does not perceive {self.target}")
        holds = abs(at) < self.m and abs(phase(at)) <= self.facing_rad
        return Verdict(holds, f"is {abs(at):.2f} m from {self.target}")


class Cramped(Condition, needs=SURROUNDINGS):
    """An obstacle other than a robot is so close ahead that the jaws would hit it in a turn."""

    gap_m: float = 0.3
    sector_rad: float = 0.9

    def check(self, percepts: Percepts) -> Verdict:
        ahead = [
            one for one in percepts.obstacles if not one.is_robot and abs(phase(one.at)) <= self.sector_rad
        ]
        gap_m = min((one.gap_m for one in ahead), default=float("inf"))
        return Verdict(gap_m < self.gap_m, f"has {gap_m:.2f} m free ahead")


class OffPoint(Condition, needs=LOCATING):
    """Is at least `m` metres from a place's approach point."""

    place: str
    m: float

    def check(self, percepts: Percepts) -> Verdict:
        point = percepts.approach_point(self.place)
        if point is None:
            return Verdict(False, f"does not know where {self.place} is")
        return Verdict(abs(point) >= self.m, f"is {abs(point):.2f} m off the approach point of {self.place}")


class OnCourse(Condition, needs=SURROUNDINGS):
    """The heading is within `rad` of the guidance to a place's approach point."""

    place: str
    rad: float

    def check(self, percepts: Percepts) -> Verdict:
        guidance = guide(percepts, self.place)
        if guidance is None:
            return Verdict(False, f"sees no free way to {self.place}")
        return Verdict(abs(guidance.turn_rad) <= self.rad, f"is {guidance.turn_rad:+.2f} rad off its way")


class JawsAt(Condition, needs=LOCATING):
    """The jaws' middle is over a place's floor point."""

    place: str
    within_m: float = 0.03

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.place)
        off_m = abs(at - GRIPPER_REACH_M) if at is not None else float("inf")
        return Verdict(off_m <= self.within_m, f"has its jaws {off_m:.2f} m from {self.place}")


BEAM_RAD = 0.45
"""Half the sector abeam in which obstacles count: three beams of sixteen."""
AHEAD_RAD = 0.6
"""Obstacles beyond this angle off straight ahead can be the continuation of what is followed."""
SIDES = {1: "left", -1: "right"}


class Facing(Condition, needs=LOCATING):
    """Faces the target; with `keep_m` above 0 also at that distance."""

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


class Reached(Condition, needs=LOCATING):
    """The distance to the target is `stand_off_m` or less."""

    target: str
    stand_off_m: Annotated[float, Field(ge=0)]
    within_m: Annotated[float, Field(gt=0)]

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.target)
        if at is None:
            return Verdict(False, f"does not perceive {self.target}")
        holds = abs(at) <= self.stand_off_m + self.within_m
        return Verdict(holds, f"is {abs(at):.2f} m from {self.target}")


class Abeam(Condition, needs=SURROUNDINGS):
    """An obstacle is abeam on that side, within `gap_m` and a tolerance of the hull."""

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


class Opening(Condition, needs=SURROUNDINGS):
    """The obstacle that is followed on a side at `gap_m` has ended: nothing continues it ahead on that side."""

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
    """Every obstacle, with its angle off straight ahead towards that side, radians."""
    for one in percepts.obstacles:
        yield one.at, side * phase(one.at)
