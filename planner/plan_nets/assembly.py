"""From a partial order to the plan-net: time windows, ids, descriptions."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace

from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_nets.causality import FROM_START
from planner.plan_nets.extraction import PartialOrder
from planner.plan_nets.plan_net import GOAL, INITIAL, CausalLink, Ordering, PlanNet, PlanNetAction
from planner.plan_nets.schedule import windows


def assemble(
    order: PartialOrder,
    goals: Sequence[Fact],
    knowledge_base: KnowledgeBase,
    recruitment: Mapping[str, str],
    deadlines_s: Mapping[Fact, float] | None = None,
    not_before_s: Mapping[Fact, float] | None = None,
) -> PlanNet:
    """The scheduled plan-net; actions are called a1, a2, … in the order of their earliest start.

    :param deadlines_s: goals' deadlines, seconds from the plan's start; they bound the latest starts. What cannot
        be kept stands in the plan-net's `late`.
    :param not_before_s: when the actions that achieve goals may start at the earliest, likewise.
    """
    end = len(order.actions)
    achievers = {link.fact: link.producer for link in order.links if link.consumer == end}
    spans = [action.duration_s for action in order.actions]
    due = {
        goal: (producer, deadlines_s[goal])
        for goal, producer in achievers.items()
        if deadlines_s and goal in deadlines_s and producer != FROM_START
    }
    starts_from: dict[int, float] = {}
    for goal, producer in achievers.items():
        start_s = (not_before_s or {}).get(goal, 0.0)
        if producer != FROM_START and start_s > 0.0:
            starts_from[producer] = round(max(start_s, starts_from.get(producer, 0.0)), 3)
    times = windows(spans, order.orderings, _ends_by(due.values()), starts_from)
    ranked = sorted(range(end), key=lambda position: (times.earliest[position], position))
    rank = {position: number for number, position in enumerate([*ranked, end], start=1)}
    names = {position: f"a{number}" for position, number in rank.items()}
    names |= {FROM_START: INITIAL, end: GOAL}
    return PlanNet(
        goals=tuple(goals),
        actions=tuple(
            replace(
                _action(names[p], order.actions[p], times.earliest[p], times.latest[p], knowledge_base),
                not_before_s=starts_from.get(p, 0.0),
            )
            for p in ranked
        ),
        causal_links=tuple(
            CausalLink(producer=names[link.producer], fact=link.fact, consumer=names[link.consumer])
            for link in sorted(order.links, key=lambda link: (rank[link.consumer], link.producer, link.fact))
        ),
        orderings=tuple(
            Ordering(before=names[before], after=names[after], reason=order.orderings[before, after])
            for before, after in sorted(order.orderings, key=lambda pair: (rank[pair[0]], rank[pair[1]]))
        ),
        recruitment=dict(sorted(recruitment.items())),
        late={
            goal: late_s
            for goal, (producer, end_s) in due.items()
            if (late_s := round(times.earliest[producer] + spans[producer] - end_s, 3)) > 0
        },
    )


def _ends_by(due: Iterable[tuple[int, float]]) -> dict[int, float]:
    """By when each achiever must end: the earliest deadline of what it achieves."""
    ends: dict[int, float] = {}
    for producer, end_s in due:
        ends[producer] = min(ends.get(producer, end_s), end_s)
    return ends


def _action(
    action_id: str, action: GroundAction, earliest: float, latest: float, knowledge_base: KnowledgeBase
) -> PlanNetAction:
    times = {"time1": f"{earliest:.0f} s", "time2": f"{earliest + action.duration_s:.0f} s"}
    template = knowledge_base.actions[action.tag].description
    if action.phase:
        template += f" (phase {action.phase} of {action.phases})"
    return PlanNetAction(
        **{slot.name: getattr(action, slot.name) for slot in fields(GroundAction)},
        id=action_id,
        earliest_start_s=earliest,
        latest_start_s=latest,
        description=template.format(**{**action.arguments, **times}),
    )
