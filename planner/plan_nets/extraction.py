"""From a sequence of actions to a partial order: causal links, threats, orderings (MACTA §4: the plan-net).

Works on positions in the sequence, as the causal links do. The order found is a sub-order of the sequence, so
it cannot be cyclic. Of the orderings between a fact's users or a robot's actions only the nearest are recorded,
from which the others follow, so the work grows with the plan, not with its square.
"""

from bisect import bisect_left, bisect_right
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from planner.errors import CyclicOrder, InvalidPlan, OrderNotKept
from planner.fact import Fact
from planner.knowledge import GroundAction
from planner.plan_nets.causality import FROM_START, Link, causal_links
from planner.plan_nets.orders import Orders, order_pairs, unkept
from planner.plan_nets.plan_net import OrderingReason
from planner.plan_nets.precedence import Precedence, in_sequence
from planner.plan_nets.progression import apply_action
from planner.plan_nets.redundancy import without_redundant
from planner.plan_nets.stages import Stages, stage_orderings, without_redundant_by_stage


@dataclass(frozen=True, slots=True, kw_only=True)
class PartialOrder:
    """The actions with their links, and every ordering between them with its first reason."""

    actions: tuple[GroundAction, ...]
    links: tuple[Link, ...]
    orderings: Mapping[tuple[int, int], OrderingReason]


def extract(
    sequence: Sequence[GroundAction],
    facts: frozenset[Fact],
    goals: Sequence[Fact],
    stages: Stages | None = None,
    after: Orders | None = None,
) -> PartialOrder:
    """The partial order of a sequence that solves the problem, without its redundant actions.

    :param stages: the order among the goals; None: there is none.
    :param after: by goal, the goals after which it is to come true; the sequence may have another order. None: there
        are none.
    :raises InvalidPlan: if the sequence does not solve it, goals being achieved by intended effects only.
    :raises OrderNotKept: if no order of these actions has the goals come true as they are to.
    """
    if (fault := fault_of(sequence, facts, goals)) is not None:
        raise InvalidPlan(fault)
    if stages:
        actions = without_redundant_by_stage(sequence, facts, goals, stages)
    else:
        actions = without_redundant(sequence, facts, goals)
    links = causal_links(actions, facts, goals)
    pairs = _orderings(actions, links)
    for pair in stage_orderings(actions, facts, goals, stages) if stages else ():
        pairs.setdefault(pair, OrderingReason.STAGE)
    asked = order_pairs(actions, links, after) if after else {}
    if any(later <= earlier for earlier, later in asked):
        # In the new sequence the goals have the same achievers or earlier ones, so it is in order.
        return extract(_reordered(actions, pairs, asked), facts, goals, stages, after)
    for pair in asked:
        pairs.setdefault(pair, OrderingReason.ORDER)
    return PartialOrder(actions=actions, links=links, orderings=_reduced(pairs))


def _reordered(
    actions: Sequence[GroundAction],
    pairs: Mapping[tuple[int, int], OrderingReason],
    asked: Mapping[tuple[int, int], tuple[Fact, Fact]],
) -> list[GroundAction]:
    """The actions in an order of theirs in which goals come true as asked, as near to the given one as can be.

    :raises OrderNotKept: if there is none.
    """
    try:
        order = in_sequence(len(actions), [*pairs, *asked])
    except CyclicOrder as error:
        raise OrderNotKept(unkept(Precedence.of(len(actions), pairs), asked)) from error
    return [actions[position] for position in order]


def fault_of(sequence: Sequence[GroundAction], facts: frozenset[Fact], goals: Sequence[Fact]) -> str | None:
    """Why the sequence does not solve the problem, or None. A goal counts only if an intended effect
    achieved it."""
    state = set(facts)
    achieved = set(facts)
    for action in sequence:
        missing = [fact for fact in action.preconditions if fact not in state]
        if missing:
            return f"{action} needs {missing[0]}, which does not hold"
        apply_action(action, state, achieved)
    return next((f"the goal {goal} is not achieved" for goal in goals if goal not in achieved), None)


def _orderings(
    actions: Sequence[GroundAction], links: Sequence[Link]
) -> dict[tuple[int, int], OrderingReason]:
    """The orderings the links, the threats to them and shared robots ask for, first reason first."""
    pairs: dict[tuple[int, int], OrderingReason] = {}
    for link in links:
        if link.producer != FROM_START and link.consumer != len(actions):
            pairs.setdefault((link.producer, link.consumer), OrderingReason.CAUSAL)
    for pair in _threats(actions, links):
        pairs.setdefault(pair, OrderingReason.THREAT)
    latest: dict[str, int] = {}
    for position, action in enumerate(actions):
        for agent in action.agents:
            if agent in latest:
                pairs.setdefault((latest[agent], position), OrderingReason.RESOURCE)
            latest[agent] = position
    return pairs


def _threats(actions: Sequence[GroundAction], links: Sequence[Link]) -> Iterator[tuple[int, int]]:
    """The pairs that keep the deletes of a link's fact before its producer or after its consumer.

    A delete by an action that itself needs the fact has a link of its own, which keeps the deletes beyond it
    away: there the search outwards from the link ends.
    """
    deletes: dict[Fact, list[int]] = defaultdict(list)
    for position, action in enumerate(actions):
        for fact in action.deletes:
            deletes[fact].append(position)
    consumers = {(link.fact, link.consumer) for link in links}
    for link in links:
        positions = deletes.get(link.fact, [])
        if link.consumer != len(actions):
            for position in positions[bisect_right(positions, link.consumer) :]:
                yield link.consumer, position
                if (link.fact, position) in consumers:
                    break
        if link.producer != FROM_START:
            for position in reversed(positions[: bisect_left(positions, link.producer)]):
                yield position, link.producer
                if (link.fact, position) in consumers:
                    break


def _reduced(pairs: Mapping[tuple[int, int], OrderingReason]) -> dict[tuple[int, int], OrderingReason]:
    """The transitive reduction. The links keep what is causal, so no such information is lost."""
    count = 1 + max((after for _, after in pairs), default=0)
    return {pair: pairs[pair] for pair in sorted(Precedence.of(count, pairs).reduction())}
