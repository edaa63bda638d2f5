"""Qualitative beliefs about tracked objects (SRA: BELIEF(close(object)), BELIEF(moving(object)))."""

from typing import Annotated

from pydantic import Field

from robots.conditions.verdict import Condition, Verdict
from robots.perception.percepts import SURROUNDINGS, TRACKING, Percepts
from robots.physical.body import RADIUS_M

BELIEVED = 0.5
"""The least evidence with which an object is believed to be where its cursor is."""


class Believed(Condition, needs=TRACKING):
    """There is enough evidence of the object."""

    object: str
    evidence: Annotated[float, Field(gt=0, le=1)] = BELIEVED

    def check(self, percepts: Percepts) -> Verdict:
        evidence = percepts.evidence(self.object)
        return Verdict(evidence >= self.evidence, f"has evidence {evidence:.2f} of {self.object}")


class Close(Condition, needs=TRACKING):
    """close(object): the object is believed to be within `m` metres."""

    object: str
    m: Annotated[float, Field(gt=0, le=10)] = 1.0

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.object)
        evidence = percepts.evidence(self.object)
        if at is None or evidence < BELIEVED:
            return Verdict(False, f"has evidence {evidence:.2f} of {self.object}")
        return Verdict(abs(at) <= self.m, f"is {abs(at):.2f} m from {self.object}")


class Moving(Condition, needs=TRACKING):
    """moving(object): the object is believed to move."""

    object: str

    def check(self, percepts: Percepts) -> Verdict:
        cursor = percepts.cursors.get(self.object)
        evidence = percepts.evidence(self.object)
        if cursor is None or evidence < BELIEVED:
            return Verdict(False, f"has evidence {evidence:.2f} of {self.object}")
        moving = cursor.moving_at(percepts.time_s)
        return Verdict(moving, f"perceives that {self.object} {'moves' if moving else 'stands still'}")


class RollsTo(Condition, needs=TRACKING):
    """The object is believed to move towards a point of the world's frame, at `least_m_s` or faster."""

    object: str
    x_m: float
    y_m: float
    least_m_s: Annotated[float, Field(gt=0, le=10)] = 0.3

    def check(self, percepts: Percepts) -> Verdict:
        cursor = percepts.cursors.get(self.object)
        evidence = percepts.evidence(self.object)
        if cursor is None or evidence < BELIEVED:
            return Verdict(False, f"has evidence {evidence:.2f} of {self.object}")
        way = complex(self.x_m, self.y_m) - cursor.at
        pace_m_s = (cursor.velocity * way.conjugate()).real / (abs(way) or 1.0)
        holds = cursor.moving_at(percepts.time_s) and pace_m_s >= self.least_m_s
        return Verdict(holds, f"perceives that {self.object} moves there at {pace_m_s:.2f} m/s")


class Inside(Condition, needs=TRACKING):
    """The object is believed to be in a rectangle of the world's frame: `x` and `y` intervals in metres."""

    object: str
    x: tuple[float, float]
    y: tuple[float, float]

    def check(self, percepts: Percepts) -> Verdict:
        cursor = percepts.cursors.get(self.object)
        evidence = percepts.evidence(self.object)
        if cursor is None or evidence < BELIEVED:
            return Verdict(False, f"has evidence {evidence:.2f} of {self.object}")
        at = cursor.at
        holds = self.x[0] <= at.real <= self.x[1] and self.y[0] <= at.imag <= self.y[1]
        return Verdict(holds, f"perceives {self.object} at ({at.real:.2f}, {at.imag:.2f})")


class NarrowPassage(Condition, needs=SURROUNDINGS):
    """narrow_passage: the free width between left and right, here or just ahead, is at most `width_m` (SRA fig. 4)."""

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
