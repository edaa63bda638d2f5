"""Synchronises robots by their own order of actions, by what they sense, and by clearance from the organiser.

Every robot carries out its own actions in order and knows nothing of the others. Three things can keep an
ordering A → B all the same. (1) A is the previous action of the robot that does B. (2) A brings about a fact
that B needs and its robot can sense: it awaits the fact. (3) Clearance: the organiser tells the robot that A
has ended, as reported by A's robots.

Sensing alone is not enough where the awaited fact may be true before A has ended: a place is clear at first,
then taken, then clear again. Let E be what is enforced in every execution so far ("ended before the start
of"). When the robot starts B, f being true, the last thing that happened to f was the end of a producer X, or
nothing since the initial state. It was the end of A, and A → B joins E, if every other X is ruled out:

- X ends later: E holds B → X; or X implies A: E holds A → X;
- f was deleted in between: for some deleter D, E holds X → D and D → B (the initial state precedes every D).

Each step needs only what E holds already, so E grows from the robots' own orders and the clearances to a
least fixpoint, and every execution obeys it, by induction on the steps. Once every ordering of the plan-net is
in E, every execution is a linearisation of the plan-net: being threat-free it is safe, and being acyclic it
never comes to a standstill, for whatever a robot awaits comes to hold and lasts.

A robot senses only what its `senses` name. For one that senses nothing every ordering on another is a clearance.

Robots that act together start their parts each by itself: an action deletes when its first robot starts and
has its effects when its last one ends. Hence E is kept between parts.
"""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.plan_nets.plan_net import (
    GOAL,
    INITIAL,
    Keeping,
    Ordering,
    OrderingReason,
    PlanNet,
    PlanNetAction,
    Senses,
)
from planner.plan_nets.validation import linearisation

Part = tuple[str, str]
"""What one robot does of an action: action id, robot."""


def awaits_of(
    plan_net: PlanNet, objects: Mapping[str, str], knowledge_base: KnowledgeBase
) -> dict[Part, tuple[Fact, ...]]:
    """The facts each robot is to sense before it starts: those it can, of what others bring about for it.

    What a robot can sense is what the plan-net's `senses` say, so this is what its orderings rely on.
    """
    return {
        part: tuple(dict.fromkeys(fact for fact, _ in found))
        for part, found in _sensed_links(plan_net, objects, knowledge_base).items()
    }


def keep_in_step(
    plan_net: PlanNet,
    facts: frozenset[Fact],
    objects: Mapping[str, str],
    knowledge_base: KnowledgeBase,
    senses: Senses | None = None,
) -> PlanNet:
    """The plan-net with what keeps each ordering: sensing wherever that suffices, clearance for the rest.

    Causal links that no ordering implies become orderings. Clearance keeps any ordering, so there is always a way.

    :param plan_net: one without faults; `facts` are those it starts from, `objects` their objects' types.
    :param senses: what robots perceive; None: as the plan-net says.
    """
    told = plan_net.senses if senses is None else senses
    plan_net = replace(plan_net, senses={name: told[name] for name in plan_net.robots if name in told})
    links = _sensed_links(plan_net, objects, knowledge_base)
    ideal, enforced = (_Enforced(plan_net, facts, links) for _ in range(2))
    ideal.clear(*plan_net.orderings)
    orderings = (*plan_net.orderings, *_implied_by_none(plan_net, ideal))
    ideal.clear(*orderings)
    cleared = {ordering for ordering in orderings if not ideal.is_followed(ordering)}
    enforced.clear(*cleared)
    # The rest depend on each other in a circle: one clearance may make sensing suffice for several.
    while (unkept := next((o for o in orderings if not enforced.keeps(o)), None)) is not None:
        cleared.add(unkept)
        enforced.clear(unkept)
    agents = {action.id: action.agents for action in plan_net.actions}

    def keeping(ordering: Ordering) -> Keeping:
        if ordering in cleared:
            return Keeping.CLEARANCE
        before = agents[ordering.before]
        after = agents[ordering.after]
        return Keeping.ROBOT if before == after and len(before) == 1 else Keeping.SENSING

    return replace(plan_net, orderings=tuple(replace(o, kept_by=keeping(o)) for o in orderings))


def _implied_by_none(plan_net: PlanNet, enforced: "_Enforced") -> list[Ordering]:
    """The orderings of causal links that are not enforced yet."""
    pairs = {
        (link.producer, link.consumer): Ordering(
            before=link.producer, after=link.consumer, reason=OrderingReason.CAUSAL
        )
        for link in plan_net.causal_links
        if link.producer != INITIAL and link.consumer != GOAL
    }
    return [ordering for ordering in pairs.values() if not enforced.keeps(ordering)]


_Links = Mapping[Part, list[tuple[Fact, str]]]


