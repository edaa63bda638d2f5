"""Holds: places kept empty, facts kept true, until a time, a mission's or goal's end, a fact or an operator's word."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Self

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, model_validator

from app.domain.goal_language.constraints import AppliedConstraints, Constraints, Names
from app.domain.goal_language.kept_facts import HoldFact, Name, is_kept_true, kept_things, left_to_keep
from app.domain.goal_language.times import in_words
from app.domain.goal_language.words import joined
from app.domain.world_model.beliefs import Facts
from robots.wire import SymbolicFact
from robots.world import WorldFile


class HoldEnd(BaseModel):
    """When a hold ends: the one that is given; if none is, when an operator ends it."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    at: AwareDatetime | None = Field(
        default=None, description="a time by the wall clock, ISO 8601 with its offset"
    )
    in_s: float | None = Field(default=None, gt=0, description="seconds from its begin, world's clock")
    mission: Name | None = Field(default=None, description="once this mission has ended")
    goal: Name | None = Field(default=None, description="once this goal is over")
    fact: HoldFact | None = Field(default=None, description="once this fact is true")

    @model_validator(mode="after")
    def _at_most_one(self) -> Self:
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(given) > 1:
            raise ValueError(f"a hold has one end; give one of {joined(given)}")
        return self

    @property
    def words(self) -> str:
        """The end in words, after what is held."""
        if self.at is not None:
            return f"until {self.at:%Y-%m-%d %H:%M} {self.at.tzname()}"
        if self.in_s is not None:
            return f"for {in_words(self.in_s)} of the world's clock"
        if self.mission is not None:
            return f"until mission {self.mission} has ended"
        if self.goal is not None:
            return f"until goal {self.goal} is over"
        if self.fact is not None:
            return f"until {self.fact}"
        return "until an operator ends it"


class StatedHold(BaseModel):
    """Places to keep empty and facts to keep true, at least one, and until when."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    places: Annotated[Names, Field(max_length=1000)] = Field(
        default=(),
        description="locations, areas' places or berths, where no sample is put while the hold stands",
    )
    facts: Annotated[tuple[HoldFact, ...], Field(max_length=1000)] = Field(
        default=(),
        description="facts in(sample, place) and near(robot, place) that no plan of another goal ends while the "
        "hold stands",
        examples=[[{"predicate": "in", "args": ["sample_1", "bay_7"]}]],
    )
    until: HoldEnd = HoldEnd()

    @model_validator(mode="after")
    def _keeps_something(self) -> Self:
        if not self.places and not self.facts:
            raise ValueError("a hold keeps places empty or facts true; give places, facts or both")
        return self

    @property
    def words(self) -> str:
        return f"{kept_words(self.places, self.facts)} {self.until.words}"


def kept_words(places: Sequence[str], facts: Sequence[HoldFact]) -> str:
    """What a hold keeps: `bay_3 and bay_4 empty and sample_1 in bay_7`."""
    empty = (f"{joined(places, last='and')} empty",) if places else ()
    return joined((*empty, *(fact.words for fact in facts)), last="and")


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldPreview:
    """A hold that is not made yet, and what it would do, in words."""

    places: Names
    facts: tuple[HoldFact, ...]
    until: HoldEnd
    words: str

    @classmethod
    def of(cls, hold: StatedHold, now: datetime) -> Self:
        left = "" if hold.until.at is None else f" (in {in_words((hold.until.at - now).total_seconds())})"
        return cls(
            places=hold.places, facts=hold.facts, until=hold.until, words=f"will hold {hold.words}{left}"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class StandingHold:
    """A hold that stands.

    :param places: where no sample is put: berths, of locations that have several.
    :param facts: what no plan of another goal ends.
    :param words: "bay_3 empty until ...".
    """

    id: str
    places: frozenset[str]
    words: str
    facts: tuple[HoldFact, ...] = ()

    def __str__(self) -> str:
        return f"the end of hold {self.id}, which keeps {self.words}"

    def required_of(self, goals: Sequence[SymbolicFact], world: WorldFile) -> AppliedConstraints:
        """What it requires of plans for these goals: nothing for the sake of facts that they bring about themselves."""
        return _applied(self.places, left_to_keep(self.facts, goals, world), world)

    def forbidden_to(
        self, goals: Sequence[SymbolicFact], world: WorldFile, facts: Facts, *, has_begun: bool
    ) -> AppliedConstraints:
        """What a plan for these goals must not do. What it brings about and is true already, it must not end meanwhile.

        :param has_begun: the plan is being carried out; it may then have made true what it has yet to end.
        """
        left = left_to_keep(self.facts, goals, world)
        if not has_begun:
            left = tuple(one for one in self.facts if one in left or is_kept_true(one, world, facts))
        return _applied(self.places, left, world)


def _applied(places: frozenset[str], facts: Sequence[HoldFact], world: WorldFile) -> AppliedConstraints:
    kept = kept_things(facts, world)
    return AppliedConstraints(
        excluded=kept.robots, kept_empty=places, kept_samples=kept.samples, kept_for=kept.places
    )


def kept_by_standing(holds: Iterable[StandingHold]) -> Constraints:
    """What the holds that stand mean for the choices of other goals."""
    standing = list(holds)
    return Constraints(
        keep_empty=tuple(sorted({place for hold in standing for place in hold.places})),
        keep=tuple(dict.fromkeys(fact for hold in standing for fact in hold.facts)),
    )


def kept_by(holds: Iterable[StatedHold]) -> Constraints:
    """What the holds mean for the goal that states them: its own plan keeps the places empty, the facts true, too."""
    stated = list(holds)
    return Constraints(
        keep_empty=tuple(dict.fromkeys(name for hold in stated for name in hold.places)),
        keep=tuple(dict.fromkeys(fact for hold in stated for fact in hold.facts)),
    )


def places_in(names: Iterable[str], world: WorldFile) -> frozenset[str]:
    """The places of these locations: their berths, where they have several."""
    return Constraints(keep_empty=tuple(names)).in_world(world).kept_empty
