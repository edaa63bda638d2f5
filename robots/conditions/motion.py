"""Conditions on the robot's own motion since the packet's start, by odometry."""

from dataclasses import dataclass
from math import pi
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from robots.conditions.verdict import Verdict
from robots.data import Strict
from robots.perception.percepts import NOTHING, Needs, Percepts
from robots.physical.geometry import wrap


@dataclass(frozen=True, slots=True, kw_only=True)
class Elapsed(Strict):
    """The packet's patterns have acted for some seconds."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["elapsed"] = "elapsed"
    s: Annotated[float, Field(ge=0)]

    def check(self, percepts: Percepts) -> Verdict:
        elapsed_s = percepts.progress.elapsed_s
        return Verdict(elapsed_s >= self.s, f"has acted for {elapsed_s:.1f} s")


@dataclass(frozen=True, slots=True, kw_only=True)
class Travelled(Strict):
    """Has driven a way, ahead or back."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["travelled"] = "travelled"
    m: Annotated[float, Field(ge=0)]

    def check(self, percepts: Percepts) -> Verdict:
        travelled_m = percepts.progress.travelled_m
        return Verdict(travelled_m >= self.m, f"has driven {travelled_m:.2f} m")


@dataclass(frozen=True, slots=True, kw_only=True)
class Advanced(Strict):
    """Is as far ahead of where the packet began, or behind if negative, as wanted."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["advanced"] = "advanced"
    m: float
    within_m: Annotated[float, Field(gt=0)] = 0.02

    def check(self, percepts: Percepts) -> Verdict:
        advanced_m = percepts.progress.advanced_m
        return Verdict(abs(advanced_m - self.m) <= self.within_m, f"has advanced {advanced_m:+.2f} m")


@dataclass(frozen=True, slots=True, kw_only=True)
class Turned(Strict):
    """Has turned by an angle since the packet began; counter-clockwise positive, more than a full turn allowed."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["turned"] = "turned"
    rad: float
    sign: Literal[-1, 1] = 1
    within_rad: Annotated[float, Field(gt=0)] = 0.03

    def check(self, percepts: Percepts) -> Verdict:
        turned_rad = percepts.progress.turned_rad
        holds = abs(turned_rad - self.sign * self.rad) <= self.within_rad
        return Verdict(holds, f"has turned by {turned_rad:+.2f} rad")


@dataclass(frozen=True, slots=True, kw_only=True)
class Heading(Strict):
    """Heads in a direction of the world's frame."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["heading"] = "heading"
    rad: Annotated[float, Field(ge=-2 * pi, le=2 * pi)]
    within_rad: Annotated[float, Field(gt=0)] = 0.04

    def check(self, percepts: Percepts) -> Verdict:
        off_rad = wrap(self.rad - percepts.pose.heading_rad)
        return Verdict(abs(off_rad) <= self.within_rad, f"is {off_rad:+.2f} rad off its heading")


@dataclass(frozen=True, slots=True, kw_only=True)
class AtRest(Strict):
    """Neither drives nor turns."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["at_rest"] = "at_rest"
    m_s: Annotated[float, Field(gt=0)] = 0.02
    rad_s: Annotated[float, Field(gt=0)] = 0.05

    def check(self, percepts: Percepts) -> Verdict:
        now = percepts.progress
        holds = abs(now.speed_m_s) <= self.m_s and abs(now.turn_rad_s) <= self.rad_s
        return Verdict(holds, f"drives at {now.speed_m_s:+.2f} m/s, turns at {now.turn_rad_s:+.2f} rad/s")


@dataclass(frozen=True, slots=True, kw_only=True)
class Faster(Strict):
    """Drives faster than allowed, ahead or back."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["faster"] = "faster"
    m_s: Annotated[float, Field(gt=0)]

    def check(self, percepts: Percepts) -> Verdict:
        speed_m_s = percepts.progress.speed_m_s
        return Verdict(abs(speed_m_s) > self.m_s, f"drives at {speed_m_s:+.2f} m/s")


@dataclass(frozen=True, slots=True, kw_only=True)
class Raised(Strict):
    """The packet has raised an event."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["raised"] = "raised"
    event: str

    def check(self, percepts: Percepts) -> Verdict:
        raised = percepts.progress.raised
        said = f"has raised {', '.join(sorted(raised)) or 'no event'}, waits for {self.event}"
        return Verdict(self.event in raised, said)
