"""Validates a plan-net from nothing but itself, its initial facts and the knowledge base."""

from collections import Counter, defaultdict
from collections.abc import Mapping
from itertools import zip_longest

from planner.errors import CyclicOrder
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_nets.extraction import fault_of
from planner.plan_nets.orders import Orders
from planner.plan_nets.plan_net import GOAL, INITIAL, ROUNDING_S, CausalLink, PlanNet, PlanNetAction
from planner.plan_nets.precedence import Precedence, members


def faults_of(plan_net: PlanNet, facts: frozenset[Fact], knowledge_base: KnowledgeBase) -> list[str]:
    """Everything wrong with the plan-net; empty for a valid one."""
    number = {action.id: place for place, action in enumerate(plan_net.actions)}
    if unknown := sorted(_named(plan_net) - number.keys()):
        return [f"there is no action {name}" for name in unknown]
    try:
        precedence = precedence_of(plan_net, number)
    except CyclicOrder as error:
        among = sorted(plan_net.actions[place].id for place in error.nodes)
        return [f"the orderings are cyclic among {', '.join(among)}"]
    return [
        *_support_faults(plan_net, facts),
        *_threat_faults(plan_net, precedence, number),
        *_resource_faults(plan_net, precedence),
        *_phase_faults(plan_net),
        *_schedule_faults(plan_net),
        *too_early(plan_net),
        *unjustified(plan_net, knowledge_base),
        *([fault] if (fault := fault_of(linearisation(plan_net), facts, plan_net.goals)) else []),
    ]


def _named(plan_net: PlanNet) -> set[str]:
    """The actions that orderings and links speak of."""
    producers = {link.producer for link in plan_net.causal_links} - {INITIAL}
    consumers = {link.consumer for link in plan_net.causal_links} - {GOAL}
    return producers | consumers | {end for o in plan_net.orderings for end in (o.before, o.after)}


def precedence_of(plan_net: PlanNet, number: Mapping[str, int]) -> Precedence:
    """What comes before what, by orderings and causal links; `number`: each action's place in the plan-net.

    :raises CyclicOrder: if they contradict each other.
    """
    pairs = [(number[ordering.before], number[ordering.after]) for ordering in plan_net.orderings]
    pairs += [
        (number[link.producer], number[link.consumer])
        for link in plan_net.causal_links
        if link.producer != INITIAL and link.consumer != GOAL
    ]
    return Precedence.of(len(number), pairs)


def linearisation(plan_net: PlanNet) -> tuple[PlanNetAction, ...]:
    """The actions by earliest start."""
    return tuple(sorted(plan_net.actions, key=lambda action: (action.earliest_start_s, int(action.id[1:]))))


def sequence_of(plan_net: PlanNet) -> list[GroundAction]:
    """The actions by earliest start, without their times."""
    return [action.unscheduled() for action in linearisation(plan_net)]


def _support_faults(plan_net: PlanNet, facts: frozenset[Fact]) -> list[str]:
    """Each condition has exactly one link, from something that brings it about; goals from intended effects
    only."""
    actions = {action.id: action for action in plan_net.actions}
    links = Counter((link.consumer, link.fact) for link in plan_net.causal_links)
    needed = [(action.id, fact) for action in plan_net.actions for fact in action.preconditions]
    needed += [(GOAL, goal) for goal in dict.fromkeys(plan_net.goals)]
    faults = [
        f"{fact} of {consumer} has {links[consumer, fact]} links"
        for consumer, fact in needed
        if links[consumer, fact] != 1
    ]
    for link in plan_net.causal_links:
        if not _produces(link, actions.get(link.producer), facts):
            faults.append(f"{link.producer} does not bring about {link.fact} for {link.consumer}")
    return faults


def _produces(link: CausalLink, producer: PlanNetAction | None, facts: frozenset[Fact]) -> bool:
    if producer is None:
        return link.producer == INITIAL and link.fact in facts
    return link.fact in (producer.intended_effects if link.consumer == GOAL else producer.effects)


def _threat_faults(plan_net: PlanNet, precedence: Precedence, number: Mapping[str, int]) -> list[str]:
    """No action that deletes a link's fact can come between its producer and its consumer."""
    deleters: dict[Fact, int] = defaultdict(int)
    for place, action in enumerate(plan_net.actions):
        for fact in action.deletes:
            deleters[fact] |= 1 << place
    faults = []
    for link in plan_net.causal_links:
        threats = deleters.get(link.fact, 0)
        if threats and link.producer != INITIAL:
            producer = number[link.producer]
            threats &= ~(precedence.before[producer] | 1 << producer)
        if threats and link.consumer != GOAL:
            consumer = number[link.consumer]
            threats &= ~(precedence.after[consumer] | 1 << consumer)
        for place in members(threats):
            threat = plan_net.actions[place].id
            faults.append(f"{threat} threatens {link.fact} from {link.producer} to {link.consumer}")
    return faults


def _resource_faults(plan_net: PlanNet, precedence: Precedence) -> list[str]:
    """The actions of one robot are totally ordered."""
    using: dict[str, int] = defaultdict(int)
    for place, action in enumerate(plan_net.actions):
        for agent in action.agents:
            using[agent] |= 1 << place
    return [
        f"{action.id} and {plan_net.actions[other].id} both use {agent} and are not ordered"
        for place, action in enumerate(plan_net.actions)
        for agent in action.agents
        for other in members(using[agent] & ~(precedence.before[place] | precedence.after[place]))
        if other > place
    ]


