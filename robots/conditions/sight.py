"""Conditions on samples and other robots in view."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from robots.conditions.verdict import Verdict
from robots.data import Strict
from robots.perception.percepts import LOCATING, SIGHT, Needs, Percepts
from robots.physical.body import GRIPPER_REACH_M

LIES_AT_M = 0.3
"""A tag this close to a beacon's floor point lies at that location."""
FOREIGN_M = 0.35
"""A tag this close to a beacon makes the location not vacant."""
CLEAR_M = 0.6
"""A robot this close to an approach point occupies it."""
SHARED_M = 0.5
"""A robot this close to what is in another's jaws may hold it as well."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LiesAt(Strict):
    """Sees an object's tag at a location, lying still. `left`: and no robot stands by it any longer.

    Our choice: a sample that is carried up to a location shows its tag there before it is let go.
    """

    needs: ClassVar[Needs] = LOCATING
    sense: Literal["lies_at"] = "lies_at"
    object: str
    place: str
    still_s: float = 0.5
    left: bool = True

    def check(self, percepts: Percepts) -> Verdict:
        if not percepts.sees(self.object):
            unseen = not percepts.sees(self.place)
            return Verdict(False, f"does not see {self.object}{_seen(percepts)}", unseen)
        tag = percepts.locate(self.object)
        place = percepts.locate(self.place)
        if tag is None or place is None:
            return Verdict(False, f"does not know where {self.place} is")
        off_m = abs(tag - place)
        words = f"sees {self.object} {off_m:.2f} m from {self.place}"
        if off_m > LIES_AT_M or percepts.still_for_s(self.object) < self.still_s:
            return Verdict(False, words)
        by = [name for name, at in percepts.robots_in_view() if self.left and abs(at - tag) < CLEAR_M]
        return Verdict(not by, f"{words}, {' and '.join(by)} still by it" if by else words)


@dataclass(frozen=True, slots=True, kw_only=True)
class Vacant(Strict):
    """Sees a location's beacon and no foreign tag at it."""

    needs: ClassVar[Needs] = LOCATING
    sense: Literal["vacant"] = "vacant"
    place: str

    def check(self, percepts: Percepts) -> Verdict:
        place = percepts.locate(self.place)
        if place is None or not percepts.sees(self.place):
            return Verdict(False, f"does not see the beacon of {self.place}", unseen=True)
        there = [tag for tag in percepts.tags if abs((percepts.locate(tag) or 0j) - place) < FOREIGN_M]
        return Verdict(not there, f"sees {' and '.join(there) or 'no sample'} at {self.place}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Clear(Strict):
    """No other robot is seen at a location's approach point on my side."""

    needs: ClassVar[Needs] = LOCATING
    sense: Literal["clear"] = "clear"
    place: str

    def check(self, percepts: Percepts) -> Verdict:
        point = percepts.approach_point(self.place)
        if point is None:
            return Verdict(False, f"does not know where {self.place} is")
        there = [name for name, at in percepts.robots_in_view() if abs(at - point) < CLEAR_M]
        return Verdict(not there, f"sees {' and '.join(there) or 'no robot'} at {self.place}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Beside(Strict):
    """Sees something within `m` metres of another thing: a robot by a location, an object by a robot."""

    needs: ClassVar[Needs] = LOCATING
    sense: Literal["beside"] = "beside"
    target: str
    other: str
    m: float

    def check(self, percepts: Percepts) -> Verdict:
        target = percepts.locate(self.target)
        other = percepts.locate(self.other)
        if (
            target is None
            or other is None
            or not (percepts.sees(self.target) or self.target == percepts.holding)
        ):
            return Verdict(False, f"does not see {self.target} by {self.other}")
        return Verdict(
            abs(target - other) <= self.m, f"sees {self.target} {abs(target - other):.2f} m off {self.other}"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class InView(Strict):
    """Has had something in view without a break for some seconds."""

    needs: ClassVar[Needs] = SIGHT
    sense: Literal["in_view"] = "in_view"
    target: str
    for_s: float = 0.0

    def check(self, percepts: Percepts) -> Verdict:
        held_s = percepts.in_view_for_s(self.target)
        holds = percepts.sees(self.target) and held_s >= self.for_s
        return Verdict(holds, f"has had {self.target} in view for {held_s:.1f} s")


@dataclass(frozen=True, slots=True, kw_only=True)
class SoleHolder(Strict):
    """Holds nothing, or something that it may drive off with: for one robot, with no other by it as far as it sees."""

    needs: ClassVar[Needs] = LOCATING
    sense: Literal["sole_holder"] = "sole_holder"

    def check(self, percepts: Percepts) -> Verdict:
        held = percepts.holding
        if held is None:
            return Verdict(True, "holds nothing")
        if held in percepts.profile.lengths_m:
            return Verdict(False, f"holds {held}, which takes two robots")
        by = [name for name, at in percepts.robots_in_view() if abs(at - GRIPPER_REACH_M) <= SHARED_M]
        return Verdict(not by, f"holds {held}, with {' and '.join(by) or 'no robot'} by it")


def _seen(percepts: Percepts) -> str:
    return f" (sees {', '.join(sorted(percepts.tags))})" if percepts.tags else " (sees no sample)"
