"""Grounds the operators of a small world by a join over its static facts."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from operator import itemgetter

from planner.engines.hierarchical.fragments.steps import Step, Task
from planner.engines.hierarchical.fragments.world_index import WorldIndex
from planner.fact import Fact
from planner.knowledge import Operator
from planner.knowledge.literal import Literal

Atom = tuple[str, tuple[str, ...]]
Rows = Callable[[tuple[str, ...]], tuple[str, ...]]
Form = tuple[tuple[str, Rows], ...]
"""Literals: each a predicate, and a function that selects its terms from the operator's arguments and constants."""
MIN_S = 0.1
"""Minimum cost of an action in seconds, so that no plan contains needless actions."""


def task_of(
    index: WorldIndex,
    objects: frozenset[str],
    goals: Sequence[Fact],
    *,
    limit: int,
    is_over: Callable[[], bool],
) -> Task | None:
    """The task of the goals in the world cut down to these objects.

    :param limit: None is returned for a task of more steps.
    :param is_over: asked now and then; None is returned once it is True.
    """
    numbering = _Numbering(goals)
    steps: list[Step] = []
    for op in _useful(index, goals):
        template = _OperatorTemplate(op, index)
        for args in bindings(index, op, objects):
            cost = index.seconds(op, args)
            if cost is None:
                continue
            steps.append(template.step(args, max(cost, MIN_S), numbering))
            if len(steps) > limit or (len(steps) % 1024 == 0 and is_over()):
                return None
    return Task(
        objects=objects,
        steps=tuple(steps),
        initial=numbering.initial(index),
        goal=numbering.goal,
        width=numbering.width,
    )


def _useful(index: WorldIndex, goals: Sequence[Fact]) -> list[Operator]:
    """The operators that a goal may need, step by step: for an effect that is intended, or that makes way (table 3)."""
    predicates = index.knowledge_base.predicates
    waiting = list(index.knowledge_base.operators)
    wanted = {goal.predicate for goal in goals}
    useful: set[str] = set()
    while found := [
        op
        for op in waiting
        if any(literal.predicate in wanted for literal in op.intended_effects)
        or any(predicates[one.predicate].make_way and one.predicate in wanted for one in op.other_effects)
    ]:
        useful.update(op.name for op in found)
        waiting = [op for op in waiting if op.name not in useful]
        wanted.update(literal.predicate for op in found for literal in op.preconditions)
    return [op for op in index.knowledge_base.operators if op.name in useful]


class _Numbering:
    """A bit for each atom met and, before those, one for each goal, which only intended effects set."""

    def __init__(self, goals: Sequence[Fact]) -> None:
        atoms = dict.fromkeys((goal.predicate, goal.args) for goal in goals)
        self._marks: dict[Atom, int] = {atom: 1 << number for number, atom in enumerate(atoms)}
        self._rows: dict[str, dict[tuple[str, ...], int]] = defaultdict(dict)
        """By predicate, the bit of each row met."""
        self.goal = (1 << len(atoms)) - 1
        self.width = len(atoms)

    def mask(self, literals: Form, terms: tuple[str, ...]) -> int:
        """The bits of the literals.

        :param terms: the operator's arguments and constants, which the literals select from.
        """
        mask = 0
        for predicate, row_of in literals:
            rows = self._rows[predicate]
            row = row_of(terms)
            bit = rows.get(row)
            if bit is None:
                bit = rows[row] = 1 << self.width
                self.width += 1
            mask |= bit
        return mask

    def marks(self, mask: int) -> int:
        """The goals' own bits for those among the atoms of the mask."""
        marks = 0
        for (predicate, row), mark in self._marks.items():
            if self._rows[predicate].get(row, 0) & mask:
                marks |= mark
        return marks

    def initial(self, index: WorldIndex) -> int:
        """The bits of what holds at present."""
        initial = 0
        for predicate, bits in self._rows.items():
            present = index.rows.get(predicate, ())
            for row, bit in bits.items():
                if row in present:
                    initial |= bit
        for (predicate, row), mark in self._marks.items():
            if row in index.rows.get(predicate, ()):
                initial |= mark
        return initial


