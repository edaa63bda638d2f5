"""Sensor conditions: what initiates, sustains and ends a behaviour packet (MACTA §3).

Each is a question to the percepts and answers with a verdict that says in words what was perceived.
"""

from cmath import phase
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal, Protocol

from pydantic import ConfigDict, Field

from robots.body import GRIPPER_REACH_M
from robots.course import guide
from robots.percepts import Percepts
from robots.responses import STRICT

LIES_AT_M = 0.3
"""A tag this close to a beacon's floor point lies at that location."""
FOREIGN_M = 0.35
"""A tag this close to a beacon makes the location not vacant."""
CLEAR_M = 0.6
"""A robot this close to an approach point occupies it."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether a condition holds, and what was perceived, in words."""

    holds: bool
    words: str


class Condition(Protocol):
    """A question to the senses."""

    def check(self, percepts: Percepts) -> Verdict: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Near:
    """Stands at a place's approach point, facing its beacon."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["near"] = "near"
    place: str
    within_m: float = 0.12
    facing_rad: float = 0.16

    def check(self, percepts: Percepts) -> Verdict:
        point, beacon = percepts.approach_point(self.place), percepts.locate(self.place)
        if point is None or beacon is None:
            return Verdict(False, f"does not know where {self.place} is")
        holds = abs(point) <= self.within_m and abs(phase(beacon)) <= self.facing_rad
        words = f"is {abs(point):.2f} m off the approach point of {self.place}"
        return Verdict(holds, f"{words}, the beacon at {phase(beacon):+.2f} rad")


@dataclass(frozen=True, slots=True, kw_only=True)
class Closer:
    """Is less than `m` metres from something, and faces it within `facing_rad`."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["closer"] = "closer"
    target: str
    m: float
    facing_rad: float = 3.2

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.target)
        if at is None:
            return Verdict(False, f"does not perceive {self.target}")
        holds = abs(at) < self.m and abs(phase(at)) <= self.facing_rad
        return Verdict(holds, f"is {abs(at):.2f} m from {self.target}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Cramped:
    """Something other than a robot is so close ahead that the jaws would meet it in a turn."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["cramped"] = "cramped"
    gap_m: float = 0.3
    sector_rad: float = 0.9

    def check(self, percepts: Percepts) -> Verdict:
        ahead = [
            one for one in percepts.obstacles if not one.is_robot and abs(phase(one.at)) <= self.sector_rad
        ]
        gap_m = min((one.gap_m for one in ahead), default=float("inf"))
        return Verdict(gap_m < self.gap_m, f"has {gap_m:.2f} m free ahead")


@dataclass(frozen=True, slots=True, kw_only=True)
class OffPoint:
    """Is at least `m` metres from a place's approach point."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["off_point"] = "off_point"
    place: str
    m: float

    def check(self, percepts: Percepts) -> Verdict:
        point = percepts.approach_point(self.place)
        if point is None:
            return Verdict(False, f"does not know where {self.place} is")
        return Verdict(abs(point) >= self.m, f"is {abs(point):.2f} m off the approach point of {self.place}")


@dataclass(frozen=True, slots=True, kw_only=True)
class OnCourse:
    """Heads, within `rad`, in the direction that leads to stand near a place."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["on_course"] = "on_course"
    place: str
    rad: float

    def check(self, percepts: Percepts) -> Verdict:
        guidance = guide(percepts, self.place)
        if guidance is None:
            return Verdict(False, f"sees no free way to {self.place}")
        return Verdict(abs(guidance.turn_rad) <= self.rad, f"is {guidance.turn_rad:+.2f} rad off its way")


@dataclass(frozen=True, slots=True, kw_only=True)
class BetweenJaws:
    """The jaws' light barrier meets an object."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["between_jaws"] = "between_jaws"
    object: str

    def check(self, percepts: Percepts) -> Verdict:
        there = percepts.readings.gripper.between_jaws
        return Verdict(there == self.object, f"has {there or 'nothing'} between its jaws")


@dataclass(frozen=True, slots=True, kw_only=True)
class JawsAt:
    """The jaws' middle is over a place's floor point."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["jaws_at"] = "jaws_at"
    place: str
    within_m: float = 0.03

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.place)
        off_m = abs(at - GRIPPER_REACH_M) if at is not None else float("inf")
        return Verdict(off_m <= self.within_m, f"has its jaws {off_m:.2f} m from {self.place}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Holding:
    """Holds an object."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["holding"] = "holding"
    object: str

    def check(self, percepts: Percepts) -> Verdict:
        return Verdict(percepts.holding == self.object, f"holds {percepts.holding or 'nothing'}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Empty:
    """The gripper holds nothing. `open`: and its jaws are open."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["empty"] = "empty"
    open: bool = False

    def check(self, percepts: Percepts) -> Verdict:
        jaws = "closed" if percepts.readings.gripper.closed else "open"
        holds = percepts.holding is None and not (self.open and jaws == "closed")
        return Verdict(holds, f"holds {percepts.holding or 'nothing'}, jaws {jaws}")


@dataclass(frozen=True, slots=True, kw_only=True)
class LiesAt:
    """Sees an object's tag at a location, lying still. `left`: and no robot stands by it any more.

    Our choice: a sample that is carried up to a location shows its tag there before it is let go.
    """

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["lies_at"] = "lies_at"
    object: str
    place: str
    still_s: float = 0.5
    left: bool = True

    def check(self, percepts: Percepts) -> Verdict:
        if not percepts.sees(self.object):
            return Verdict(False, f"does not see {self.object}{_seen(percepts)}")
        tag, place = percepts.locate(self.object), percepts.locate(self.place)
        if tag is None or place is None:
            return Verdict(False, f"does not know where {self.place} is")
        off_m = abs(tag - place)
        words = f"sees {self.object} {off_m:.2f} m from {self.place}"
        if off_m > LIES_AT_M or percepts.still_for_s(self.object) < self.still_s:
            return Verdict(False, words)
        by = [name for name, at in percepts.robots_in_view() if self.left and abs(at - tag) < CLEAR_M]
        return Verdict(not by, f"{words}, {' and '.join(by)} still by it" if by else words)


@dataclass(frozen=True, slots=True, kw_only=True)
class Vacant:
    """Sees a location's beacon and no foreign tag at it."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["vacant"] = "vacant"
    place: str

    def check(self, percepts: Percepts) -> Verdict:
        place = percepts.locate(self.place)
        if place is None or not percepts.sees(self.place):
            return Verdict(False, f"does not see the beacon of {self.place}")
        there = [tag for tag in percepts.tags if abs((percepts.locate(tag) or 0j) - place) < FOREIGN_M]
        return Verdict(not there, f"sees {' and '.join(there) or 'no sample'} at {self.place}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Clear:
    """No other robot is seen at a location's approach point on my side."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["clear"] = "clear"
    place: str

    def check(self, percepts: Percepts) -> Verdict:
        point = percepts.approach_point(self.place)
        if point is None:
            return Verdict(False, f"does not know where {self.place} is")
        there = [name for name, at in percepts.robots_in_view() if abs(at - point) < CLEAR_M]
        return Verdict(not there, f"sees {' and '.join(there) or 'no robot'} at {self.place}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Beside:
    """Sees something within `m` metres of another thing: a robot by a location, an object by a robot."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["beside"] = "beside"
    target: str
    other: str
    m: float

    def check(self, percepts: Percepts) -> Verdict:
        target, other = percepts.locate(self.target), percepts.locate(self.other)
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
class InView:
    """Has had something in view without a break for some seconds."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["in_view"] = "in_view"
    target: str
    for_s: float = 0.0

    def check(self, percepts: Percepts) -> Verdict:
        held_s = percepts.in_view_for_s(self.target)
        holds = percepts.sees(self.target) and held_s >= self.for_s
        return Verdict(holds, f"has had {self.target} in view for {held_s:.1f} s")


@dataclass(frozen=True, slots=True, kw_only=True)
class Not:
    """The contrary."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["not"] = "not"
    of: "AnyCondition"

    def check(self, percepts: Percepts) -> Verdict:
        verdict = self.of.check(percepts)
        return Verdict(not verdict.holds, verdict.words)


@dataclass(frozen=True, slots=True, kw_only=True)
class AnyOf:
    """At least one of several."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["any"] = "any"
    of: "tuple[AnyCondition, ...]"

    def check(self, percepts: Percepts) -> Verdict:
        verdicts = [one.check(percepts) for one in self.of]
        return Verdict(any(one.holds for one in verdicts), "; ".join(one.words for one in verdicts))


@dataclass(frozen=True, slots=True, kw_only=True)
class AllOf:
    """Every one of several."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    sense: Literal["all"] = "all"
    of: "tuple[AnyCondition, ...]"

    def check(self, percepts: Percepts) -> Verdict:
        verdicts = [one.check(percepts) for one in self.of]
        return Verdict(all(one.holds for one in verdicts), "; ".join(one.words for one in verdicts))


AnyCondition = Annotated[
    Near
    | Closer
    | Cramped
    | OffPoint
    | OnCourse
    | BetweenJaws
    | JawsAt
    | Holding
    | Empty
    | LiesAt
    | Vacant
    | Clear
    | Beside
    | InView
    | Not
    | AnyOf
    | AllOf,
    Field(discriminator="sense"),
]


def unmet(conditions: Iterable[Condition], percepts: Percepts) -> list[str]:
    """What was perceived instead, for every condition that does not hold."""
    verdicts = [condition.check(percepts) for condition in conditions]
    return [verdict.words for verdict in verdicts if not verdict.holds]


def _seen(percepts: Percepts) -> str:
    return f" (sees {', '.join(sorted(percepts.tags))})" if percepts.tags else " (sees no sample)"
