"""Checks plan-nets by carrying them out in time; shares no code with the planner's own validation.

Semantics (planner/plan_nets/plan_net.py): pre-conditions hold from an action's start to its end except those it
deletes itself, deletes happen at its start, effects at its end; what ends at a time comes before what starts then.
"""

import random
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence

from planner import Fact, GroundAction, KnowledgeBase, PlanNet, PlanNetAction, PlanningProblem

ROUNDING_S = 0.002


Action = GroundAction | PlanNetAction
Timed = tuple[float, float, Action]
"""Start, end and what is done between them."""


def fault_in_time(timed: Sequence[Timed], problem: PlanningProblem) -> str | None:
    """What goes wrong when the actions are carried out at these times, or None if the goals are achieved."""
    # What takes no time starts and ends where it stands among those that start then.
    events = [(start, 1, number, 0, act) for number, (start, _, act) in enumerate(timed)]
    events += [
        (end, 0, number, 1, act) if end > start else (start, 1, number, 1, act)
        for number, (start, end, act) in enumerate(timed)
    ]
    state = set(problem.facts)
    achieved = set(problem.facts)
    needed: Counter[Fact] = Counter()
    busy: set[str] = set()
    for time_s, _, _, ends, act in sorted(events, key=lambda event: event[:4]):
        held = set(act.preconditions) - set(act.deletes)
        if ends:
            needed.subtract(held)
            busy.difference_update(act.agents)
            state.update(act.intended_effects, act.other_effects)
            achieved.update(act.intended_effects)
            continue
        said = f"{act.tag}({', '.join(act.arguments.values())}) at {time_s:.1f} s"
        if missing := [fact for fact in act.preconditions if fact not in state]:
            return f"{said} needs {missing[0]}"
        if spoilt := [fact for fact in act.deletes if needed[fact] > 0]:
            return f"{said} deletes {spoilt[0]}, which is needed meanwhile"
        if taken := busy & set(act.agents):
            return f"{said} finds {', '.join(taken)} busy"
        needed.update(held)
        busy.update(act.agents)
        state.difference_update(act.deletes)
        achieved.difference_update(act.deletes)
    return next((f"{goal} is not achieved" for goal in problem.goals if goal not in achieved), None)


def fault_of(
    plan_net: PlanNet, problem: PlanningProblem, knowledge_base: KnowledgeBase, *, executions: int = 20
) -> str | None:
    """What is wrong with a plan-net, or None: its actions are those of the knowledge base, its windows keep its
    orderings, and it works at its earliest and latest times and whenever actions take shorter or longer."""
    for action in plan_net.actions:
        whole = knowledge_base.ground(
            action.tag, action.arguments, problem.functions, objects=problem.objects
        )
        known = knowledge_base.phase_of(whole, action.phase) if action.phase else whole
        slots = ("preconditions", "deletes", "intended_effects", "other_effects", "agents", "duration_s")
        if wrong := [slot for slot in slots if getattr(known, slot) != getattr(action, slot)]:
            return f"{action.id} {action.tag} has not the knowledge base's {wrong[0]}"
    chance = random.Random(0)
    spans = {action.id: action.duration_s for action in plan_net.actions}
    starts = [
        {action.id: action.earliest_start_s for action in plan_net.actions},
        {action.id: action.latest_start_s for action in plan_net.actions},
    ]
    trials = [(start, spans) for start in starts]
    for _ in range(executions):
        drawn = {name: span * chance.choice((0.2, 0.7, 1.0, 1.5, 5.0)) for name, span in spans.items()}
        trials.append((_as_soon_as_possible(plan_net, drawn), drawn))
    for start, taking in trials:
        if (late := _unkept(plan_net, start, taking)) is not None:
            return late
        # Orderings hold up to the rounding, so ends are that much earlier here.
        timed: list[Timed] = [
            (start[action.id], start[action.id] + taking[action.id] - ROUNDING_S, action)
            for action in plan_net.actions
        ]
        if (fault := fault_in_time(timed, problem)) is not None:
            return fault
    return None


def _edges(plan_net: PlanNet) -> Sequence[tuple[str, str]]:
    return [(ordering.before, ordering.after) for ordering in plan_net.orderings]


def _as_soon_as_possible(plan_net: PlanNet, spans: Mapping[str, float]) -> dict[str, float]:
    before: dict[str, list[str]] = defaultdict(list)
    for one, other in _edges(plan_net):
        before[other].append(one)
    start: dict[str, float] = {}
    for action in sorted(plan_net.actions, key=lambda action: (action.earliest_start_s, int(action.id[1:]))):
        start[action.id] = max((start[one] + spans[one] for one in before[action.id]), default=0.0)
    return start


def _unkept(plan_net: PlanNet, start: Mapping[str, float], spans: Mapping[str, float]) -> str | None:
    for one, other in _edges(plan_net):
        if start[one] + spans[one] > start[other] + ROUNDING_S:
            return f"{other} starts before {one} has ended"
    return None
