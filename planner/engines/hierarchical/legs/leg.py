"""Legs: the parts of a fragment that agents carry out without interruption, excluding the way there.

A fragment says which agent does what from its present position. The actions that only bring an agent into place (its
*setup*) depend on what it did before, so a leg keeps the rest, its *core*, and the configuration in which each agent
starts it. An agent's *configuration* is the set of fluent facts that name it, no other agent and none of the *things*,
which are moved or worked on (objects that no static fact or function names).
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.knowledge.operator import TEAM_SEPARATOR
from planner.problem.interface import PlanningProblem
from planner.problem.robot_classes import AgentClasses
from planner.problem.static_facts import StaticFacts

Configuration = frozenset[Fact]
SHORTER = 0.01
"""Of a distance: less is rounding."""


def _is_shorter_by_a_third(values: Mapping[tuple[str, str], float]) -> bool:
    """Whether the values from some object to a third one and on to another are less than that between the two."""
    number = {name: n for n, name in enumerate(dict.fromkeys(name for pair in values for name in pair))}
    table = np.full((len(number), len(number)), np.inf, np.float32)
    for (one, other), value in values.items():
        table[number[one], number[other]] = value
    np.fill_diagonal(table, np.inf)
    is_known = np.isfinite(table)
    longest = np.where(is_known, table - SHORTER, -np.inf)
    for third in range(len(number)):
        before, after = np.flatnonzero(is_known[:, third]), np.flatnonzero(is_known[third])
        by_third = np.add.outer(table[before, third], table[third, after])
        if (by_third < longest[np.ix_(before, after)]).any():
            return True
    return False


class ClassifiedProblem:
    """A problem with its agents' classes, its facts (configurations of agents, other fluents) and its objects (agents,
    things) classified."""

    def __init__(self, knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
        self.knowledge_base = knowledge_base
        self.problem = problem
        self.classes = AgentClasses(knowledge_base, problem)
        self.agents = frozenset(self.classes.agents)
        self.fluents = knowledge_base.fluents
        self.static_facts = StaticFacts(knowledge_base, problem)
        self.statics = self.static_facts.facts
        self.things = self.static_facts.things
        self._is_configuration: dict[Fact, bool] = {}

    @cached_property
    def detours_pay(self) -> bool:
        """True if it is nearer somewhere to go by a third place: the distances are not all those of straight ways."""
        tables: dict[str, dict[tuple[str, str], float]] = defaultdict(dict)
        for (name, args), value in self.problem.functions.items():
            if len(args) == 2:
                tables[name][args[0], args[1]] = value
        return any(map(_is_shorter_by_a_third, tables.values()))

    def agents_of(self, fact: Fact) -> frozenset[str]:
        return self.agents.intersection(fact.args)

    def is_fluent(self, fact: Fact) -> bool:
        return fact.predicate in self.fluents

    def is_configuration(self, fact: Fact) -> bool:
        known = self._is_configuration.get(fact)
        if known is None:
            known = self.is_fluent(fact) and len(self.agents_of(fact)) == 1
            known = self._is_configuration[fact] = known and self.things.isdisjoint(fact.args)
        return known

    def is_setup(self, action: GroundAction) -> bool:
        """True if the action only brings its one agent into another configuration."""
        return (
            len(action.agents) == 1
            and all(self.is_configuration(fact) for fact in action.intended_effects)
            and all(
                self.things.isdisjoint(fact.args) and self.agents_of(fact) <= {action.agents[0]}
                for fact in (*action.preconditions, *action.deletes, *action.effects)
                if self.is_fluent(fact)
            )
        )

    def configuration(self, agent: str, facts: Iterable[Fact]) -> Configuration:
        return frozenset(fact for fact in facts if agent in fact.args and self.is_configuration(fact))


@dataclass(frozen=True, slots=True, kw_only=True)
class Leg:
    """What these agents do without interruption, once each is in a configuration that has its `needs`.

    `roles` number the agents within the fragment: legs that share a role must have the same agent. A `bound`
    agent cannot be exchanged for another of its class.
    """

    agents: tuple[str, ...]
    needs: tuple[Configuration, ...]
    core: tuple[GroundAction, ...]
    roles: tuple[int, ...]
    bound: tuple[bool, ...]


def legs_of(
    actions: Sequence[GroundAction], goals: Sequence[Fact], classified: ClassifiedProblem
) -> tuple[Leg, ...]:
    """The legs of a fragment, in an order in which they can be carried out."""
    groups = [part for group in _groups(actions) for part in _parts(group, classified)]
    cores = [_core(group, classified) for group in groups]
    parts = [core for core in cores if core]
    bound = _bound_agents(parts, goals, classified)
    roles = _roles(parts, classified)
    legs = [
        Leg(
            agents=core[0].agents,
            needs=tuple(_need(agent, core, classified) for agent in core[0].agents),
            core=tuple(core),
            roles=roles[number],
            bound=tuple(agent in bound for agent in core[0].agents),
        )
        for number, core in enumerate(parts)
    ]
    return (*legs, *_postures(goals, legs, classified))


def _groups(actions: Sequence[GroundAction]) -> list[list[GroundAction]]:
    """Runs of actions by the same agents that need nothing of others that in turn needs the run's beginning."""
    groups: list[list[GroundAction]] = []
    before: list[set[int]] = []  # for each group those it comes after
    last: dict[tuple[str, ...], int] = {}
    producer: dict[Fact, int] = {}
    for action in actions:
        needed = {producer[fact] for fact in action.preconditions if fact in producer}
        needed |= {other for n in needed for other in before[n]}
        mine = last.get(action.agents)
        busy = any(
            last.get(agents, -1) > (mine if mine is not None else -1)
            for agents in last
            if agents != action.agents and set(agents) & set(action.agents)
        )
        if mine is None or busy or any(mine in before[n] for n in needed):
            mine = len(groups)
            groups.append([])
            before.append(set())
            last[action.agents] = mine
        groups[mine].append(action)
        before[mine] |= needed - {mine}
        for fact in action.effects:
            producer[fact] = mine
    return _in_order(groups, before)


