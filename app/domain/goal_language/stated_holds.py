"""Holds: places that are kept empty until a time, the end of a mission or goal, a fact, or an operator's word."""

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Self

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, model_validator

from app.domain.goal_language.constraints import Constraints, Name, Names
from app.domain.goal_language.times import in_words
from app.domain.goal_language.words import joined
from robots.wire import SymbolicFact
from robots.world import WorldFile


class HoldFact(SymbolicFact):
    """A fact that ends a hold once it is true."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    predicate: Name
    args: tuple[Name, ...] = Field(default=(), max_length=8)


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
        """The end in words, after "held empty"."""
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
    """Places to keep empty, and until when."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    places: Annotated[Names, Field(min_length=1, max_length=1000)] = Field(
        description="locations, areas' places or berths, where no sample is put while the hold stands"
    )
    until: HoldEnd = HoldEnd()

    @property
    def words(self) -> str:
        return f"{joined(self.places, last='and')} empty {self.until.words}"


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldPreview:
    """A hold that is not made yet, and what it would do, in words."""

    places: Names
    until: HoldEnd
    words: str

    @classmethod
    def of(cls, hold: StatedHold, now: datetime) -> Self:
        left = "" if hold.until.at is None else f" (in {in_words((hold.until.at - now).total_seconds())})"
        return cls(places=hold.places, until=hold.until, words=f"will hold {hold.words}{left}")


@dataclass(frozen=True, slots=True, kw_only=True)
class StandingHold:
    """A hold that stands.

    :param places: where no sample is put: berths, of locations that have several.
    :param words: "bay_3 empty until ...".
    """

    id: str
    places: frozenset[str]
    words: str

    def __str__(self) -> str:
        return f"the end of hold {self.id}, which keeps {self.words}"


def held_places(holds: Iterable[StandingHold]) -> frozenset[str]:
    return frozenset[str]().union(*(hold.places for hold in holds))


def kept_by(holds: Iterable[StatedHold]) -> Constraints:
    """What the holds mean for the goal that states them: its own plan keeps the places empty, too."""
    return Constraints(keep_empty=tuple(dict.fromkeys(name for hold in holds for name in hold.places)))


def places_in(names: Iterable[str], world: WorldFile) -> frozenset[str]:
    """The places of these locations: their berths, where they have several."""
    return Constraints(keep_empty=tuple(names)).in_world(world).kept_empty
