"""Stimuli of the behavioural suite (SRA fig. 4): remaining turn or distance, an obstacle at the side, wandering."""

from cmath import phase
from math import cos, pi, sin
from typing import Annotated, Literal
from zlib import crc32

from pydantic import Field

from robots.perception.course import clear_course
from robots.perception.percepts import LOCATING, SURROUNDINGS, Percepts
from robots.physical.body import RADIUS_M
from robots.physical.geometry import clip, wrap
from robots.reactive.stimuli import Stimulus

ALONG_M = 1.2
"""A farther obstacle is not followed."""


class ToTurn(Stimulus):
    """The rest of an angle to turn by since the packet's start; 1 at `full_rad` to the left."""

    rad: float
    sign: Literal[-1, 1] = 1
    full_rad: Annotated[float, Field(gt=0, le=pi)] = 0.6

    def read(self, percepts: Percepts) -> float | None:
        return clip((self.sign * self.rad - percepts.progress.turned_rad) / self.full_rad)


class ToHeading(Stimulus):
    """How far a direction of the world's frame is off the heading; 1 at `full_rad` to the left."""

    rad: Annotated[float, Field(ge=-2 * pi, le=2 * pi)]
    full_rad: Annotated[float, Field(gt=0, le=pi)] = 0.6

    def read(self, percepts: Percepts) -> float | None:
        return clip(wrap(self.rad - percepts.pose.heading_rad) / self.full_rad)


class ToAdvance(Stimulus):
    """The rest of a distance to advance, negative: back, since the packet's start; 1 at `full_m`."""

    m: float
    full_m: Annotated[float, Field(gt=0, le=2)] = 0.3

    def read(self, percepts: Percepts) -> float | None:
        return clip((self.m - percepts.progress.advanced_m) / self.full_m)


class ToGo(Stimulus, needs=LOCATING):
    """The distance to something less `short_of_m`, whatever its direction; 1 at `full_m`."""

    target: str
    short_of_m: Annotated[float, Field(ge=0, le=5)] = 0.0
    full_m: Annotated[float, Field(gt=0, le=5)] = 0.4

    def read(self, percepts: Percepts) -> float | None:
        at = percepts.locate(self.target)
        return None if at is None else clip((abs(at) - self.short_of_m) / self.full_m, 0.0)


class Course(Stimulus, needs=SURROUNDINGS):
    """The free direction nearest to that of something; 1 at `full_rad` to the left, 0 if every way is blocked."""

    target: str
    full_rad: Annotated[float, Field(gt=0, le=pi)] = 0.8

    def read(self, percepts: Percepts) -> float | None:
        at = percepts.locate(self.target)
        if at is None:
            return None
        course = clear_course(at, percepts.obstacles)
        return 0.0 if course is None else clip(course / self.full_rad)


class Distance(Stimulus, needs=LOCATING):
    """How much farther than `keep_m` something is, negative: nearer; 1 at `full_m`. None if no distance is to be kept.

    Off to the side it shrinks with the square of the bearing's cosine, so that the robot turns first.
    """

    target: str
    keep_m: Annotated[float, Field(ge=0, le=5)]
    full_m: Annotated[float, Field(gt=0, le=5)] = 0.5

    def read(self, percepts: Percepts) -> float | None:
        at = percepts.locate(self.target)
        if at is None or self.keep_m == 0:
            return None
        return clip((abs(at) - self.keep_m) / self.full_m) * max(0.0, cos(phase(at))) ** 2


class Astern(Stimulus, needs=SURROUNDINGS):
    """The nearest thing within a sector behind; 0 at `reach_m` from the hull, 1 at touch."""

    reach_m: Annotated[float, Field(gt=0, le=2)] = 0.3
    sector_rad: Annotated[float, Field(gt=0, le=pi)] = 0.7

    def read(self, percepts: Percepts) -> float | None:
        gaps = [one.gap_m for one in percepts.obstacles if abs(phase(-one.at)) <= self.sector_rad]
        return clip(1 - min(gaps, default=self.reach_m) / self.reach_m, 0.0)


class RetrySide(Stimulus):
    """To which side a retry turns: -1, to the right, first, as robots that meet pass; then the other side in turn."""

    def read(self, percepts: Percepts) -> float | None:
        return -1.0 if percepts.progress.retries % 2 else 1.0


class Alongside(Stimulus, needs=SURROUNDINGS):
    """How to turn to keep an obstacle at the side, at a gap from the hull; 1 is a quarter turn to the left.

    The nearest point within reach on that side should be abeam and at the gap. Our choices: the weight `rad_per_m` of
    the gap's error; without an obstacle the robot drives straight until the event `found`, then to that side.
    """

    side: Literal[-1, 1]
    gap_m: Annotated[float, Field(ge=0.1, le=1)]
    rad_per_m: Annotated[float, Field(gt=0, le=10)] = 2.5
    found: str

    def read(self, percepts: Percepts) -> float | None:
        nearest = abeam(percepts, self.side)
        if nearest is None:
            return self.side * 0.5 if self.found in percepts.progress.raised else 0.0
        off_m = clip(abs(nearest) - RADIUS_M - self.gap_m, -0.3, 0.3)
        turn = self.side * (phase(nearest) * self.side - pi / 2 + self.rad_per_m * off_m)
        return clip(turn / (pi / 2))


class Whim(Stimulus):
    """A smoothly changing direction for wandering, different for every robot, the same in every run.

    Our choice: two sines of the packet's time with incommensurable periods, their phases by the robot's name.
    """

    period_s: Annotated[float, Field(ge=1, le=120)] = 9.0

    def read(self, percepts: Percepts) -> float | None:
        at = 2 * pi * percepts.progress.elapsed_s / self.period_s
        start = crc32(percepts.me.encode())
        return 0.6 * sin(at + start % 628 / 100) + 0.4 * sin(at / 1.618 + start % 997 / 100)


def abeam(percepts: Percepts, side: int) -> complex | None:
    """The nearest obstacle at a side, from a little ahead to astern; robot's frame."""
    found = [
        one.at
        for one in percepts.obstacles
        if 0.3 <= side * phase(one.at) <= 2.8 and abs(one.at) - RADIUS_M <= ALONG_M
    ]
    return min(found, key=abs, default=None)
