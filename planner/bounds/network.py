"""The possible paths of one thing and of each class of agents, as graphs.

An agent's *configuration* is the values of its variables (`invariants`); a thing's *state* is the values of its own
variables and, while one of them names an agent, that agent's configuration. Every plan takes each thing along a path
of states and each agent along a path of configurations; all other conditions of the plan's actions are ignored.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import cast

import numpy as np
from numpy.typing import NDArray

from planner.bounds.moves import Lifted, Move, Moves, terms_of
from planner.bounds.paths import Ints
from planner.bounds.world import OTHER, THING, Binding, Pools, Step, World
from planner.fact import Fact

Values = tuple[Fact | None, ...]
Part = tuple[Ints, Ints, Ints]
"""An agent's part in some edges: configurations before and after, milliseconds."""


@dataclass(slots=True)
class Nodes:
    """Numbers of configurations and states, in order of appearance."""

    numbers: dict[tuple[object, ...], int] = field(default_factory=dict)
    having: dict[tuple[object, ...], list[int]] = field(default_factory=lambda: defaultdict(list))
    """By (owner, fact) the nodes that contain it."""

    def number(self, owner: str, values: Values) -> int:
        key = owner, values
        found = self.numbers.get(key)
        if found is None:
            found = self.numbers[key] = len(self.numbers)
            for value in values:
                if value is not None:
                    self.having[owner, value].append(found)
        return found

    def filled(self, owner: str, values: Lifted, binding: Binding, pools: Pools) -> Ints:
        """The numbers of lifted values, an axis for each pool, of length 1 where they do not depend on it."""
        terms = terms_of(*values)
        used = [name for name in pools if name in terms]
        found = []
        full = dict(binding)
        for chosen in product(*(pools[name] for name in used)):
            full.update(zip(used, chosen, strict=True))
            found.append(
                self.number(owner, tuple([None if one is None else one.ground(full) for one in values]))
            )
        return np.array(found, np.int64).reshape([len(p) if n in used else 1 for n, p in pools.items()])

    def __len__(self) -> int:
        return len(self.numbers)


@dataclass(frozen=True, slots=True)
class AgentEdges:
    """Edges of configurations: numbers before and after, milliseconds; shapes (edges,)."""

    before: Ints
    after: Ints
    spans: Ints


@dataclass(frozen=True, slots=True)
class ThingEdges:
    """Edges of states; shapes (edges,). `things`: number of things that the action moves.

    Of each edge's agents, shapes (agents, edges), -1 for none: configurations before and after, and for how many
    milliseconds the action occupies them.
    """

    before: Ints
    after: Ints
    spans: Ints
    things: Ints
    entries: Ints
    exits: Ints
    kept: Ints


def joined_thing_edges(blocks: Sequence[tuple[Sequence[Ints], Sequence[Part]]]) -> ThingEdges:
    """All edges concatenated; rows of edges with fewer agents than others are padded with -1."""
    widest = max((len(parts) for _, parts in blocks), default=0)
    edges = [np.stack(columns) for columns, _ in blocks] or [np.zeros((4, 0), np.int64)]
    whole = np.concatenate(edges, axis=1)
    filled = []
    for columns, parts in blocks:
        nobody = np.full(len(columns[0]), -1)
        slots = [*parts, *[(nobody, nobody, np.zeros_like(nobody))] * (widest - len(parts))]
        filled.append(
            np.stack([np.stack(slot) for slot in slots], axis=1)
            if slots
            else np.zeros((3, 0, len(nobody)), np.int64)
        )
    agents = np.concatenate(filled, axis=2) if filled else np.zeros((3, 0, 0), np.int64)
    return ThingEdges(*whole, *agents)


