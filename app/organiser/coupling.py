"""How robots stay in step: awaits are sensed, and orderings follow from awaits and each robot's own order.

Robots do not talk to each other: what one brings about, the next perceives (MACTA §3, "the pre-condition for
the next is encountered"; §5, no need for robots to communicate directly).
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from itertools import pairwise

from app.vocabulary import symbolic, types_in
from planner import GOAL, INITIAL, Fact, KnowledgeBase, PlanNet

Start = tuple[str, str]
"""A robot's start of an action: action id, robot."""
Awaits = Mapping[Start, tuple[Fact, ...]]


def awaits_of(plan_net: PlanNet) -> Awaits:
    """For each robot's start of an action the conditions that other robots' actions bring about."""
    agents = {action.id: action.agents for action in plan_net.actions}
    found: dict[Start, dict[Fact, None]] = defaultdict(dict)
    for link in plan_net.causal_links:
        if link.producer == INITIAL or link.consumer == GOAL:
            continue
        for robot in agents[link.consumer]:
            if robot not in agents[link.producer]:
                found[link.consumer, robot][link.fact] = None
    return {start: tuple(facts) for start, facts in found.items()}


def unsensed(plan_net: PlanNet, knowledge_base: KnowledgeBase) -> str | None:
    """The first condition that a robot would have to sense and cannot, in words."""
    facts = [f for action in plan_net.actions for f in (*action.preconditions, *action.effects)]
    objects = types_in(facts, knowledge_base)
    for (action, robot), awaited in awaits_of(plan_net).items():
        for fact in awaited:
            if not knowledge_base.is_sensed(fact, objects):
                what = symbolic(fact, knowledge_base)
                return f"{robot} cannot sense {what}, which {action} awaits of another robot"
    return None


def unkept_ordering(plan_net: PlanNet) -> str | None:
    """The first ordering that the scripts would not keep, in words.

    Actions that several robots do together end together; each robot starts its part by itself.
    """
    follows = _follows(plan_net)
    agents = {action.id: action.agents for action in plan_net.actions}
    for ordering in plan_net.orderings:
        if ordering.before == INITIAL or ordering.after == GOAL:
            continue
        for robot in agents[ordering.after]:
            if (ordering.after, robot) not in _reached(follows, ordering.before):
                return (
                    f"nothing that {robot} senses keeps {ordering.after} after {ordering.before} "
                    f"({ordering.reason.value})"
                )
    return None


def _follows(plan_net: PlanNet) -> Mapping[str, set[Start]]:
    """From an action's end to the starts that wait for it: the same robot's next, and those that await it."""
    follows: dict[str, set[Start]] = defaultdict(set)
    for robot in plan_net.robots:
        mine = plan_net.of_robot(robot)
        for before, after in pairwise(mine):
            follows[before.id].add((after.id, robot))
    awaited = awaits_of(plan_net)
    for link in plan_net.causal_links:
        for (action, robot), facts in awaited.items():
            if link.consumer == action and link.fact in facts and link.producer != INITIAL:
                follows[link.producer].add((action, robot))
    return follows


def _reached(follows: Mapping[str, set[Start]], action: str) -> frozenset[Start]:
    """Every start that comes after the action's end."""
    return frozenset(_walk(follows, action, set()))


def _walk(follows: Mapping[str, set[Start]], action: str, seen: set[Start]) -> Iterator[Start]:
    for start in follows.get(action, set()) - seen:
        seen.add(start)
        yield start
        yield from _walk(follows, start[0], seen)
