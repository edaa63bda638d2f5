"""Conditions made of conditions, and the set of all that data may name."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from robots.conditions.beliefs import Believed, Close, Moving, NarrowPassage
from robots.conditions.long_objects import AtHandle, HoldsAlone, JointNear, LinedUp, Over, Still
from robots.conditions.motion import Advanced, AtRest, Elapsed, Faster, Heading, Raised, Travelled, Turned
from robots.conditions.own_state import (
    BetweenJaws,
    Bumped,
    Charged,
    Charging,
    Commanded,
    Empty,
    Holding,
    NotDriven,
)
from robots.conditions.position import (
    Abeam,
    Closer,
    Cramped,
    Facing,
    JawsAt,
    Near,
    OffPoint,
    OnCourse,
    Opening,
    Reached,
)
from robots.conditions.sight import Beside, Clear, InView, LiesAt, SoleHolder, Vacant
from robots.conditions.verdict import Condition, Verdict
from robots.data import Strict
from robots.perception.percepts import NOTHING, Needs, Percepts


@dataclass(frozen=True, slots=True, kw_only=True)
class Not(Strict):
    """The contrary."""

    sense: Literal["not"] = "not"
    of: "AnyCondition"

    @property
    def needs(self) -> Needs:
        return self.of.needs

    def check(self, percepts: Percepts) -> Verdict:
        verdict = self.of.check(percepts)
        return Verdict(not verdict.holds, verdict.words)


@dataclass(frozen=True, slots=True, kw_only=True)
class AnyOf(Strict):
    """At least one of several."""

    sense: Literal["any"] = "any"
    of: "tuple[AnyCondition, ...]"

    @property
    def needs(self) -> Needs:
        return NOTHING.union(*(one.needs for one in self.of))

    def check(self, percepts: Percepts) -> Verdict:
        verdicts = [one.check(percepts) for one in self.of]
        holds = any(one.holds for one in verdicts)
        unseen = not holds and any(one.unseen for one in verdicts)
        return Verdict(holds, "; ".join(one.words for one in verdicts), unseen)


@dataclass(frozen=True, slots=True, kw_only=True)
class AllOf(Strict):
    """Every one of several."""

    sense: Literal["all"] = "all"
    of: "tuple[AnyCondition, ...]"

    @property
    def needs(self) -> Needs:
        return NOTHING.union(*(one.needs for one in self.of))

    def check(self, percepts: Percepts) -> Verdict:
        verdicts = [one.check(percepts) for one in self.of]
        unseen = any(one.unseen for one in verdicts)
        return Verdict(all(one.holds for one in verdicts), "; ".join(one.words for one in verdicts), unseen)


AnyCondition = Annotated[
    Near
    | Closer
    | Cramped
    | OffPoint
    | OnCourse
    | Believed
    | Close
    | Moving
    | NarrowPassage
    | Facing
    | Abeam
    | Opening
    | Reached
    | BetweenJaws
    | JawsAt
    | Holding
    | Empty
    | LiesAt
    | Vacant
    | Clear
    | Beside
    | InView
    | SoleHolder
    | Elapsed
    | Travelled
    | Advanced
    | Turned
    | Heading
    | AtRest
    | Faster
    | Raised
    | Bumped
    | AtHandle
    | HoldsAlone
    | JointNear
    | LinedUp
    | Still
    | Over
    | Charged
    | Charging
    | Commanded
    | NotDriven
    | Not
    | AnyOf
    | AllOf,
    Field(discriminator="sense"),
]


def unmet(conditions: Iterable[Condition], percepts: Percepts) -> list[Verdict]:
    """The verdict, with what was perceived instead, of every condition that does not hold."""
    return [verdict for condition in conditions if not (verdict := condition.check(percepts)).holds]


def in_words(verdicts: Iterable[Verdict]) -> str:
    return "; ".join(verdict.words for verdict in verdicts)
