"""What makes the makespan: the critical path in words, and where robots wait for one another."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

from planner.explanation.ordering import Reasons
from planner.knowledge.phrases import enumeration
from planner.plan_nets.plan_net import ROUNDING_S, Ordering, PlanNet, PlanNetAction


@dataclass(frozen=True, slots=True, kw_only=True)
class Wait:
    """A robot stands idle before an action, at earliest starts, until another action has ended."""

    robot: str
    action: str
    awaited: str
    from_s: float
    span_s: float
    words: str


def waits(plan_net: PlanNet, names: Mapping[str, str], reasons: Reasons) -> tuple[Wait, ...]:
    """Where robots wait, the longest first."""
    binding = _binding(plan_net)
    found = [
        _wait(robot, action, since_s, binding[action.id], names, reasons)
        for robot in plan_net.robots
        for action, since_s in _gaps(plan_net.of_robot(robot))
        if action.id in binding
    ]
    return tuple(sorted(found, key=lambda wait: (-wait.span_s, wait.from_s, wait.robot)))


def makespan(plan_net: PlanNet, names: Mapping[str, str], reasons: Reasons) -> tuple[str, ...]:
    """The critical path, a sentence for what the same robots do one after the other."""
    path = [plan_net.action(action_id) for action_id in plan_net.critical_path]
    between = {(ordering.before, ordering.after): ordering for ordering in plan_net.orderings}
    return tuple(_legs(path, between, names, reasons))


def _legs(
    path: Sequence[PlanNetAction],
    between: Mapping[tuple[str, str], Ordering],
    names: Mapping[str, str],
    reasons: Reasons,
) -> Iterator[str]:
    last: PlanNetAction | None = None
    for agents, group in groupby(path, key=lambda action: action.agents):
        leg = list(group)
        ordering = between.get((last.id, leg[0].id)) if last is not None else None
        why = f"; it begins then, as {reasons.why(ordering)}" if ordering else ""
        span = f"{leg[0].earliest_start_s:.1f} to {leg[-1].earliest_end_s:.1f} s"
        doing = enumeration([names[action.id] for action in leg], most=len(leg))
        yield f"{span}: {enumeration(agents)} with {doing}{why}"
        last = leg[-1]


def _gaps(actions: Sequence[PlanNetAction]) -> Iterator[tuple[PlanNetAction, float]]:
    """A robot's actions that do not begin at once, and since when it is idle."""
    if actions and actions[0].earliest_start_s > ROUNDING_S:
        yield actions[0], 0.0
    for one, other in pairwise(actions):
        if other.earliest_start_s > one.earliest_end_s + ROUNDING_S:
            yield other, one.earliest_end_s


def _binding(plan_net: PlanNet) -> dict[str, Ordering]:
    """For each action the ordering that determines its earliest start."""
    ends_s = {action.id: action.earliest_end_s for action in plan_net.actions}
    binding: dict[str, Ordering] = {}
    for ordering in plan_net.orderings:
        known = binding.get(ordering.after)
        if known is None or ends_s[ordering.before] > ends_s[known.before]:
            binding[ordering.after] = ordering
    return binding


def _wait(
    robot: str,
    action: PlanNetAction,
    since_s: float,
    ordering: Ordering,
    names: Mapping[str, str],
    reasons: Reasons,
) -> Wait:
    span_s = round(action.earliest_start_s - since_s, 3)
    words = f"{robot} waits {span_s:.1f} s before {names[action.id]}: {reasons.why(ordering)}"
    return Wait(
        robot=robot,
        action=action.id,
        awaited=ordering.before,
        from_s=round(since_s, 3),
        span_s=span_s,
        words=words,
    )
