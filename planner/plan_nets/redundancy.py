"""Removes redundant actions from a sequence.

First those from which no chain of causal links leads to a goal: linear. The rest by action elimination (Nakhost
& Müller 2010): an action is removed, with all that then lack a condition, if the goals are still achieved: quadratic,
but most actions need no trial because they are provably in every valid part of the sequence.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from typing import NamedTuple

from planner.fact import Fact
from planner.knowledge import GroundAction
from planner.plan_nets.causality import FROM_START, causal_links
from planner.plan_nets.chains import next_phases
from planner.plan_nets.progression import apply_action


def without_redundant(
    sequence: Sequence[GroundAction], facts: frozenset[Fact], goals: Sequence[Fact]
) -> tuple[GroundAction, ...]:
    """The sequence without the actions it can do without; those under way stay, and those that are there for a number.

    :raises InvalidPlan: if a condition is not met.
    """
    linked = _linked(sequence, facts, goals)
    trimmed = _eliminated(linked, facts, goals)
    # A removed action may have been the only use of another.
    return trimmed if len(trimmed) == len(linked) else without_redundant(trimmed, facts, goals)


def _linked(
    sequence: Sequence[GroundAction], facts: frozenset[Fact], goals: Sequence[Fact]
) -> tuple[GroundAction, ...]:
    """The actions from which causal links lead to a goal or to what is under way, and those under way."""
    producers: dict[int, set[int]] = defaultdict(set)
    for link in causal_links(sequence, facts, goals):
        producers[link.consumer].add(link.producer)
    # What begins an action takes the later phases of it along.
    following, orphans = next_phases(sequence)
    running = [position for position, action in enumerate(sequence) if action.is_kept or position in orphans]
    waiting = [len(sequence), *running]
    useful = {FROM_START, *running}
    while waiting:
        position = waiting.pop()
        new = producers[position] - useful
        if (later := following.get(position)) is not None and later not in useful:
            new.add(later)
        useful |= new
        waiting += new
    return tuple(action for position, action in enumerate(sequence) if position in useful)


def _eliminated(
    sequence: Sequence[GroundAction], facts: frozenset[Fact], goals: Sequence[Fact]
) -> tuple[GroundAction, ...]:
    """Action elimination: each action tried, from the first on."""
    needed = indispensable(sequence, facts, goals)
    kept = [(action, action.is_kept or position in needed) for position, action in enumerate(sequence)]
    state = set(facts)
    achieved = set(facts)
    position = 0
    while position < len(kept):
        action, is_needed = kept[position]
        # The later phases of an action go only with the first.
        rest = (
            None
            if is_needed or action.follows is not None
            else _rest(kept[position + 1 :], set(state), set(achieved), goals)
        )
        if rest is None:
            apply_action(action, state, achieved)
            position += 1
        else:
            kept[position:] = rest
    return tuple(action for action, _ in kept)


def _rest(
    steps: list[tuple[GroundAction, bool]], state: set[Fact], achieved: set[Fact], goals: Sequence[Fact]
) -> list[tuple[GroundAction, bool]] | None:
    """The steps that can still be taken from here; None if they do not achieve the goals."""
    kept = []
    for action, is_needed in steps:
        if state.issuperset(action.preconditions):
            apply_action(action, state, achieved)
            kept.append((action, is_needed))
        elif is_needed or action.follows in state:
            return None  # it is wanted, or its robot has begun what it belongs to
    return kept if achieved.issuperset(goals) else None


class _Goal(NamedTuple):
    """The key of a fact's timeline as a goal, which intended effects alone bring about."""

    fact: Fact


class _Kind(Enum):
    """What an action does with a fact."""

    NEEDS = "needs"  # has it as a pre-condition, or the goals do
    DELETES = "deletes"  # ends it
    ADDS = "adds"  # brings it about


_Timelines = Mapping[Fact | _Goal, list[tuple[int, _Kind]]]


def indispensable(
    sequence: Sequence[GroundAction], facts: frozenset[Fact], goals: Sequence[Fact]
) -> set[int]:
    """Positions that every valid part of the sequence holds; `len(sequence)`, the goals, among them.

    What an indispensable action needs must hold after the last indispensable delete of it before: if one
    action alone can bring that about, that one is indispensable, too.
    """
    timelines = _timelines(sequence, goals)
    needed = {len(sequence)}
    changed: set[Fact | _Goal] = {_Goal(goal) for goal in goals}
    while changed:
        new = {
            position
            for key in changed
            for position in _sole_producers(timelines[key], _fact(key) in facts, needed)
        }
        new -= needed
        needed |= new
        changed = set()
        for action in (sequence[position] for position in new):
            changed.update(action.preconditions, action.deletes)
            changed.update(goal for fact in action.deletes if (goal := _Goal(fact)) in timelines)
    return needed


def _timelines(sequence: Sequence[GroundAction], goals: Sequence[Fact]) -> _Timelines:
    lines: dict[Fact | _Goal, list[tuple[int, _Kind]]] = {_Goal(goal): [] for goal in goals}
    for position, action in enumerate(sequence):
        for kind, facts, intended in (
            (_Kind.NEEDS, action.preconditions, ()),
            (_Kind.DELETES, action.deletes, action.deletes),
            (_Kind.ADDS, action.effects, action.intended_effects),
        ):
            for fact in facts:
                lines.setdefault(fact, []).append((position, kind))
            for fact in intended:
                if (goal := _Goal(fact)) in lines:
                    lines[goal].append((position, kind))
    for fact in goals:
        lines[_Goal(fact)].append((len(sequence), _Kind.NEEDS))
    return lines


def _sole_producers(line: list[tuple[int, _Kind]], initially: bool, needed: set[int]) -> Iterator[int]:
    candidates = [FROM_START] if initially else []
    for position, kind in line:
        if kind is _Kind.ADDS:
            candidates.append(position)
        elif position not in needed:
            continue
        elif kind is _Kind.DELETES:
            candidates = []
        elif len(candidates) == 1 and candidates[0] != FROM_START:
            yield candidates[0]


def _fact(key: Fact | _Goal) -> Fact:
    return key.fact if isinstance(key, _Goal) else key
