"""Progression: the facts that hold once actions have been carried out."""

from collections.abc import Iterable

from planner.fact import Fact
from planner.knowledge import GroundAction


def progressed(facts: Iterable[Fact], actions: Iterable[GroundAction]) -> frozenset[Fact]:
    """The facts after the actions in this order; pre-conditions are not checked."""
    state = set(facts)
    for action in actions:
        state.difference_update(action.deletes)
        state.update(action.effects)
    return frozenset(state)


def apply_action(action: GroundAction, state: set[Fact], achieved: set[Fact]) -> None:
    """Apply an action to the facts that hold and to those achieved: initially or by intended effects (table 3)."""
    for held, effects in ((state, action.effects), (achieved, action.intended_effects)):
        held.difference_update(action.deletes)
        held.update(effects)