class _OperatorTemplate:
    """An operator's fluent literals, ready to be filled with arguments."""

    def __init__(self, op: Operator, index: WorldIndex) -> None:
        literals = (*op.preconditions, *op.deletes, *op.intended_effects, *op.other_effects)
        every = dict.fromkeys((*op.parameters, *(term for literal in literals for term in literal.terms)))
        place = {term: number for number, term in enumerate(every)}
        self.constants = tuple(every)[len(op.parameters) :]

        def ready(literals: Sequence[Literal]) -> Form:
            return tuple(
                (literal.predicate, _selection([place[term] for term in literal.terms]))
                for literal in literals
                if literal.predicate in index.fluents
            )

        self.op = op
        self.agents = [place[agent] for agent in op.agents]
        self.needs = ready(op.preconditions)
        self.removes = ready(op.deletes)
        self.intended = ready(op.intended_effects)
        self.others = ready(op.other_effects)
        predicates = index.knowledge_base.predicates
        self.ways = tuple(literal for literal in self.others if predicates[literal[0]].make_way)

    def step(self, args: tuple[str, ...], cost: float, numbering: _Numbering) -> Step:
        terms = args + self.constants
        removes = numbering.mask(self.removes, terms)
        intended = numbering.mask(self.intended, terms)
        intended |= numbering.marks(intended)
        return Step(
            op=self.op,
            args=args,
            cost=cost,
            needs=numbering.mask(self.needs, terms),
            removes=removes | numbering.marks(removes),
            adds=intended | numbering.mask(self.others, terms),
            intended=intended,
            justifying=intended | numbering.mask(self.ways, terms),
            agents=tuple([args[place] for place in self.agents]),
        )


def _selection(places: Sequence[int]) -> Rows:
    """A function that selects the terms at these places."""
    if len(places) > 1:
        return itemgetter(*places)
    return lambda terms: tuple([terms[place] for place in places])


def bindings(index: WorldIndex, op: Operator, objects: frozenset[str]) -> Iterator[tuple[str, ...]]:
    """The arguments of an operator among these objects for which its static conditions hold."""
    names = tuple(op.parameters)
    statics = [literal for literal in op.preconditions if literal.predicate not in index.fluents]
    pools = {name: sorted(objects.intersection(index.of_type[kind])) for name, kind in op.parameters.items()}
    order = _order(op, statics, pools)
    checks = [
        [literal for literal in statics if _last(literal, op, order) == position]
        for position in range(len(order))
    ]
    differ = [
        [other for other in order[:position] if op.parameters[other] == op.parameters[name]]
        for position, name in enumerate(order)
    ]
    if any(
        _last(literal, op, order) < 0 and literal.terms not in index.rows.get(literal.predicate, ())
        for literal in statics
    ):
        return
    binding: dict[str, str] = {}

    def extend(position: int) -> Iterator[tuple[str, ...]]:
        if position == len(order):
            yield tuple(binding[name] for name in names)
            return
        name = order[position]
        taken = {binding[other] for other in differ[position]}
        for value in pools[name]:
            if value in taken:
                continue
            binding[name] = value
            if all(
                tuple(binding.get(term, term) for term in literal.terms) in index.rows[literal.predicate]
                for literal in checks[position]
            ):
                yield from extend(position + 1)
        binding.pop(name, None)

    yield from extend(0)


def _last(literal: Literal, op: Operator, order: Sequence[str]) -> int:
    """The position in the order at which the literal is ground."""
    return max((order.index(term) for term in literal.terms if term in op.parameters), default=-1)


def _order(op: Operator, statics: Sequence[Literal], pools: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """The parameters in an order in which static conditions cut early."""
    order: list[str] = []
    while len(order) < len(op.parameters):

        def tied(name: str) -> int:
            return sum(
                name in literal.terms and {t for t in literal.terms if t in op.parameters} <= {name, *order}
                for literal in statics
            )

        rest = [name for name in op.parameters if name not in order]
        order.append(min(rest, key=lambda name: (-tied(name), len(pools[name]), name)))
    return tuple(order)