def _phase_faults(plan_net: PlanNet) -> list[str]:
    """After a phase of an action its robot does the next one."""
    faults = []
    for robot in plan_net.robots if any(action.phase for action in plan_net.actions) else ():
        mine = plan_net.of_robot(robot)
        for one, other in zip_longest(mine, mine[1:]):
            if one.phase < one.phases and (other is None or other.follows not in one.intended_effects):
                faults.append(f"{robot} begins {one.tag} with {one.id} and does not end it")
    return faults


def _schedule_faults(plan_net: PlanNet) -> list[str]:
    """Earliest and latest starts keep every ordering, and every action has its latest start after its
    earliest."""
    actions = {action.id: action for action in plan_net.actions}
    faults = [f"{a.id} has its latest start before its earliest" for a in plan_net.actions if a.slack_s < 0]
    faults += [
        f"{a.id} starts before {a.not_before_s:g} s"
        for a in plan_net.actions
        if a.earliest_start_s < a.not_before_s - ROUNDING_S
    ]
    for ordering in plan_net.orderings:
        one = actions[ordering.before]
        other = actions[ordering.after]
        if one.earliest_end_s > other.earliest_start_s + ROUNDING_S:
            faults.append(f"{one.id} ends after {other.id} starts")
        if one.latest_start_s + one.duration_s > other.latest_start_s + ROUNDING_S:
            faults.append(f"{one.id} may end after {other.id} must start")
    return faults


def too_early(plan_net: PlanNet) -> list[str]:
    """No other action brings about a goal that is not to be true before a time."""
    actions = {action.id: action for action in plan_net.actions}
    achieved = {link.fact: link.producer for link in plan_net.causal_links if link.consumer == GOAL}
    waited_for = {
        fact: producer
        for fact, producer in achieved.items()
        if producer != INITIAL and actions[producer].not_before_s > 0
    }
    return [
        f"{action.id} brings about {fact} before {waited_for[fact]} may"
        for action in plan_net.actions
        for fact in action.effects
        if waited_for.get(fact, action.id) != action.id
    ]


def broken_orders(plan_net: PlanNet, after: Orders) -> list[tuple[Fact, Fact]]:
    """The goals that may come true before one after which they are to, each with that one.

    :raises CyclicOrder: if the plan-net's orderings contradict each other.
    """
    if not after:
        return []
    number = {action.id: place for place, action in enumerate(plan_net.actions)}
    achieved = {link.fact: link.producer for link in plan_net.causal_links if link.consumer == GOAL}
    precedence = precedence_of(plan_net, number)
    return [
        (goal, before)
        for goal, earlier in after.items()
        if achieved.get(goal, INITIAL) != INITIAL
        for before in sorted(earlier)
        if achieved.get(before, INITIAL) != INITIAL
        for action in plan_net.actions
        if goal in action.effects
        and not action.under_way
        and not precedence.before[number[action.id]] >> number[achieved[before]] & 1
    ]


def unjustified(plan_net: PlanNet, knowledge_base: KnowledgeBase) -> list[str]:
    """The actions that are there for no intended effect of their own and do not make way, in words.

    Table 3: other effects are not what a planner chooses an action for. What is under way is no longer chosen.
    """
    return [
        f"{action.id} {action.tag} would be there only for {', '.join(map(str, used)) or 'nothing'}, "
        "which it does not intend"
        for action, used in unjustified_actions(plan_net, knowledge_base)
    ]


def unjustified_actions(
    plan_net: PlanNet, knowledge_base: KnowledgeBase
) -> list[tuple[PlanNetAction, list[Fact]]]:
    """The actions there for no intended effect of their own and not to make way, and what they are used for."""
    uses: dict[str, list[Fact]] = defaultdict(list)
    for link in plan_net.causal_links:
        uses[link.producer].append(link.fact)

    def is_meant(action: PlanNetAction) -> bool:
        return action.is_kept or any(
            fact in action.intended_effects or knowledge_base.predicates[fact.predicate].make_way
            for fact in uses[action.id]
            if fact.predicate not in knowledge_base.under_way
        )

    found = [chain for chain in _chains(plan_net) if not any(map(is_meant, chain))]
    return [
        (chain[-1], [fact for action in chain for fact in uses[action.id] if not _is_own(fact, chain)])
        for chain in found
    ]


def _chains(plan_net: PlanNet) -> list[list[PlanNetAction]]:
    """The actions, the phases of one together; those without the first of them, which has ended, are left out."""
    chains: list[list[PlanNetAction]] = []
    open_chains: dict[str, list[PlanNetAction]] = {}
    for action in linearisation(plan_net):
        if action.phase > 1:
            if action.agents[0] in open_chains:
                open_chains[action.agents[0]].append(action)
            continue
        chains.append([action])
        if action.phase:
            open_chains[action.agents[0]] = chains[-1]
    return chains


def _is_own(fact: Fact, chain: list[PlanNetAction]) -> bool:
    """True for what holds between two phases of the chain."""
    return any(fact == action.follows for action in chain)
