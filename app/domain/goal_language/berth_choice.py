"""Goals that name a location with several berths: one berth is chosen for each when planning begins."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

from app.domain.world_model.beliefs import IN, NEAR, Facts, occupants, place_of, position_of
from app.domain.world_model.berths import berths_of
from robots.wire import SymbolicFact
from robots.world import WorldFile

AT = "at"


def resolve_berths(
    goals: Sequence[SymbolicFact],
    world: WorldFile,
    facts: Facts,
    *,
    preferred: Collection[str] = (),
    avoid: Collection[str] = (),
) -> Mapping[SymbolicFact, SymbolicFact | None]:
    """Each goal with the berth that is chosen for it; None where no berth is left.

    A sample that lies in one of the berths stays there. Otherwise the berth has no sample that stays, and no other goal
    aims at it.

    :param preferred: berths that an earlier plan of the goals aimed at: first choice.
    :param avoid: berths that others aim at: last choice.
    """
    chosen: dict[SymbolicFact, SymbolicFact | None] = {}
    request = _Request(goals=goals, world=world, facts=facts, preferred=preferred, avoid=avoid)
    aims = {(goal.predicate, goal.args[1]): goal.args[0] for goal in goals if len(goal.args) == 2}
    for goal in dict.fromkeys(goals):
        if not _berths(goal, world):
            chosen[goal] = goal
            continue
        berth = request.best_for(goal, aims)
        chosen[goal] = None
        if berth is not None:
            aims[goal.predicate, berth] = goal.args[0]
            chosen[goal] = goal.model_copy(update={"args": (goal.args[0], berth)})
    return chosen


def assign_berths(
    goals: Sequence[SymbolicFact],
    world: WorldFile,
    facts: Facts,
    *,
    preferred: Collection[str] = (),
    avoid: Collection[str] = (),
) -> tuple[SymbolicFact, ...]:
    """The goals with `resolve_berths`; where no berth is left, with an occupied one, which `check_goals` reports."""
    found = resolve_berths(goals, world, facts, preferred=preferred, avoid=avoid)
    aims = {goal.args[-1] for goal in found.values() if goal is not None}
    return tuple(found[goal] or _with_occupied_berth(goal, world, aims) for goal in goals)


def _with_occupied_berth(goal: SymbolicFact, world: WorldFile, aims: Collection[str]) -> SymbolicFact:
    """The goal with a berth that is not free, preferably one that no other goal aims at."""
    berth = min(_berths(goal, world), key=lambda berth: berth in aims)
    return goal.model_copy(update={"args": (goal.args[0], berth)})


def remaining_samples(
    place: str, goals: Iterable[SymbolicFact], world: WorldFile, facts: Facts
) -> tuple[str, ...]:
    """The samples that lie in a place and that none of the goals takes away from there."""
    here = {place, world.location_of.get(place, place)}
    leaving = {g.args[0] for g in goals if g.predicate == IN and len(g.args) == 2 and g.args[1] not in here}
    return tuple(other for other in occupants(place, facts) if other not in leaving)


Aims = Mapping[tuple[str, str], str]
"""By predicate and place, the sample or robot that is to be in or near the place."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Request:
    """The arguments of `resolve_berths`."""

    goals: Sequence[SymbolicFact]
    world: WorldFile
    facts: Facts
    preferred: Collection[str]
    avoid: Collection[str]

    def best_for(self, goal: SymbolicFact, aims: Aims) -> str | None:
        """The first choice of the berths that are free for the goal; None if none is."""
        subject = goal.args[0]
        here = place_of(subject, self.facts) if goal.predicate == IN else _stands(subject, self.facts)
        return min(
            (berth for berth in _berths(goal, self.world) if self._is_free(berth, goal, aims)),
            key=lambda berth: (
                aims.get((goal.predicate, berth)) != subject,
                berth != here,
                berth not in self.preferred,
                bool(occupants(berth, self.facts)),
                berth in self.avoid,
            ),
            default=None,
        )

    def _is_free(self, berth: str, goal: SymbolicFact, aims: Aims) -> bool:
        """True if no other goal aims at the berth and no other sample stays in it."""
        subject = goal.args[0]
        stay = remaining_samples(berth, self.goals, self.world, self.facts) if goal.predicate == IN else ()
        return aims.get((goal.predicate, berth), subject) == subject and set(stay) <= {subject}


def _berths(goal: SymbolicFact, world: WorldFile) -> tuple[str, ...]:
    """The berths to choose from; empty if the goal is not about a location that has several."""
    if len(goal.args) != 2 or goal.predicate not in {IN, NEAR, AT}:
        return ()
    return berths_of(goal.args[1], world)


def _stands(robot: str, facts: Facts) -> str | None:
    position = position_of(robot, facts)
    return None if position is None else position.args[2]
