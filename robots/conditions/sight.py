"""Conditions on samples and other robots in view."""

from robots.conditions.verdict import Condition, Verdict
from robots.perception.percepts import LOCATING, SIGHT, Percepts
from robots.physical.body import GRIPPER_REACH_M

LIES_AT_M = 0.3
"""A tag this close to a beacon's floor point lies at that location."""
FOREIGN_M = 0.35
"""A tag this close to a beacon makes the location not vacant."""
CLEAR_M = 0.6
"""A robot this close to an approach point occupies it."""
SHARED_M = 0.5
"""A robot this close to what is in another's jaws may hold it as well."""


class LiesAt(Condition, needs=LOCATING):
    """Sees an object's tag lie still at a location; with `left` no robot may be near it.

    Our choice: the tag of a sample is at the location before the robot that brings it has released it.
    """

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


class Vacant(Condition, needs=LOCATING):
    """Sees a location's beacon and no foreign tag at it."""

    place: str

    def check(self, percepts: Percepts) -> Verdict:
        place = percepts.locate(self.place)
        if place is None or not percepts.sees(self.place):
            return Verdict(False, f"does not see the beacon of {self.place}", unseen=True)
        there = [tag for tag in percepts.tags if abs((percepts.locate(tag) or 0j) - place) < FOREIGN_M]
        return Verdict(not there, f"sees {' and '.join(there) or 'no sample'} at {self.place}")


class Clear(Condition, needs=LOCATING):
    """No other robot is seen at a location's approach point on this robot's side."""

    place: str

    def check(self, percepts: Percepts) -> Verdict:
        point = percepts.approach_point(self.place)
        if point is None:
            return Verdict(False, f"does not know where {self.place} is")
        there = [name for name, at in percepts.robots_in_view() if abs(at - point) < CLEAR_M]
        return Verdict(not there, f"sees {' and '.join(there) or 'no robot'} at {self.place}")


class Beside(Condition, needs=LOCATING):
    """Sees something within `m` metres of another thing: a robot by a location, an object by a robot."""

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


class InView(Condition, needs=SIGHT):
    """The target has been in view for `for_s` without a break."""

    target: str
    for_s: float = 0.0

    def check(self, percepts: Percepts) -> Verdict:
        held_s = percepts.in_view_for_s(self.target)
        holds = percepts.sees(self.target) and held_s >= self.for_s
        return Verdict(holds, f"has had {self.target} in view for {held_s:.1f} s")


class SoleHolder(Condition, needs=LOCATING):
    """Holds nothing, or a compact object with no other robot near it: the robot may drive off with it."""

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