class Network:
    """Edges of configurations (`agent_edges`) and of states (`thing_edges`, with the part of each agent)."""

    def __init__(self, world: World, *, like: "Network | None" = None) -> None:
        """
        :param like: another network, which is taken over as far as it is the same, and not used any more.
        :raises NotModelled: if two parameters of an action could be the same agent or thing, or the problem is too
            large.
        """
        self.world = world
        same = like if like is not None and world.has_moves_of(like.world) else None
        self._moves: Moves = Moves(world) if same is None else same._moves
        world.reach(self._moves.steps)
        self.configurations = Nodes()
        self.states = Nodes()
        self.agent_edges: AgentEdges
        self.thing_edges: ThingEdges
        if same is not None and world.has_edges_of(same.world, self._moves.steps):
            self.configurations = same.configurations
            self.states = same.states
            self.agent_edges = same.agent_edges
            self.thing_edges = same.thing_edges
        else:
            self.agent_edges, self.thing_edges = self._edges()

    def _edges(self) -> tuple[AgentEdges, ThingEdges]:
        agent_edges: list[tuple[Ints, ...]] = [(np.zeros(0, np.int64),) * 3]
        thing_edges: list[tuple[tuple[Ints, ...], list[Part]]] = []
        for step in self._moves.steps:
            agent_edges += self._agent_edges(step)
            thing_edges += [deed for kind in self.world.thing_types for deed in self._thing_edges(step, kind)]
        joined = AgentEdges(*(np.concatenate(column) for column in zip(*agent_edges, strict=True)))
        return joined, joined_thing_edges(thing_edges)

    def configuration(self, agent: str, facts: Iterable[Fact]) -> int:
        """The number of an agent's configuration among these facts."""
        named = [self._renamed(fact) for fact in facts if agent in fact.args]
        representative = self.world.representative[agent]
        return self.configurations.number(
            representative, tuple(one.value(named, representative) for one in self._moves.of_agents)
        )

    def state(self, thing: str, facts: Iterable[Fact]) -> int:
        """The number of a thing's state among these facts."""
        kind = self.world.problem.objects[thing]
        known = list(facts)
        own = [one.value(known, thing) for one in self._moves.of_things[kind]]
        values: Values = tuple(one and self._renamed(one, thing) for one in own)
        held = [self._moves.holder(one, self.world.representative) for one in own if one is not None]
        holder = next((one for one in held if one is not None), None)
        if holder is not None:
            named = [self._renamed(fact, thing) for fact in known if holder in fact.args]
            representative = self.world.representative[holder]
            values += tuple(one.value(named, representative) for one in self._moves.of_agents)
        return self.states.number(kind, values)

    def goal_states(self, thing: str, goal: Fact) -> list[int] | None:
        """The states of a thing in which the goal is reached; None if no variable has it."""
        kind = self.world.problem.objects[thing]
        if not any(one.has(goal.predicate, goal.args, thing) for one in self._moves.of_things[kind]):
            return None
        return self.states.having[kind, self._renamed(goal, thing)]

    def configurations_with(self, agent: str, goal: Fact) -> list[int]:
        """An agent's configurations in which a goal is reached; none if no variable has it."""
        representative = self.world.representative[agent]
        return self.configurations.having.get((representative, self._renamed(goal)), [])

    def _renamed(self, fact: Fact, thing: str = "") -> Fact:
        representative = self.world.representative
        things = self.world.things
        return Fact(
            fact.predicate,
            tuple(
                THING if arg == thing else OTHER if arg in things else representative.get(arg, arg)
                for arg in fact.args
            ),
        )

    def _agent_edges(self, step: Step) -> Iterator[tuple[Ints, ...]]:
        """The edges of configurations: before, after, milliseconds."""
        op = step.op
        moves = {name: move for name, move in self._moves.of_agent(op).items() if move.before != move.after}
        for binding in self.world.bindings(op, None) if moves else ():
            found = self.world.spans(step, binding)
            if found is None:
                continue
            pools, spans = found
            possible = spans >= 0
            for name, move in moves.items():
                if binding.get(name) in self.world.representative:
                    before, after = self._configurations(binding, name, move, pools)
                    cost = spans if name in op.agents else np.zeros_like(spans)
                    yield _picked(possible, before, after, cost)

    def _configurations(self, binding: Binding, name: str, move: Move, pools: Pools) -> tuple[Ints, Ints]:
        others = {term: OTHER if value == THING else value for term, value in binding.items()}
        owner = binding[name]
        nodes = self.configurations
        return nodes.filled(owner, move.before, others, pools), nodes.filled(owner, move.after, others, pools)

    def _thing_edges(self, step: Step, kind: str) -> Iterator[tuple[tuple[Ints, ...], list[Part]]]:
        """The edges of states (before, after, milliseconds, things of the action), and for each agent its part."""
        op = step.op
        things = self._moves.of_thing(op, kind)
        concerned = self._moves.of_agent(op)
        for binding in self.world.bindings(op, kind) if things else ():
            thing = next((name for name in things if binding.get(name) == THING), None)
            found = self.world.spans(step, binding) if thing is not None else None
            if thing is None or found is None:
                continue
            pools, spans = found
            agents = {
                name: one for name, one in concerned.items() if binding.get(name) in self.world.representative
            }
            before, after = (
                self.states.filled(kind, self._moves.state(of_thing, of_agents), binding, pools)
                for of_thing, of_agents in (
                    (things[thing].before, {name: one.before for name, one in agents.items()}),
                    (things[thing].after, {name: one.after for name, one in agents.items()}),
                )
            )
            shared = sum(value in (THING, OTHER) for value in binding.values())
            possible = spans >= 0
            parts = []
            for name, move in agents.items():
                busy = spans if name in op.agents else np.zeros_like(spans)
                parts.append(
                    cast("Part", _picked(possible, *self._configurations(binding, name, move, pools), busy))
                )
            yield _picked(possible, before, after, spans, np.full_like(spans, shared)), parts


def _picked(possible: NDArray[np.bool_], *columns: Ints) -> tuple[Ints, ...]:
    """The columns' entries where possible."""
    return tuple(np.broadcast_to(column, possible.shape)[possible] for column in columns)
