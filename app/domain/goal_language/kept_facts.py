"""Facts that are kept true: "keep sample_1 in bay_7", "keep yard_1 at door_1"; what ends them, and what leaves them."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated

from pydantic import ConfigDict, Field

from app.domain.goal_language.issues import GoalIssue, unknown_name
from app.domain.goal_language.roles import unknown_robot
from app.domain.goal_language.words import natural_key
from app.domain.world_model.beliefs import IN, NEAR, Facts, place_of, position_of
from app.domain.world_model.berths import berths_of
from robots.wire import SymbolicFact
from robots.world import WorldFile

Name = Annotated[str, Field(min_length=1, max_length=64)]
KEPT = (IN, NEAR)
"""The predicates of facts that can be kept: where a sample lies, where a robot stands."""
POSITIONS = frozenset({IN, NEAR, "at"})
"""The predicates that say where a thing is; one of them is true of it at a time."""


class HoldFact(SymbolicFact):
    """A fact of a hold: one that it keeps true, or one that ends it once it is true."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    predicate: Name
    args: tuple[Name, ...] = Field(default=(), max_length=8)

    @property
    def words(self) -> str:
        """`sample_1 in bay_7`, `yard_1 at door_1`; a fact that cannot be kept as it is written."""
        if self.predicate not in KEPT or len(self.args) != 2:
            return str(self)
        return f"{self.args[0]} {'in' if self.predicate == IN else 'at'} {self.args[1]}"


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptThings:
    """What plans that keep facts true leave alone.

    :param samples: they are not gripped; `robots`: they do not act.
    :param places: where one of the samples is to lie: no other is put there.
    """

    samples: frozenset[str]
    robots: frozenset[str]
    places: frozenset[str]


def kept_things(kept: Iterable[HoldFact], world: WorldFile) -> KeptThings:
    """What these facts have a plan leave alone. A location with several berths has room for others."""
    stored = [fact for fact in kept if fact.predicate == IN and len(fact.args) == 2]
    standing = [fact for fact in kept if fact.predicate == NEAR and len(fact.args) == 2]
    rows = [_places(fact, world) for fact in stored]
    return KeptThings(
        samples=frozenset(fact.args[0] for fact in stored),
        robots=frozenset(fact.args[0] for fact in standing),
        places=frozenset[str]().union(*(row for row in rows if len(row) == 1)),
    )


def is_kept_true(kept: HoldFact, world: WorldFile, facts: Facts) -> bool:
    """True if the fact is believed; of a location with several berths: of one of them."""
    thing = kept.args[0]
    if kept.predicate == IN:
        return place_of(thing, facts) in _places(kept, world)
    position = position_of(thing, facts)
    return position is not None and position.args[1] == NEAR and position.args[2] in _places(kept, world)


def believed_now(kept: HoldFact, facts: Facts) -> str:
    """Where its sample or robot is believed to be, in words."""
    thing = kept.args[0]
    if kept.predicate == IN:
        place = place_of(thing, facts)
        return f"{thing} is in an unknown place" if place is None else f"{thing} is in {place}"
    position = position_of(thing, facts)
    if position is None:
        return f"{thing} is in an unknown place"
    return f"{thing} is {position.args[1]} {position.args[2]}"


def achieves(goal: SymbolicFact, kept: SymbolicFact, world: WorldFile) -> bool:
    """True if the fact is true wherever the goal is."""
    return (
        len(goal.args) == 2
        and (goal.predicate, goal.args[0]) == (kept.predicate, kept.args[0])
        and _places(goal, world) <= _places(kept, world)
    )


def contradicts(goal: SymbolicFact, kept: SymbolicFact, world: WorldFile) -> bool:
    """True if the goal and the fact cannot both be true: one thing in two places, two samples in one place."""
    if len(goal.args) != 2 or goal.predicate not in POSITIONS:
        return False
    goes = _places(goal, world)
    stays = _places(kept, world)
    if goal.args[0] == kept.args[0]:
        return goal.predicate != kept.predicate or not goes & stays
    return goal.predicate == kept.predicate == IN and goes == stays and len(stays) == 1


def left_to_keep(
    kept: Iterable[HoldFact], goals: Sequence[SymbolicFact], world: WorldFile
) -> tuple[HoldFact, ...]:
    """The facts that none of the goals brings about."""
    return tuple(fact for fact in kept if not any(achieves(goal, fact, world) for goal in goals))


def unknown_in(kept: Iterable[HoldFact], world: WorldFile) -> Iterator[GoalIssue]:
    """The issues with facts that cannot be kept: not about where a sample or robot is, or unknown names."""
    samples = tuple(sorted((sample.name for sample in world.samples), key=natural_key))
    robots = [robot.name for robot in world.robots]
    places = (*world.places_by_location, *world.location_of)
    for fact in dict.fromkeys(kept):
        if fact.predicate not in KEPT:
            yield GoalIssue(
                code="fact-not-kept",
                kind="invalid",
                detail=f"{fact} cannot be kept true, only in(sample, place) and near(robot, place)",
                thing=fact.predicate,
                choices=KEPT,
            )
        elif len(fact.args) != 2:
            detail = f"{fact}: {fact.predicate} is about a thing and a place"
            yield GoalIssue(code="malformed-fact", kind="invalid", detail=detail, thing=fact.predicate)
        else:
            thing, place = fact.args
            if fact.predicate == IN and thing not in samples:
                yield unknown_name("sample", thing, samples)
            if fact.predicate == NEAR and thing not in robots:
                yield unknown_robot(thing, world)
            if place not in places:
                yield unknown_name("place", place, tuple(dict.fromkeys(places)))


def _places(fact: SymbolicFact, world: WorldFile) -> frozenset[str]:
    """The places of the location that a fact about a thing and a place names: its berths, where it has several."""
    return frozenset(berths_of(fact.args[-1], world) or fact.args[-1:])
