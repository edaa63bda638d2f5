"""The phases of actions in a sequence: a robot ends what it has begun."""

from collections.abc import Mapping, Sequence, Set

from planner.knowledge import GroundAction


def next_phases(sequence: Sequence[GroundAction]) -> tuple[Mapping[int, int], Set[int]]:
    """For the position of each phase that of the next one of its action; and the phases whose earlier ones are not in
    the sequence, since they have ended."""
    following: dict[int, int] = {}
    orphans: set[int] = set()
    last: dict[str, int] = {}
    for position, action in enumerate(sequence):
        if action.follows is not None:
            before = last.get(action.agents[0])
            if before is not None and action.follows in sequence[before].intended_effects:
                following[before] = position
            else:
                orphans.add(position)
        last |= dict.fromkeys(action.agents, position)
    return following, orphans


def begun(sequence: Sequence[GroundAction]) -> tuple[GroundAction, ...]:
    """What is under way, and the later phases of actions that have begun."""
    following, orphans = next_phases(sequence)
    kept = {position for position, action in enumerate(sequence) if action.under_way} | orphans
    for position in sorted(following):
        if position in kept:
            kept.add(following[position])
    return tuple(action for position, action in enumerate(sequence) if position in kept)
