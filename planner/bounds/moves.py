"""What a problem's operators do to the variables of agents and things, without grounding."""

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations

from planner.bounds.world import NotModelled, Step, World
from planner.fact import Fact
from planner.knowledge import Operator
from planner.knowledge.invariants import Variable
from planner.knowledge.literal import Literal

Lifted = tuple[Literal | None, ...]
"""Values of variables with parameters in them."""


@dataclass(frozen=True, slots=True)
class Move:
    """The values of a parameter's variables before and after an operator."""

    before: Lifted
    after: Lifted


class Moves:
    """The relevant variables, `of_agents` and `of_things` by type, and the operators that change them (`steps`).

    A variable is relevant if every action that changes some variable of the same agent or thing has its value as a
    precondition. So an action leads from one known configuration to another.

    :raises NotModelled: if two parameters of such an action could be the same agent or thing.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self._operators = [
            op
            for op in world.base.operators_among(set(world.problem.objects.values()))
            if not self._is_contradictory(op)
        ]
        self.of_things = {
            kind: self._decided(variables, partial(self._moved_things, kind=kind))
            for kind, variables in world.of_things.items()
        }
        self.of_agents = self._decided(
            world.of_agents,
            lambda op, kept: self._concerned(op, kept) if self._is_relevant(op, kept) else (),
        )
        self._of_agent: dict[str, Mapping[str, Move]] = {}
        self.steps = [self._step(op) for op in self._operators if self._is_relevant(op, self.of_agents)]

    def of_agent(self, op: Operator) -> Mapping[str, Move]:
        """By parameter what the operator does to agents that it concerns."""
        if op.name not in self._of_agent:
            names = self._concerned(op, self.of_agents)
            self._of_agent[op.name] = {name: self._move(op, name, self.of_agents) for name in names}
        return self._of_agent[op.name]

    def of_thing(self, op: Operator, kind: str) -> dict[str, Move]:
        """By parameter what the operator does to things of a type."""
        variables = self.of_things[kind]
        return {
            name: self._move(op, name, variables) for name in self._moved_things(op, variables, kind=kind)
        }

    def state(self, of_thing: Lifted, of_agents: Mapping[str, Lifted]) -> Lifted:
        """A thing's state: its own values and, where an agent's configuration has one of them too, that agent's."""
        held = [self.holder(one, of_agents) for one in of_thing if one is not None]
        holder = next((one for one in held if one is not None), None)
        return of_thing if holder is None else of_thing + of_agents[holder]

    def holder(self, value: Fact | Literal, agents: Container[str]) -> str | None:
        """The agent whose configuration contains this value of a thing, too."""
        terms = value.args if isinstance(value, Fact) else value.terms
        return next(
            (
                term
                for term in terms
                if term in agents and any(one.has(value.predicate, terms, term) for one in self.of_agents)
            ),
            None,
        )

    def _names_agent(self, op: Operator, name: str) -> bool:
        world = self.world
        return any(world.is_a(kind, op.parameters[name]) for kind in world.agent_types)

    def _is_contradictory(self, op: Operator) -> bool:
        """True if the conditions ask for two values of one variable."""
        world = self.world
        differ = {frozenset(pair) for pair in op.distinct}
        sorts = [(world.of_agents, frozenset(world.agents))]
        sorts += [(variables, world.things_of(kind)) for kind, variables in world.of_things.items()]
        return any(
            _excluded(one, other, op, differ)
            for variables, names in sorts
            for name, wanted in op.parameters.items()
            if names.issuperset(world.admitted(wanted))
            for variable in variables
            for one, other in combinations(
                [one for one in op.preconditions if variable.has(one.predicate, one.terms, name)], 2
            )
        )

    def _move(self, op: Operator, name: str, variables: Sequence[Variable]) -> Move:
        before = tuple(one.of(op.preconditions, name) for one in variables)
        after: list[Literal | None] = []
        for variable, old in zip(variables, before, strict=True):
            added = variable.of((*op.intended_effects, *op.other_effects), name)
            gone = variable.of(op.deletes, name) is not None
            after.append(added if added is not None else None if gone else old)
        return Move(before, tuple(after))

    def _moves_thing(self, op: Operator, name: str, kind: str, variables: Sequence[Variable]) -> bool:
        """True if the action changes the thing's variables or the configuration of an agent they name."""
        if not self.world.is_a(kind, op.parameters[name]):
            return False
        move = self._move(op, name, variables)
        return move.before != move.after or any(
            self._names_agent(op, term) and self._moves_agent(op, term, self.world.of_agents)
            for term in terms_of(*move.before).intersection(op.parameters)
        )

    def _moves_agent(self, op: Operator, name: str, variables: Sequence[Variable]) -> bool:
        move = self._move(op, name, variables)
        return self._names_agent(op, name) and move.before != move.after

    def _decided(
        self, kept: tuple[Variable, ...], changed: Callable[[Operator, Sequence[Variable]], Iterable[str]]
    ) -> tuple[Variable, ...]:
        """The variables whose value is a precondition of every action that changes any of them.

        :param changed: the parameters of an operator whose variables it changes.
        """
        while True:
            unknown = {
                one
                for op in self._operators
                for name in changed(op, kept)
                for one in kept
                if one.of(op.preconditions, name) is None
            }
            if not unknown:
                return kept
            kept = tuple(one for one in kept if one not in unknown)

    def _moved_things(self, op: Operator, variables: Sequence[Variable], *, kind: str) -> list[str]:
        return [name for name in op.parameters if self._moves_thing(op, name, kind, variables)]

    def _is_relevant(self, op: Operator, of_agents: Sequence[Variable]) -> bool:
        """True if the action changes a variable."""
        for name in op.parameters:
            if self._moves_agent(op, name, of_agents):
                return True
            if any(self._moves_thing(op, name, kind, some) for kind, some in self.of_things.items()):
                return True
        return False

    def _concerned(self, op: Operator, of_agents: Sequence[Variable]) -> list[str]:
        """The parameters whose configurations matter: agents, agents changed, agents that a moved thing is with."""
        with_things = {
            term
            for kind, variables in self.of_things.items()
            for name in op.parameters
            if self._moves_thing(op, name, kind, variables)
            for move in [self._move(op, name, variables)]
            for term in terms_of(*move.before, *move.after)
        }
        return [
            name
            for name in op.parameters
            if self._names_agent(op, name)
            and (name in op.agents or name in with_things or self._moves_agent(op, name, of_agents))
        ]

    def _step(self, op: Operator) -> Step:
        self._check(op)
        self._check_times(op)
        moves = list(self.of_agent(op).values())
        moves += [move for kind in self.of_things for move in self.of_thing(op, kind).values()]
        conditions = dict.fromkeys(one for move in moves for one in move.before if one is not None)
        results = dict.fromkeys(one for move in moves for one in move.after if one is not None)
        return Step(op, tuple(conditions), tuple(results))

    def _check_times(self, op: Operator) -> None:
        """What it needs of agents and things, and does to them, must last as long as the action."""
        variables = [*self.of_agents, *(one for some in self.of_things.values() for one in some)]
        for slot, spans in op.spans.items():
            for literal in spans if slot != "delete" else ():
                if any(
                    one.has(literal.predicate, literal.terms, term)
                    for one in variables
                    for term in literal.terms
                ):
                    raise NotModelled(f"{op.name}: {literal} concerns it {spans[literal].begin} only")

    def _check(self, op: Operator) -> None:
        """Two parameters must not be the same agent or the same thing."""
        differ = {frozenset(pair) for pair in op.distinct}
        sorts = [*self.world.agent_types, *self.world.thing_types]
        for one, other in combinations(op.parameters, 2):
            if frozenset((one, other)) not in differ and any(
                self.world.is_a(kind, op.parameters[one]) and self.world.is_a(kind, op.parameters[other])
                for kind in sorts
            ):
                raise NotModelled(f"{op.name}: {one} and {other} may be the same")


def _excluded(one: Literal, other: Literal, op: Operator, differ: set[frozenset[str]]) -> bool:
    """True if the two cannot be the same fact."""
    if one.predicate != other.predicate:
        return True
    return any(
        mine != theirs
        and (frozenset((mine, theirs)) in differ or not (mine in op.parameters or theirs in op.parameters))
        for mine, theirs in zip(one.terms, other.terms, strict=True)
    )


def terms_of(*literals: Literal | None) -> set[str]:
    return {term for one in literals if one is not None for term in one.terms}
