"""From a sequence of actions to a partial order: causal links, threats, orderings (MACTA §4: the plan-net).

Works on positions in the sequence; -1 stands for the initial state, `len(sequence)` for the goals. The order
found is a sub-order of the sequence, so it cannot be cyclic.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from planner.errors import InvalidPlan
from planner.fact import Fact
from planner.knowledge import GroundAction
from planner.plan_net import OrderingReason

FROM_START = -1


@dataclass(frozen=True, slots=True, order=True)
class Link:
    """A causal link between positions."""

    producer: int
    fact: Fact
    consumer: int


@dataclass(frozen=True, slots=True, kw_only=True)
class PartialOrder:
    """The actions with their links, and every ordering between them with its first reason."""

    actions: tuple[GroundAction, ...]
    links: tuple[Link, ...]
    orderings: Mapping[tuple[int, int], OrderingReason]


def extract(sequence: Sequence[GroundAction], facts: frozenset[Fact], goals: Sequence[Fact]) -> PartialOrder:
    """The partial order of a sequence that solves the problem, without its redundant actions.

    :raises InvalidPlan: if the sequence does not solve it, goals being achieved by intended effects only.
    """
    if (fault := fault_of(sequence, facts, goals)) is not None:
        raise InvalidPlan(fault)
    actions = without_redundant(sequence, facts, goals)
    links = causal_links(actions, facts, goals)
    return PartialOrder(actions=actions, links=links, orderings=reduced(_orderings(actions, links), links))


def fault_of(sequence: Sequence[GroundAction], facts: frozenset[Fact], goals: Sequence[Fact]) -> str | None:
    """Why the sequence does not solve the problem, or None. A goal counts only if an intended effect
    achieved it."""
    state, achieved = set(facts), set(facts)
    for action in sequence:
        missing = [fact for fact in action.preconditions if fact not in state]
        if missing:
            return f"{action} needs {missing[0]}, which does not hold"
        state.difference_update(action.deletes)
        achieved.difference_update(action.deletes)
        state.update(action.effects)
        achieved.update(action.intended_effects)
    return next((f"the goal {goal} is not achieved" for goal in goals if goal not in achieved), None)


def without_redundant(
    sequence: Sequence[GroundAction], facts: frozenset[Fact], goals: Sequence[Fact]
) -> tuple[GroundAction, ...]:
    """The sequence without the actions it can do without (each tried with all that then lack a condition)."""
    kept = list(sequence)
    position = 0
    while position < len(kept):
        trial = _without(kept, position, facts)
        if fault_of(trial, facts, goals) is None:
            kept = trial
        else:
            position += 1
    return tuple(kept)


def _without(sequence: list[GroundAction], position: int, facts: frozenset[Fact]) -> list[GroundAction]:
    state, kept = set(facts), []
    for index, action in enumerate(sequence):
        if index != position and all(fact in state for fact in action.preconditions):
            state.difference_update(action.deletes)
            state.update(action.effects)
            kept.append(action)
    return kept


def causal_links(
    actions: Sequence[GroundAction], facts: frozenset[Fact], goals: Sequence[Fact]
) -> tuple[Link, ...]:
    """For each condition its earliest producer after the last delete: the least ordering this choice
    allows."""
    links: list[Link] = []
    for consumer, action in enumerate(actions):
        links += [
            Link(_producer(actions, facts, fact, consumer), fact, consumer) for fact in action.preconditions
        ]
    end = len(actions)
    links += [
        Link(_producer(actions, facts, goal, end, goal=True), goal, end) for goal in dict.fromkeys(goals)
    ]
    return tuple(links)


def _producer(
    actions: Sequence[GroundAction], facts: frozenset[Fact], fact: Fact, consumer: int, *, goal: bool = False
) -> int:
    producer: int | None = FROM_START if fact in facts else None
    for position in range(consumer):
        action = actions[position]
        if fact in action.deletes:
            producer = None
        effects = action.intended_effects if goal else action.effects
        if producer is None and fact in effects:
            producer = position
    if producer is None:
        raise InvalidPlan(f"nothing brings about {fact}")
    return producer


def _orderings(
    actions: Sequence[GroundAction], links: Sequence[Link]
) -> dict[tuple[int, int], OrderingReason]:
    """Every ordering the links, the threats to them and shared robots ask for."""
    pairs: dict[tuple[int, int], OrderingReason] = {}
    for link in links:
        if link.producer != FROM_START and link.consumer != len(actions):
            pairs.setdefault((link.producer, link.consumer), OrderingReason.CAUSAL)
    for link in links:
        for position, action in enumerate(actions):
            if link.fact in action.deletes and position not in (link.producer, link.consumer):
                if position > link.consumer:
                    pairs.setdefault((link.consumer, position), OrderingReason.THREAT)
                elif link.producer != FROM_START and position < link.producer:
                    pairs.setdefault((position, link.producer), OrderingReason.THREAT)
    for after, action in enumerate(actions):
        for before in range(after):
            if set(action.agents) & set(actions[before].agents):
                pairs.setdefault((before, after), OrderingReason.RESOURCE)
    return pairs


def reduced(
    pairs: Mapping[tuple[int, int], OrderingReason], links: Sequence[Link]
) -> dict[tuple[int, int], OrderingReason]:
    """The transitive reduction. The links keep what is causal, so no such information is lost."""
    successors: dict[int, set[int]] = {}
    for before, after in pairs:
        successors.setdefault(before, set()).add(after)
    beyond: dict[int, set[int]] = {}
    for node in sorted({n for pair in pairs for n in pair}, reverse=True):
        beyond[node] = set().union(*({s} | beyond.get(s, set()) for s in successors.get(node, ())))
    return {
        (before, after): reason
        for (before, after), reason in sorted(pairs.items())
        if not any(after in beyond.get(via, ()) for via in successors[before] if via != after)
    }