def _sensed_links(plan_net: PlanNet, objects: Mapping[str, str], knowledge_base: KnowledgeBase) -> _Links:
    """For each part the facts its robot can sense, with their producers, unless the robot alone does these.

    Where it does them with others, sensing the fact shows that the others have ended their parts, too.
    """
    actions = {action.id: action for action in plan_net.actions}
    found: dict[Part, list[tuple[Fact, str]]] = defaultdict(list)
    for link in plan_net.causal_links:
        if link.producer == INITIAL or link.consumer == GOAL:
            continue
        consumer = actions[link.consumer]
        if consumer.tag in knowledge_base.operations:  # a door senses nothing but itself
            continue
        # A fact that the first robot to start deletes would keep its partners waiting for ever.
        gone = len(consumer.agents) > 1 and link.fact in consumer.deletes
        for robot in consumer.agents if not gone else ():
            words = plan_net.senses.get(robot)
            if actions[link.producer].agents != (robot,) and knowledge_base.is_sensed(
                link.fact, objects, words
            ):
                found[link.consumer, robot].append((link.fact, link.producer))
    return found


class _Enforced:
    """The relation E on parts, as bit sets; a part's bit is its rank in a linearisation, so E goes upwards."""

    def __init__(self, plan_net: PlanNet, facts: frozenset[Fact], links: _Links) -> None:
        ranked = linearisation(plan_net)
        self._agents = {action.id: action.agents for action in ranked}
        self._parts = [(action.id, robot) for action in ranked for robot in action.agents]
        self._rank = {part: rank for rank, part in enumerate(self._parts)}
        self._whole = {a.id: sum(1 << self._rank[a.id, robot] for robot in a.agents) for a in ranked}
        self._facts = facts
        self._links = links
        self._followed: set[tuple[str, Part]] = set()
        self._before: list[set[int]] = [set() for _ in self._parts]
        for robot in plan_net.robots:
            for one, other in pairwise(a for a in ranked if robot in a.agents):
                self._before[self._rank[other.id, robot]].add(self._rank[one.id, robot])
        self._producers: dict[Fact, int] = defaultdict(int)
        self._deleters: dict[Fact, int] = defaultdict(int)
        self._note_changes(ranked)
        self._ended = [0] * len(self._parts)
        self._later = [0] * len(self._parts)

    def _note_changes(self, actions: tuple[PlanNetAction, ...]) -> None:
        for action in actions:
            for fact in action.effects:
                self._producers[fact] |= self._whole[action.id]
            for fact in action.deletes:
                self._deleters[fact] |= self._whole[action.id]

    def clear(self, *orderings: Ordering) -> None:
        """Enforce orderings by clearance, and all that sensing keeps then."""
        for ordering in orderings:
            for robot in self._agents[ordering.after]:
                self._follow(ordering.before, (ordering.after, robot))
        while self._grow():
            pass

    def keeps(self, ordering: Ordering) -> bool:
        """True if E holds the ordering."""
        ranks = self._ranks(ordering.after)
        return not any(self._whole[ordering.before] & ~self._ended[rank] for rank in ranks)

    def is_followed(self, ordering: Ordering) -> bool:
        """True if the robot's own order or sensing keeps the ordering directly."""
        before = self._agents[ordering.before]
        return all(
            before == (robot,) or (ordering.before, (ordering.after, robot)) in self._followed
            for robot in self._agents[ordering.after]
        )

    def _grow(self) -> bool:
        """One pass over the parts in order; True if E has grown."""
        grown = False
        for rank, part in enumerate(self._parts):
            self._ended[rank] = self._closed(rank)
            for fact, producer in self._links.get(part, ()):
                if (producer, part) not in self._followed and self._tells(fact, producer, rank):
                    self._followed.add((producer, part))
                    self._follow(producer, part)
                    self._ended[rank] = self._closed(rank)
                    grown = True
        later = [0] * len(self._parts)
        for rank in reversed(range(len(self._parts))):
            for before in self._before[rank]:
                later[before] |= 1 << rank | later[rank]
        grown = grown or later != self._later
        self._later = later
        return grown

    def _tells(self, fact: Fact, producer: str, rank: int) -> bool:
        """True if the fact, sensed when the part starts, can come from this producer only."""
        consumer, _ = self._parts[rank]
        deleted = self._deleters[fact] & self._closed(rank, without=producer)
        if fact in self._facts and not deleted:
            return False
        implying = self._all_of(self._later, producer) | self._later[rank]
        rivals = self._producers[fact] & ~(self._whole[producer] | self._whole[consumer] | implying)
        while rivals and deleted:
            latest = deleted.bit_length() - 1
            rivals &= ~self._all_of(self._ended, self._parts[latest][0])
            deleted ^= 1 << latest
        return not rivals

    def _follow(self, before: str, after: Part) -> None:
        self._before[self._rank[after]].update(self._ranks(before))

    def _closed(self, rank: int, without: str | None = None) -> int:
        """What has ended when the part starts; `without` an action that it directly follows."""
        ended = 0
        for before in self._before[rank]:
            if self._parts[before][0] != without:
                ended |= 1 << before | self._ended[before]
        return ended

    def _all_of(self, sets: list[int], action: str) -> int:
        """What all the action's parts have in common."""
        common = -1
        for rank in self._ranks(action):
            common &= sets[rank]
        return common

    def _ranks(self, action: str) -> list[int]:
        return [self._rank[action, robot] for robot in self._agents[action]]
