"""Conditions on the robot's own motion since the packet's start, by odometry."""

from math import pi
from typing import Annotated, Literal

from pydantic import Field

from robots.conditions.verdict import Condition, Verdict
from robots.perception.percepts import Percepts
from robots.physical.geometry import wrap


class Elapsed(Condition):
    """The packet's patterns have been active for `s` seconds."""

    s: Annotated[float, Field(ge=0)]

    def check(self, percepts: Percepts) -> Verdict:
        elapsed_s = percepts.progress.elapsed_s
        return Verdict(elapsed_s >= self.s, f"has acted for {elapsed_s:.1f} s")


class Travelled(Condition):
    """The distance driven, ahead and back, has reached `m` metres."""

    m: Annotated[float, Field(ge=0)]

    def check(self, percepts: Percepts) -> Verdict:
        travelled_m = percepts.progress.travelled_m
        return Verdict(travelled_m >= self.m, f"has driven {travelled_m:.2f} m")


class Advanced(Condition):
    """The displacement along the heading since the packet's start is `m` metres; negative: backwards."""

    m: float
    within_m: Annotated[float, Field(gt=0)] = 0.02

    def check(self, percepts: Percepts) -> Verdict:
        advanced_m = percepts.progress.advanced_m
        return Verdict(abs(advanced_m - self.m) <= self.within_m, f"has advanced {advanced_m:+.2f} m")


class Turned(Condition):
    """The angle turned since the packet's start is `sign * rad`; counter-clockwise positive, not wrapped."""

    rad: float
    sign: Literal[-1, 1] = 1
    within_rad: Annotated[float, Field(gt=0)] = 0.03

    def check(self, percepts: Percepts) -> Verdict:
        turned_rad = percepts.progress.turned_rad
        holds = abs(turned_rad - self.sign * self.rad) <= self.within_rad
        return Verdict(holds, f"has turned by {turned_rad:+.2f} rad")


class Heading(Condition):
    """The heading in the world's frame is `rad`."""

    rad: Annotated[float, Field(ge=-2 * pi, le=2 * pi)]
    within_rad: Annotated[float, Field(gt=0)] = 0.04

    def check(self, percepts: Percepts) -> Verdict:
        off_rad = wrap(self.rad - percepts.pose.heading_rad)
        return Verdict(abs(off_rad) <= self.within_rad, f"is {off_rad:+.2f} rad off its heading")


class AtRest(Condition):
    """Speed and turn rate are zero within a tolerance."""

    m_s: Annotated[float, Field(gt=0)] = 0.02
    rad_s: Annotated[float, Field(gt=0)] = 0.05

    def check(self, percepts: Percepts) -> Verdict:
        now = percepts.progress
        holds = abs(now.speed_m_s) <= self.m_s and abs(now.turn_rad_s) <= self.rad_s
        return Verdict(holds, f"drives at {now.speed_m_s:+.2f} m/s, turns at {now.turn_rad_s:+.2f} rad/s")


class Faster(Condition):
    """The speed, ahead or back, exceeds `m_s`."""

    m_s: Annotated[float, Field(gt=0)]

    def check(self, percepts: Percepts) -> Verdict:
        speed_m_s = percepts.progress.speed_m_s
        return Verdict(abs(speed_m_s) > self.m_s, f"drives at {speed_m_s:+.2f} m/s")


class Raised(Condition):
    """The packet has raised an event."""

    event: str

    def check(self, percepts: Percepts) -> Verdict:
        raised = percepts.progress.raised
        said = f"has raised {', '.join(sorted(raised)) or 'no event'}, waits for {self.event}"
        return Verdict(self.event in raised, said)
