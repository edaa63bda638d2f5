"""Conditions on what the robot faces, and on what stands at its side."""

from cmath import phase
from collections.abc import Iterator
from dataclasses import dataclass
from math import pi, sin
from typing import Annotated, ClassVar, Literal

from pydantic import ConfigDict, Field

from robots.conditions.verdict import Verdict
from robots.perception.percepts import LOCATING, SURROUNDINGS, Needs, Percepts
from robots.physical.body import RADIUS_M
from robots.reactive.responses import STRICT

BEAM_RAD = 0.45
"""To this angle off abeam the side is looked at: three beams of sixteen."""
AHEAD_RAD = 0.6
"""From this angle off straight ahead on it is looked for what goes on at the side."""
SIDES = {1: "left", -1: "right"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Facing:
    """Faces something; with `keep_m` above 0 also at that distance."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
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
class Reached:
    """Stands where `stand_off_m` is left to something, or nearer."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
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
class Abeam:
    """Something stands at a side, at `gap_m` from the hull, or not much farther."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
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
class Opening:
    """What was followed at a side at a gap from the hull does not go on: ahead on that side is nothing of it."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
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
