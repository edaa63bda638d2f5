"""Conditions on a long object that two robots carry."""

from cmath import phase, rect
from typing import Annotated

from pydantic import Field

from robots.conditions.verdict import Condition, Verdict
from robots.perception.formation import formation_with, put_down_point
from robots.perception.percepts import LOCATING, SIGHT, STANDS_AT_M, Percepts
from robots.physical.body import GRIPPER_REACH_M
from robots.physical.stand_off import STAND_OFF_M

HANDLES = ("left", "right")


class AtHandle(Condition, needs=LOCATING):
    """Another robot has its jaws at a handle of a long object and has stood still for `still_s`."""

    object: str
    robot: str
    within_m: Annotated[float, Field(gt=0)] = GRIPPER_REACH_M + 0.05
    still_s: Annotated[float, Field(ge=0)] = 1.0

    def check(self, percepts: Percepts) -> Verdict:
        gap_m = to_handle_m(percepts, self.object, self.robot)
        if gap_m is None:
            return Verdict(False, f"does not see {self.robot} and {self.object}", unseen=True)
        words = f"sees {self.robot} {gap_m:.2f} m from a handle of {self.object}"
        if gap_m > self.within_m or percepts.still_for_s(self.robot) >= self.still_s:
            return Verdict(gap_m <= self.within_m, words)
        return Verdict(False, f"{words}, not still yet")


class HoldsAlone(Condition, needs=LOCATING):
    """Holds an object, and no other robot stands at a handle of it."""

    object: str

    def check(self, percepts: Percepts) -> Verdict:
        if percepts.holding != self.object:
            return Verdict(False, f"holds {percepts.holding or 'nothing'}")
        gaps_m = {name: to_handle_m(percepts, self.object, name) for name, _ in percepts.robots_in_view()}
        by = [name for name, gap_m in gaps_m.items() if gap_m is not None and gap_m <= STANDS_AT_M]
        return Verdict(not by, f"sees {' and '.join(by) or 'no robot'} at {self.object}")


class JointNear(Condition, needs=LOCATING):
    """The formation stands at a place's approach point and faces its beacon; its middle counts as its position."""

    object: str
    place: str
    within_m: Annotated[float, Field(gt=0)] = 0.15
    facing_rad: Annotated[float, Field(gt=0)] = 0.16

    def check(self, percepts: Percepts) -> Verdict:
        whole = formation_with(percepts, self.object)
        point = percepts.approach_point(self.place)
        beacon = percepts.locate(self.place)
        if whole is None or point is None or beacon is None:
            return Verdict(False, f"does not perceive {self.place} and {self.object} in its jaws")
        off_m = abs(whole.to_formation(point))
        turn_rad = phase(whole.to_formation(beacon))
        holds = off_m <= self.within_m and abs(turn_rad) <= self.facing_rad
        said = f"has {self.object} {off_m:.2f} m short of {self.place}, the beacon at {turn_rad:+.2f} rad"
        return Verdict(holds, said)


class LinedUp(Condition, needs=LOCATING):
    """Stands in front of a handle in a funnel that narrows towards it: driving straight ahead reaches it."""

    target: str
    from_m: Annotated[float, Field(gt=0)] = STAND_OFF_M + 0.15
    to_m: Annotated[float, Field(gt=0)] = GRIPPER_REACH_M - 0.1
    least_m: Annotated[float, Field(gt=0)] = 0.05
    widening: Annotated[float, Field(ge=0)] = 0.12

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.target)
        axis = percepts.axis(self.target)
        if at is None or axis is None:
            return Verdict(False, f"does not see {self.target}")
        off = -at * rect(1.0, -axis)
        width_m = self.least_m + self.widening * max(0.0, off.real - GRIPPER_REACH_M)
        holds = self.to_m <= off.real <= self.from_m and abs(off.imag) <= width_m
        return Verdict(holds, f"is {off.real:.2f} m before {self.target}, {off.imag:+.2f} m aside")


class Still(Condition, needs=SIGHT):
    """Sees that an object has not moved for `for_s`."""

    object: str
    for_s: Annotated[float, Field(gt=0)] = 1.5

    def check(self, percepts: Percepts) -> Verdict:
        if not percepts.sees(self.object):
            return Verdict(False, f"does not see {self.object}")
        still_s = percepts.still_for_s(self.object)
        return Verdict(still_s >= self.for_s, f"has seen {self.object} lie still for {still_s:.1f} s")


class Over(Condition, needs=LOCATING):
    """The middle of a held object is over a place's floor point."""

    object: str
    place: str
    within_m: Annotated[float, Field(gt=0)] = 0.05

    def check(self, percepts: Percepts) -> Verdict:
        at = put_down_point(percepts, self.object, self.place)
        off_m = abs(at - GRIPPER_REACH_M) if at is not None else float("inf")
        return Verdict(off_m <= self.within_m, f"has {self.object} {off_m:.2f} m from {self.place}")


def to_handle_m(percepts: Percepts, thing: str, robot: str) -> float | None:
    """Distance from another robot to its nearer handle of an object; None if either is not perceived."""
    at = percepts.locate(robot)
    handles = [percepts.locate(f"{thing}@{which}") for which in HANDLES]
    gaps_m = [abs(handle - at) for handle in handles if handle is not None and at is not None]
    return min(gaps_m, default=None)
