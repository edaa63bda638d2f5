"""The possible paths of one thing and of each class of agents, as graphs.

An agent's *configuration* is the values of its variables (`invariants`); a thing's *state* is the values of its own
variables and, while one of them names an agent, that agent's configuration. Every plan takes each thing along a path
of states and each agent along a path of configurations; all other conditions of the plan's actions are ignored.
"""

from collections.abc import Iterable, Iterator
from typing import cast

import numpy as np
from numpy.typing import NDArray

from planner.bounds.edges import AgentEdges, Nodes, Part, Values, joined_thing_edges
from planner.bounds.moves import Move, Moves
from planner.bounds.paths import Ints
from planner.bounds.world import OTHER, THING, Binding, Pools, Step, World
from planner.fact import Fact


class Network:
    """Edges of configurations (`agent_edges`) and of states (`thing_edges`, with the part of each agent).

    :raises NotModelled: if two parameters of an action could be the same agent or thing, or the problem is too large.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self.configurations = Nodes()
        self.states = Nodes()
        self._moves = moves = Moves(world)
        agent_edges: list[tuple[Ints, ...]] = [(np.zeros(0, np.int64),) * 3]
        thing_edges: list[tuple[tuple[Ints, ...], list[Part]]] = []
        world.reach(moves.steps)
        for step in moves.steps:
            agent_edges += self._agent_edges(step)
            thing_edges += [deed for kind in world.thing_types for deed in self._thing_edges(step, kind)]
        self.agent_edges = AgentEdges(*(np.concatenate(column) for column in zip(*agent_edges, strict=True)))
        self.thing_edges = joined_thing_edges(thing_edges)

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
