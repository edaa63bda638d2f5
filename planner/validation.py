"""Checks on a plan-net that rest on nothing but the plan-net itself and the facts it starts from."""

from collections.abc import Iterable

from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.plan_net import GOAL, INITIAL, CausalLink, PlanNet, PlanNetAction

ROUNDING_S = 0.01


def faults_of(plan_net: PlanNet, facts: frozenset[Fact], knowledge_base: KnowledgeBase) -> list[str]:
    """Everything wrong with the plan-net; empty for a valid one."""
    try:
        beyond = successors(plan_net)
    except ValueError as error:
        return [str(error)]
    return [
        *_support_faults(plan_net, facts),
        *_threat_faults(plan_net, beyond),
        *_resource_faults(plan_net, beyond),
        *_schedule_faults(plan_net),
        *unintended(plan_net, knowledge_base),
        *([fault] if (fault := replay(plan_net, linearisation(plan_net), facts)) else []),
    ]


def successors(plan_net: PlanNet) -> dict[str, frozenset[str]]:
    """For each action all that come after it.

    :raises ValueError: if the orderings are cyclic.
    """
    direct: dict[str, set[str]] = {action.id: set() for action in plan_net.actions}
    for ordering in plan_net.orderings:
        direct[ordering.before].add(ordering.after)
    for link in plan_net.causal_links:
        if link.producer != INITIAL and link.consumer != GOAL:
            direct[link.producer].add(link.consumer)
    beyond: dict[str, frozenset[str]] = {}
    waiting = set(direct)
    while waiting:
        ready = sorted(node for node in waiting if direct[node] <= beyond.keys())
        if not ready:
            raise ValueError(f"the orderings are cyclic among {', '.join(sorted(waiting))}")
        for node in ready:
            beyond[node] = frozenset(direct[node].union(*(beyond[after] for after in direct[node])))
        waiting -= set(ready)
    return beyond


def linearisation(plan_net: PlanNet) -> tuple[PlanNetAction, ...]:
    """The actions by earliest start."""
    return tuple(sorted(plan_net.actions, key=lambda action: (action.earliest_start_s, int(action.id[1:]))))


def replay(plan_net: PlanNet, sequence: Iterable[PlanNetAction], facts: frozenset[Fact]) -> str | None:
    """Carry the actions out in this order; what goes wrong, or None if every goal holds at the end."""
    state = set(facts)
    for action in sequence:
        missing = [fact for fact in action.preconditions if fact not in state]
        if missing:
            return f"{action.id} {action.tag} needs {missing[0]}, which does not hold"
        state.difference_update(action.deletes)
        state.update(action.effects)
    return next((f"the goal {goal} is not reached" for goal in plan_net.goals if goal not in state), None)


def _support_faults(plan_net: PlanNet, facts: frozenset[Fact]) -> list[str]:
    """Each condition has exactly one link, from something that brings it about; goals from intended effects
    only."""
    actions = {action.id: action for action in plan_net.actions}
    supported = [(link.consumer, link.fact) for link in plan_net.causal_links]
    needed = [(action.id, fact) for action in plan_net.actions for fact in action.preconditions]
    needed += [(GOAL, goal) for goal in dict.fromkeys(plan_net.goals)]
    faults = [
        f"{fact} of {consumer} has {supported.count((consumer, fact))} links"
        for consumer, fact in needed
        if supported.count((consumer, fact)) != 1
    ]
    for link in plan_net.causal_links:
        if not _produces(link, actions.get(link.producer), facts):
            faults.append(f"{link.producer} does not bring about {link.fact} for {link.consumer}")
    return faults


def _produces(link: CausalLink, producer: PlanNetAction | None, facts: frozenset[Fact]) -> bool:
    if producer is None:
        return link.producer == INITIAL and link.fact in facts
    return link.fact in (producer.intended_effects if link.consumer == GOAL else producer.effects)


def _threat_faults(plan_net: PlanNet, beyond: dict[str, frozenset[str]]) -> list[str]:
    """No action that deletes a link's fact can come between its producer and its consumer."""
    faults = []
    for link in plan_net.causal_links:
        for action in plan_net.actions:
            if link.fact not in action.deletes or action.id in (link.producer, link.consumer):
                continue
            earlier = link.producer in beyond[action.id]
            later = link.consumer != GOAL and action.id in beyond[link.consumer]
            if not earlier and not later:
                faults.append(f"{action.id} threatens {link.fact} from {link.producer} to {link.consumer}")
    return faults


def _resource_faults(plan_net: PlanNet, beyond: dict[str, frozenset[str]]) -> list[str]:
    """The actions of one robot are totally ordered."""
    return [
        f"{one.id} and {other.id} both use {agent} and are not ordered"
        for index, one in enumerate(plan_net.actions)
        for other in plan_net.actions[index + 1 :]
        for agent in sorted(set(one.agents) & set(other.agents))
        if other.id not in beyond[one.id] and one.id not in beyond[other.id]
    ]


def _schedule_faults(plan_net: PlanNet) -> list[str]:
    """Earliest and latest starts keep every ordering, and every action has its latest start after its
    earliest."""
    faults = [f"{a.id} has its latest start before its earliest" for a in plan_net.actions if a.slack_s < 0]
    for ordering in plan_net.orderings:
        one, other = plan_net.action(ordering.before), plan_net.action(ordering.after)
        if one.earliest_end_s > other.earliest_start_s + ROUNDING_S:
            faults.append(f"{one.id} ends after {other.id} starts")
        if one.latest_start_s + one.duration_s > other.latest_start_s + ROUNDING_S:
            faults.append(f"{one.id} may end after {other.id} must start")
    return faults


def unintended(plan_net: PlanNet, knowledge_base: KnowledgeBase) -> list[str]:
    """The actions that are there for no intended effect of their own and do not make way.

    Table 3: other effects are not what a planner chooses an action for.
    """
    faults = []
    for action in plan_net.actions:
        used = [link.fact for link in plan_net.causal_links if link.producer == action.id]
        chosen_for = action.intended_effects
        if not any(fact in chosen_for or knowledge_base.predicates[fact.predicate].make_way for fact in used):
            what = ", ".join(map(str, used)) or "nothing"
            faults.append(
                f"{action.id} {action.tag} would be there only for {what}, which it does not intend"
            )
    return faults
