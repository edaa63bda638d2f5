"""Goals in stages ("first … then …"): actions of a later stage start once the goals of the earlier ones are achieved.

A stage is achieved at the first point of a sequence at which all goals up to it are. Up to there stand only actions
that these goals need, and every action after it follows the actions that achieved them.
"""

from collections.abc import Iterator, Mapping, Sequence

from planner.errors import InvalidPlan
from planner.fact import Fact
from planner.knowledge import GroundAction
from planner.plan_nets.progression import apply_action, progressed
from planner.plan_nets.redundancy import without_redundant

Stages = Mapping[Fact, int]
"""The stage of each goal; goals that are not named belong to the first."""


def goals_by_stage(goals: Sequence[Fact], stages: Stages) -> list[tuple[Fact, ...]]:
    """For each stage in order, the goals up to and of that stage."""
    numbers = sorted({stages.get(goal, 0) for goal in goals})
    return [tuple(goal for goal in goals if stages.get(goal, 0) <= number) for number in numbers]


def without_redundant_by_stage(
    sequence: Sequence[GroundAction], facts: frozenset[Fact], goals: Sequence[Fact], stages: Stages
) -> tuple[GroundAction, ...]:
    """The sequence without the actions that the goals of their own stage can do without.

    :raises InvalidPlan: if an action of a later stage is among those of an earlier one.
    """
    kept: tuple[GroundAction, ...] = ()
    start = 0
    state = facts
    for due in goals_by_stage(goals, stages):
        end = max(start, _achieved_at(sequence, facts, due))
        try:
            needed = without_redundant(sequence[start:end], state, due)
        except InvalidPlan as error:
            raise InvalidPlan(f"an action of a later stage begins too early: {error}") from error
        state = progressed(state, needed)
        kept += needed
        start = end
    return kept


def stage_orderings(
    actions: Sequence[GroundAction], facts: frozenset[Fact], goals: Sequence[Fact], stages: Stages
) -> Iterator[tuple[int, int]]:
    """The pairs of positions that keep the stages apart: what achieves one, and what follows it."""
    for due in goals_by_stage(goals, stages)[:-1]:
        end = _achieved_at(actions, facts, due)
        for goal in due:
            achievers = [at for at in range(end) if goal in actions[at].intended_effects]
            for after in range(end, len(actions)) if achievers else ():
                yield achievers[-1], after


def _achieved_at(sequence: Sequence[GroundAction], facts: frozenset[Fact], goals: Sequence[Fact]) -> int:
    """The number of actions after which all of the goals are achieved for the first time."""
    state = set(facts)
    achieved = set(facts)
    for position, action in enumerate(sequence):
        if achieved.issuperset(goals):
            return position
        apply_action(action, state, achieved)
    return len(sequence)
