"""Qualitative beliefs about things, by their cursors (SRA: BELIEF(close(object)), BELIEF(moving(object)))."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from robots.conditions.verdict import Verdict
from robots.data import Strict
from robots.perception.percepts import SURROUNDINGS, TRACKING, Needs, Percepts
from robots.physical.body import RADIUS_M

BELIEVED = 0.5
"""Evidence from which on a thing is believed to be where its cursor is."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Believed(Strict):
    """There is enough evidence of a thing."""

    needs: ClassVar[Needs] = TRACKING
    sense: Literal["believed"] = "believed"
    object: str
    evidence: Annotated[float, Field(gt=0, le=1)] = BELIEVED

    def check(self, percepts: Percepts) -> Verdict:
        evidence = percepts.evidence(self.object)
        return Verdict(evidence >= self.evidence, f"has evidence {evidence:.2f} of {self.object}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Close(Strict):
    """close(object): a thing that is believed in is no farther than `m`."""

    needs: ClassVar[Needs] = TRACKING
    sense: Literal["close"] = "close"
    object: str
    m: Annotated[float, Field(gt=0, le=10)] = 1.0

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.object)
        evidence = percepts.evidence(self.object)
        if at is None or evidence < BELIEVED:
            return Verdict(False, f"has evidence {evidence:.2f} of {self.object}")
        return Verdict(abs(at) <= self.m, f"is {abs(at):.2f} m from {self.object}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Moving(Strict):
    """moving(object): a thing that is believed in does not stand still."""

    needs: ClassVar[Needs] = TRACKING
    sense: Literal["moving"] = "moving"
    object: str

    def check(self, percepts: Percepts) -> Verdict:
        cursor = percepts.cursors.get(self.object)
        evidence = percepts.evidence(self.object)
        if cursor is None or evidence < BELIEVED:
            return Verdict(False, f"has evidence {evidence:.2f} of {self.object}")
        moving = cursor.moving_at(percepts.time_s)
        return Verdict(moving, f"perceives that {self.object} {'moves' if moving else 'stands still'}")


@dataclass(frozen=True, slots=True, kw_only=True)
class NarrowPassage(Strict):
    """narrow_passage: between what stands to either side, here or just ahead, is little more room than to pass."""

    needs: ClassVar[Needs] = SURROUNDINGS
    sense: Literal["narrow_passage"] = "narrow_passage"
    width_m: Annotated[float, Field(gt=2 * RADIUS_M, le=3)] = 1.1
    ahead_m: Annotated[float, Field(ge=0, le=2)] = 0.5

    def check(self, percepts: Percepts) -> Verdict:
        beside = [
            one
            for one in percepts.obstacles
            if -RADIUS_M <= one.at.real <= self.ahead_m and abs(one.at.imag) > 0.1
        ]
        left, right = (
            min((side * one.at.imag - one.radius_m for one in beside if side * one.at.imag > 0), default=10.0)
            for side in (1, -1)
        )
        return Verdict(left + right <= self.width_m, f"has {left + right:.2f} m between left and right")