def _parts(group: Sequence[GroundAction], classified: ClassifiedProblem) -> Iterator[Sequence[GroundAction]]:
    """The group split where other agents may act in between: where its agents release what they held, and where
    they stop on their way (two actions of one kind)."""
    begun = 0
    held = False
    made = set[Fact]()
    needed = [fact for action in group for fact in action.preconditions]
    for place in range(1, len(group)):
        before = group[place - 1]
        needed = needed[len(before.preconditions) :]
        made = made - set(before.deletes) | set(before.effects).intersection(_loose(before, classified))
        last = held
        held = not made.isdisjoint(needed)
        if (last and not held) or (held and before.tag == group[place].tag):
            yield group[begun:place]
            begun = place
    yield group[begun:]


def _in_order(groups: list[list[GroundAction]], before: list[set[int]]) -> list[list[GroundAction]]:
    ordered: list[int] = []
    waiting = list(range(len(groups)))
    while waiting:
        ready = next((g for g in waiting if before[g].issubset(ordered)), waiting[0])
        ordered.append(ready)
        waiting.remove(ready)
    return [groups[g] for g in ordered]


def _core(group: Sequence[GroundAction], classified: ClassifiedProblem) -> Sequence[GroundAction]:
    """The group without the setup it begins with."""
    first = next((n for n, action in enumerate(group) if not classified.is_setup(action)), len(group))
    return group[first:]


def _need(agent: str, core: Sequence[GroundAction], classified: ClassifiedProblem) -> Configuration:
    needed: set[Fact] = set()
    made: set[Fact] = set()
    for action in core:
        needed |= classified.configuration(agent, action.preconditions) - made
        made |= classified.configuration(agent, action.effects)
    return frozenset(needed)


def _loose(action: GroundAction, classified: ClassifiedProblem) -> Iterator[Fact]:
    """The fluent facts of an action that name agents but are no configuration."""
    for fact in (*action.preconditions, *action.deletes, *action.effects):
        if (
            classified.is_fluent(fact)
            and classified.agents_of(fact)
            and not classified.is_configuration(fact)
        ):
            yield fact


def _bound_agents(
    cores: Sequence[Sequence[GroundAction]], goals: Sequence[Fact], classified: ClassifiedProblem
) -> frozenset[str]:
    """Agents that goals name, that hold something already, that a fact names together with another or that work at
    places of their own."""
    bound = {agent for goal in goals for agent in classified.agents_of(goal)}
    for core in cores:
        for action in core:
            if not classified.classes.own.isdisjoint(action.arguments.values()):
                bound |= set(action.agents)
            for fact in _loose(action, classified):
                named = classified.agents_of(fact)
                if len(named) > 1 or fact in classified.problem.facts:
                    bound |= named
    return frozenset(bound)


def _roles(cores: Sequence[Sequence[GroundAction]], classified: ClassifiedProblem) -> list[tuple[int, ...]]:
    """Legs of one agent share a role if one leg needs a loose fact that the other brings about."""
    numbers: dict[object, int] = {}
    carried = _carried(cores, classified)
    return [
        tuple(
            numbers.setdefault(agent if agent in carried else (agent, number), len(numbers))
            for agent in core[0].agents
        )
        for number, core in enumerate(cores)
    ]


def _carried(cores: Sequence[Sequence[GroundAction]], classified: ClassifiedProblem) -> frozenset[str]:
    carried: set[str] = set()
    for core in cores:
        made: set[Fact] = set()
        for action in core:
            needed = set(action.preconditions).intersection(_loose(action, classified))
            carried |= {agent for fact in needed - made for agent in classified.agents_of(fact)}
            made |= set(action.effects)
    return frozenset(carried)


def _postures(goals: Sequence[Fact], legs: Sequence[Leg], classified: ClassifiedProblem) -> Iterator[Leg]:
    """Goals that are configurations: legs without a core."""
    role = sum(len(leg.agents) for leg in legs)
    for agent in sorted({agent for goal in goals for agent in classified.agents_of(goal)}):
        wanted = classified.configuration(agent, goals)
        if wanted:
            yield Leg(agents=(agent,), needs=(wanted,), core=(), roles=(role,), bound=(True,))
            role += 1


def renamed(action: GroundAction, names: Mapping[str, str]) -> GroundAction:
    """The action with agents exchanged; what is not in `names` stays."""
    if all(old == new for old, new in names.items()):
        return action

    def of(facts: tuple[Fact, ...]) -> tuple[Fact, ...]:
        return tuple(fact.renamed(names) for fact in facts)

    return replace(
        action,
        arguments={
            name: TEAM_SEPARATOR.join(names.get(part, part) for part in value.split(TEAM_SEPARATOR))
            for name, value in action.arguments.items()
        },
        agents=tuple(names.get(agent, agent) for agent in action.agents),
        preconditions=of(action.preconditions),
        deletes=of(action.deletes),
        intended_effects=of(action.intended_effects),
        other_effects=of(action.other_effects),
    )
