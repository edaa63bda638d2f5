"""A symmetry quotient of a problem: one representative for each class of agents, one named thing.

The representative can do whatever a member of its class can: a static fact holds of it if it holds of any member.
*Things* are the objects that no static fact or function names, so one of them, `THING`, represents any of its type,
and all others are `OTHER`.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from planner.bounds.paths import Ints
from planner.errors import PlannerError
from planner.fact import Fact
from planner.knowledge import KnowledgeBase, Operator
from planner.knowledge.expression import scale_term
from planner.knowledge.invariants import Variable, variables_of
from planner.knowledge.literal import Literal
from planner.problem.interface import PlanningProblem
from planner.problem.robot_classes import AgentClasses
from planner.problem.static_facts import StaticFacts

THING = "the thing"
OTHER = "another thing"
MILLISECONDS = 1000
LARGEST = 4_000_000
"""Maximum number of argument combinations of one operator."""

Binding = dict[str, str]
Row = tuple[str, ...]
NO_ROWS: frozenset[Row] = frozenset()
Pools = dict[str, tuple[str, ...]]
"""Unbound parameters and the possible values of each."""
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Step:
    """The part of an operator that the bounds consider: fluent conditions and results."""

    op: Operator
    conditions: tuple[Literal, ...]
    results: tuple[Literal, ...]


class NotModelled(PlannerError):
    """Raised when the bounds cannot model a problem; says why."""


class World:
    """The quotient: static rows, pools of objects, durations."""

    def __init__(
        self, knowledge_base: KnowledgeBase, problem: PlanningProblem, classes: AgentClasses
    ) -> None:
        """:param problem: its goals are not used, nor what is said of them.
        :param classes: of the problem's agents.
        """
        self.base = knowledge_base
        self.problem = problem
        self._members = classes.members
        self.agents = classes.agents
        self.fluents = knowledge_base.fluents
        self.things = StaticFacts(knowledge_base, problem).things
        known = frozenset(self.agents)
        together = any(len(known.intersection(args)) > 1 for _, args in problem.functions)
        self.representative: Mapping[str, str] = {
            agent: agent if together else classes.members[classes.number(agent)][0] for agent in self.agents
        }
        self.representatives = tuple(dict.fromkeys(self.representative.values()))
        self.thing_types = tuple(sorted({problem.objects[name] for name in self.things}))
        stands_for = {**self.representative, **dict.fromkeys(self.things, OTHER)}
        self._rows: dict[tuple[str, int, str], set[Row]] = {}
        self._all: dict[str, set[Row]] = defaultdict(set)
        self._said: dict[str, list[Fact]] = {}
        for fact in problem.facts:
            if fact.predicate in self.fluents:
                for arg in fact.args:
                    self._said.setdefault(arg, []).append(fact)
            self._note(fact.predicate, tuple([stands_for.get(arg, arg) for arg in fact.args]))
        self._tables: dict[tuple[str, tuple[tuple[str, ...], ...]], Floats] = {}
        self._admitted: dict[str, frozenset[str]] = {}
        self._pools: dict[str, tuple[str, ...]] = {}
        self.agent_types = tuple(sorted({problem.objects[agent] for agent in self.agents}))
        self.of_agents = self._sound(set(self.agent_types), self.agents)
        self.of_things = {
            kind: self._sound({kind}, sorted(self.things_of(kind))) for kind in self.thing_types
        }

    def is_of(self, knowledge_base: KnowledgeBase, problem: PlanningProblem, classes: AgentClasses) -> bool:
        """True if it is the quotient of this problem, too."""
        own = self.problem
        return (
            self.base is knowledge_base
            and self._members == classes.members
            and own.facts == problem.facts
            and own.objects == problem.objects
            and own.functions == problem.functions
            and own.zones == problem.zones
        )

    def has_moves_of(self, other: "World") -> bool:
        """True if operators do the same to the same variables here and in another quotient."""
        return (
            self.base is other.base
            and self.problem.objects == other.problem.objects
            and self.representative == other.representative
            and self.things == other.things
            and self.of_agents == other.of_agents
            and self.of_things == other.of_things
        )

    def has_edges_of(self, other: "World", steps: Sequence[Step]) -> bool:
        """True if the steps lead to the same in the same time here and in another quotient with the same moves; of
        both it is known what the steps reach."""
        asked = {one.predicate for step in steps for one in (*self._statics(step.op), *step.conditions)}
        return (
            self.problem.functions == other.problem.functions
            and self.problem.zones == other.problem.zones
            and all(self._all[predicate] == other._all[predicate] for predicate in asked)
        )

    def is_a(self, kind: str, wanted: str) -> bool:
        return self.base.file.is_a(kind, wanted)

    def things_of(self, kind: str) -> frozenset[str]:
        """The things of a type."""
        return frozenset(name for name in self.things if self.problem.objects[name] == kind)

    def admitted(self, kind: str) -> frozenset[str]:
        """All that can be bound to a parameter of the type."""
        if kind not in self._admitted:
            known = {**self.base.constants, **self.problem.objects}
            self._admitted[kind] = frozenset(name for name, own in known.items() if self.is_a(own, kind))
        return self._admitted[kind]

    def _sound(self, kinds: set[str], names: Sequence[str]) -> tuple[Variable, ...]:
        """The variables of these types that have at most one value each from the start."""
        found = variables_of(self.base, frozenset(kinds), frozenset(self.problem.objects.values()))
        return tuple(one for one in found if all(one.is_single(self.said(name), name) for name in names))

    def said(self, name: str) -> Sequence[Fact]:
        """The fluent facts that name an object."""
        return self._said.get(name, ())

    def pool(self, kind: str) -> tuple[str, ...]:
        """Objects of a type that are neither agents nor things, and constants."""
        if kind not in self._pools:
            self._pools[kind] = tuple(sorted(self.admitted(kind) - self.representative.keys() - self.things))
        return self._pools[kind]

    def bindings(self, op: Operator, thing: str | None) -> Iterator[Binding]:
        """Every choice of agents and things for an operator's parameters; the others stay open.

        :param thing: the type of the one thing, or None: all things are others.
        """
        choices = [self._choices(op, name, thing) for name in op.parameters]
        if np.prod([float(len(some)) for some in choices]) > LARGEST / 100:
            raise NotModelled(f"{op.name} has too many arguments")
        for chosen in product(*choices):
            binding = {
                name: value for name, value in zip(op.parameters, chosen, strict=True) if value is not None
            }
            if thing is None or list(binding.values()).count(THING) == 1:
                yield binding

    def _choices(self, op: Operator, name: str, thing: str | None) -> list[str | None]:
        kind = op.parameters[name]
        found: list[str | None] = [
            one for one in self.representatives if self.is_a(self.problem.objects[one], kind)
        ]
        found = [one for one in found if one is not None and self._fits(op, {name: one})]
        if any(self.is_a(own, kind) for own in self.thing_types):
            found.append(OTHER)
        if thing is not None and self.is_a(thing, kind):
            found.append(THING)
        if self.pool(kind):
            found.append(None)
        return found

    def _fits(self, op: Operator, binding: Binding) -> bool:
        """False if a static condition of the operator that has no open parameters does not hold."""
        return all(
            tuple(binding.get(term, term) for term in literal.terms) in self._all[literal.predicate]
            for literal in op.preconditions
            if literal.predicate not in self.fluents
            and not any(term in op.parameters and term not in binding for term in literal.terms)
        )

    def reach(self, steps: Sequence[Step]) -> None:
        """Compute which facts the steps reach from the present facts, ignoring deletes."""
        tasks = [
            (step, binding, [(one.predicate, self._fixed(step.op, one, binding)) for one in step.conditions])
            for step in steps
            for binding in self.bindings(step.op, None)
        ]
        seen: dict[int, list[int]] = {}
        grown = True
        while grown:
            grown = False
            for number, (step, binding, looked_for) in enumerate(tasks):
                sizes = [min(map(len, self._with(predicate, fixed))) for predicate, fixed in looked_for]
                if seen.get(number) == sizes:
                    continue
                seen[number] = sizes
                pools = self._pools_of(step, binding)
                for result in step.results if pools is not None else ():
                    grown |= self._learn(result, binding, pools or {})

    def _learn(self, literal: Literal, binding: Binding, pools: Pools) -> bool:
        """Note the literal's facts; True if there is a new one."""
        rows = product(*(pools.get(term, (binding.get(term, term),)) for term in literal.terms))
        fresh = set(rows) - self._all[literal.predicate]
        for row in fresh:
            self._note(literal.predicate, row)
        return bool(fresh)

    def _note(self, predicate: str, row: Row) -> None:
        self._all[predicate].add(row)
        for place, arg in enumerate(row):
            self._rows.setdefault((predicate, place, arg), set()).add(row)

    def spans(self, step: Step, binding: Binding) -> tuple[Pools, Ints] | None:
        """The values of the open parameters, and the durations in milliseconds, an axis each; -1: impossible.

        Parameters that make no difference to durations, conditions and results have no axis.
        """
        op = step.op
        pools = self._pools_of(step, binding)
        if pools is None:
            return None
        joins = [(one, {term for term in one.terms if term in pools}) for one in self._statics(op)]
        joins = [(one, terms) for one, terms in joins if len(terms) > 1]
        needed = {term for one in (*step.conditions, *step.results) for term in one.terms}
        needed |= {member.get(t, t) for member in op.members for _, ts in op.duration.calls for t in ts}
        needed = needed.union(*(terms for _, terms in joins))
        pools = {name: pool for name, pool in pools.items() if name in needed}
        if np.prod([float(len(pool)) for pool in pools.values()]) > LARGEST:
            raise NotModelled(f"{op.name} has too many arguments")
        spans = self._durations(op, binding, pools)
        for literal, terms in joins:
            named = [name for name in pools if name in terms]
            allowed = {
                tuple(row[literal.terms.index(n)] for n in named)
                for row in self._matching(op, literal, binding)
            }
            mask = np.array([row in allowed for row in product(*(pools[name] for name in named))], np.bool_)
            mask = mask.reshape([len(pools[name]) for name in named])
            spans = np.where(_spread(mask, named, pools), spans, -1)
        return pools, spans

    def _pools_of(self, step: Step, binding: Binding) -> Pools | None:
        """The values of each open parameter that static facts and conditions allow; None if one has none."""
        op = step.op
        if not self._fits(op, binding):
            return None
        pools = {name: self.pool(kind) for name, kind in op.parameters.items() if name not in binding}
        for literal in (*self._statics(op), *step.conditions):
            rows = self._matching(op, literal, binding)
            if not rows:
                return None
            for place, term in enumerate(literal.terms):
                if term in pools:
                    fitting = {row[place] for row in rows}
                    pools[term] = tuple([one for one in pools[term] if one in fitting])
        return pools if all(pools.values()) else None

    def _statics(self, op: Operator) -> list[Literal]:
        return [one for one in op.preconditions if one.predicate not in self.fluents]

    def _fixed(self, op: Operator, literal: Literal, binding: Binding) -> list[tuple[int, str]]:
        """The places of a literal's terms that are not open, and what is there."""
        return [
            (place, OTHER if binding.get(term) == THING else binding.get(term, term))
            for place, term in enumerate(literal.terms)
            if term in binding or term not in op.parameters
        ]

    def _with(self, predicate: str, fixed: Sequence[tuple[int, str]]) -> list[Set[Row]]:
        """For each of these arguments the rows that have it; all rows if there are none."""
        return [self._rows.get((predicate, *one), NO_ROWS) for one in fixed] or [self._all[predicate]]

    def _matching(self, op: Operator, literal: Literal, binding: Binding) -> Set[Row]:
        """The rows that fit the literal."""
        first, *others = sorted(self._with(literal.predicate, self._fixed(op, literal, binding)), key=len)
        for rows in others:
            first = first & rows
        return first

    def _durations(self, op: Operator, binding: Binding, pools: Pools) -> Ints:
        """Durations as `Operator.ground` rounds them, an axis for each pool; -1 where undefined."""
        longest: Floats = np.zeros((1,) * len(pools))
        for member in op.members:
            values: list[Floats] = []
            for name, terms in op.duration.calls:
                aliased = [member.get(term, term) for term in terms]
                table = self._table(name, tuple(pools.get(t, (binding.get(t, t),)) for t in aliased))
                open_terms = [term for term in aliased if term in pools]
                flat = table.reshape([len(pools[term]) for term in open_terms])
                values.append(_spread(flat, open_terms, pools))
            with np.errstate(divide="ignore", invalid="ignore"):
                longest = np.maximum(longest, op.duration.compute(values))  # type: ignore[arg-type]
        scale = self.problem.functions.get(scale_term(op.spec.name, len(op.agents)), 1.0)
        whole = np.broadcast_to(longest, [len(pool) for pool in pools.values()]) * scale * MILLISECONDS
        defined = np.isfinite(whole)
        # NOTE: never above what Python rounds to, whatever the last bit says.
        rounded = np.floor(np.where(defined, whole, 0.0) + 0.5 - 1e-6)
        return np.where(defined, np.maximum(rounded, 0), -1).astype(np.int64)

    def _table(self, name: str, pools: tuple[tuple[str, ...], ...]) -> Floats:
        """A function's values for these arguments, an axis each; NaN where it has none."""
        key = name, pools
        if key not in self._tables:
            functions = self.problem.functions
            values = [functions.get((name, args), np.nan) for args in product(*pools)]
            self._tables[key] = np.array(values, dtype=np.float64).reshape([len(pool) for pool in pools])
        return self._tables[key]


def _spread(values: NDArray[Any], names: Sequence[str], pools: Pools) -> NDArray[Any]:
    """Values with an axis for each of `names`, laid out along the axes of all the pools."""
    distinct = list(dict.fromkeys(names))
    if len(distinct) < len(names):  # the same parameter twice: the diagonal
        values = np.einsum(values, [distinct.index(name) for name in names], list(range(len(distinct))))
    order = [distinct.index(name) for name in pools if name in distinct]
    shape = [len(pool) if name in distinct else 1 for name, pool in pools.items()]
    return values.transpose(order).reshape(shape)
