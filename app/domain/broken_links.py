"""Causal links that a mission still depends on and whose facts are no longer believed."""

from collections.abc import Collection

from app.domain.world_model.beliefs import CAN, OBJECT_POSITION, REACHES, VACANT, Facts
from planner import GOAL, INITIAL, CausalLink, PlanNet

COUNTED_ON = frozenset({OBJECT_POSITION, VACANT, CAN, REACHES})
"""Predicates that can break a link: places of samples, abilities of robots. Robots' positions cannot: robots move by
themselves, and sense and wait for those in their way."""


def broken_links(
    plan_net: PlanNet, facts: Facts, *, begun: Collection[str], done: Collection[str]
) -> tuple[CausalLink, ...]:
    """The links whose producer has ended and whose consumer has not begun, while the fact is not believed.

    The predecessors of an action that has begun count as begun, because their reports may still be on the way.

    :param begun: the ids of the actions that have begun or ended.
    :param done: the ids of those that have ended and whose effects are believed.
    """
    started = _with_predecessors(plan_net, begun)
    return tuple(
        link
        for link in plan_net.causal_links
        if link.fact.predicate in COUNTED_ON
        and (link.producer == INITIAL or link.producer in done)
        and (link.consumer == GOAL or link.consumer not in started)
        and link.fact not in facts
    )


def _with_predecessors(plan_net: PlanNet, begun: Collection[str]) -> set[str]:
    before: dict[str, set[str]] = {}
    for ordering in plan_net.orderings:
        before.setdefault(ordering.after, set()).add(ordering.before)
    found = set(begun)
    left = list(begun)
    while left:
        fresh = before.get(left.pop(), set()) - found
        found |= fresh
        left.extend(fresh)
    return found
