"""Causal links of a sequence of actions (MACTA §4: the plan-net).

Works on positions in the sequence; -1 stands for the initial state, `len(sequence)` for the goals.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from planner.errors import InvalidPlan
from planner.fact import Fact
from planner.knowledge import GroundAction

FROM_START = -1


@dataclass(frozen=True, slots=True, order=True)
class Link:
    """A causal link between positions."""

    producer: int
    fact: Fact
    consumer: int


def causal_links(
    actions: Sequence[GroundAction], facts: frozenset[Fact], goals: Sequence[Fact]
) -> tuple[Link, ...]:
    """For each condition its earliest producer after the last delete: the least ordering this choice allows.

    Goals are produced by intended effects only.

    :raises InvalidPlan: if nothing brings about a condition.
    """
    links: list[Link] = []
    brought = dict.fromkeys(facts, FROM_START)
    achieved = {goal: FROM_START for goal in goals if goal in facts}
    wanted = frozenset(goals)
    for position, action in enumerate(actions):
        links += (_link(brought, fact, position) for fact in action.preconditions)
        for fact in action.deletes:
            brought.pop(fact, None)
            achieved.pop(fact, None)
        for fact in action.effects:
            brought.setdefault(fact, position)
        for fact in wanted.intersection(action.intended_effects):
            achieved.setdefault(fact, position)
    links += (_link(achieved, goal, len(actions)) for goal in dict.fromkeys(goals))
    return tuple(links)


def _link(producers: dict[Fact, int], fact: Fact, consumer: int) -> Link:
    if fact not in producers:
        raise InvalidPlan(f"nothing brings about {fact}")
    return Link(producers[fact], fact, consumer)
