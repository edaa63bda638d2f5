"""The ways of one thing and of each class of agents, as graphs.

An agent's *configuration* is the values of its variables (`invariants`), a thing's *state* the values of its own and,
as long as one of them names an agent, that agent's configuration. Every plan takes each thing along a path of states
and each agent along a path of configurations; what else the plan's actions need is left out.
"""

from collections.abc import Iterable, Iterator
from typing import cast

import numpy as np
from numpy.typing import NDArray

from planner.bounds.edges import Drives, Nodes, Part, Values, joined_deeds
from planner.bounds.moves import Move, Moves
from planner.bounds.paths import Ints
from planner.bounds.world import OTHER, THING, Binding, Pools, Step, World
from planner.fact import Fact


class Network:
    """Edges of configurations (`drives`) and of states (`deeds`), with what each of a deed's agents does.

    :raises NotModelled: if two parameters of an action could be the same agent or thing, or there is too much.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self.configurations = Nodes()
        self.states = Nodes()
        self._moves = moves = Moves(world)
        drives: list[tuple[Ints, ...]] = [(np.zeros(0, np.int64),) * 3]
        deeds: list[tuple[tuple[Ints, ...], list[Part]]] = []
        world.reach(moves.steps)
        for step in moves.steps:
            drives += self._drives(step)
            deeds += [deed for kind in world.thing_types for deed in self._deeds(step, kind)]
        self.drives = Drives(*(np.concatenate(column) for column in zip(*drives, strict=True)))
        self.deeds = joined_deeds(deeds)

    def configuration(self, agent: str, facts: Iterable[Fact]) -> int:
        """The number of an agent's configuration among these facts."""
        named = [self._renamed(fact) for fact in facts if agent in fact.args]
        leader = self.world.leader[agent]
        return self.configurations.number(
            leader, tuple(one.value(named, leader) for one in self._moves.of_agents)
        )

    def state(self, thing: str, facts: Iterable[Fact]) -> int:
        """The number of a thing's state among these facts."""
        kind = self.world.problem.objects[thing]
        known = list(facts)
        own = [one.value(known, thing) for one in self._moves.of_things[kind]]
        values: Values = tuple(one and self._renamed(one, thing) for one in own)
        held = [self._moves.holder(one, self.world.leader) for one in own if one is not None]
        holder = next((one for one in held if one is not None), None)
        if holder is not None:
            named = [self._renamed(fact, thing) for fact in known if holder in fact.args]
            leader = self.world.leader[holder]
            values += tuple(one.value(named, leader) for one in self._moves.of_agents)
        return self.states.number(kind, values)

    def goal_states(self, thing: str, goal: Fact) -> list[int] | None:
        """The states of a thing in which the goal is reached; None if no variable has it."""
        kind = self.world.problem.objects[thing]
        if not any(one.has(goal.predicate, goal.args, thing) for one in self._moves.of_things[kind]):
            return None
        return self.states.having[kind, self._renamed(goal, thing)]

    def configurations_with(self, agent: str, goal: Fact) -> list[int]:
        """An agent's configurations in which a goal is reached; none if no variable has it."""
        leader = self.world.leader[agent]
        return self.configurations.having.get((leader, self._renamed(goal)), [])

    def _renamed(self, fact: Fact, thing: str = "") -> Fact:
        leader = self.world.leader
        things = self.world.things
        return Fact(
            fact.predicate,
            tuple(
                THING if arg == thing else OTHER if arg in things else leader.get(arg, arg)
                for arg in fact.args
            ),
        )

    def _drives(self, step: Step) -> Iterator[tuple[Ints, ...]]:
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
                if binding.get(name) in self.world.leader:
                    before, after = self._configurations(binding, name, move, pools)
                    cost = spans if name in op.agents else np.zeros_like(spans)
                    yield _picked(possible, before, after, cost)

    def _configurations(self, binding: Binding, name: str, move: Move, pools: Pools) -> tuple[Ints, Ints]:
        others = {term: OTHER if value == THING else value for term, value in binding.items()}
        owner = binding[name]
        nodes = self.configurations
        return nodes.filled(owner, move.before, others, pools), nodes.filled(owner, move.after, others, pools)

    def _deeds(self, step: Step, kind: str) -> Iterator[tuple[tuple[Ints, ...], list[Part]]]:
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
            agents = {name: one for name, one in concerned.items() if binding.get(name) in self.world.leader}
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
