"""From a partial order to the plan-net: earliest and latest starts by longest path, ids, descriptions."""

from collections.abc import Mapping, Sequence

from planner.extraction import FROM_START, PartialOrder
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_net import GOAL, INITIAL, CausalLink, Ordering, PlanNet, PlanNetAction


def assemble(
    order: PartialOrder, goals: Sequence[Fact], knowledge_base: KnowledgeBase, recruitment: Mapping[str, str]
) -> PlanNet:
    """The scheduled plan-net; actions are called a1, a2, … in the order of their earliest start."""
    earliest, latest = schedule(order)
    ranked = sorted(range(len(order.actions)), key=lambda position: (earliest[position], position))
    ids = {position: f"a{rank}" for rank, position in enumerate(ranked, start=1)}
    ends = {FROM_START: INITIAL, len(order.actions): GOAL}
    return PlanNet(
        goals=tuple(goals),
        actions=tuple(
            _action(ids[p], order.actions[p], earliest[p], latest[p], knowledge_base) for p in ranked
        ),
        causal_links=tuple(
            CausalLink(
                producer=(ids | ends)[link.producer], fact=link.fact, consumer=(ids | ends)[link.consumer]
            )
            for link in sorted(
                order.links, key=lambda link: (_rank(link.consumer, ids), link.producer, link.fact)
            )
        ),
        orderings=tuple(
            Ordering(before=ids[before], after=ids[after], reason=reason)
            for (before, after), reason in sorted(
                order.orderings.items(), key=lambda item: (_rank(item[0][0], ids), _rank(item[0][1], ids))
            )
        ),
        recruitment=dict(sorted(recruitment.items())),
    )


def schedule(order: PartialOrder) -> tuple[list[float], list[float]]:
    """Earliest and latest starts by position, seconds; latest such that the makespan stays as it is."""
    count = len(order.actions)
    spans = [action.duration_s for action in order.actions]
    before: list[list[int]] = [[] for _ in range(count)]
    after: list[list[int]] = [[] for _ in range(count)]
    for one, other in order.orderings:
        before[other].append(one)
        after[one].append(other)
    # The order is a sub-order of the positions, so ascending positions are a topological order.
    earliest = [0.0] * count
    for position in range(count):
        earliest[position] = max((earliest[p] + spans[p] for p in before[position]), default=0.0)
    makespan = max((start + span for start, span in zip(earliest, spans, strict=True)), default=0.0)
    latest = [0.0] * count
    for position in reversed(range(count)):
        latest[position] = min((latest[p] for p in after[position]), default=makespan) - spans[position]
    return [round(start, 3) for start in earliest], [
        round(max(early, late), 3) for early, late in zip(earliest, latest, strict=True)
    ]


def _rank(position: int, ids: Mapping[int, str]) -> int:
    return int(ids[position][1:]) if position in ids else len(ids) + 1


def _action(
    action_id: str, action: GroundAction, earliest: float, latest: float, knowledge_base: KnowledgeBase
) -> PlanNetAction:
    times = {"time1": f"{earliest:.0f} s", "time2": f"{earliest + action.duration_s:.0f} s"}
    template = knowledge_base.actions[action.tag].description
    return PlanNetAction(
        id=action_id,
        tag=action.tag,
        arguments=dict(action.arguments),
        agents=action.agents,
        preconditions=action.preconditions,
        deletes=action.deletes,
        intended_effects=action.intended_effects,
        other_effects=action.other_effects,
        duration_s=action.duration_s,
        earliest_start_s=earliest,
        latest_start_s=latest,
        description=template.format(**{**action.arguments, **times}),
    )
