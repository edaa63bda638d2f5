"""Binds a lifted fragment to goals of its shape by a join over the present facts."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from planner.engines.hierarchical.fragments.lifting import LiftedFragment, Pattern
from planner.engines.hierarchical.fragments.world_index import WorldIndex
from planner.fact import Fact
from planner.knowledge import Operator

KINDS = 6
"""Maximum number of kinds of agents tried in one role."""
PLACES = 4
"""Maximum number of other objects tried in one role."""
BINDINGS = 64
"""Maximum number of bindings of one fragment."""


@dataclass(frozen=True, slots=True)
class Bound:
    """A fragment with its variables bound; `cost`: the sum of its durations, seconds."""

    fragment: LiftedFragment
    values: tuple[str, ...]
    cost: float

    @property
    def steps(self) -> tuple[tuple[Operator, tuple[str, ...]], ...]:
        """Each operator with its arguments."""
        return tuple(
            (step.op, tuple(self.values[variable] for variable in step.variables))
            for step in self.fragment.steps
        )

    @property
    def agents(self) -> tuple[str, ...]:
        return tuple(self.values[variable] for variable in sorted(self.fragment.agents))


def join(index: WorldIndex, fragment: LiftedFragment, goals: Sequence[Fact]) -> Iterator[Bound]:
    """Bindings for these goals, roughly the cheapest first in each role; only the cheapest agent of a kind."""
    start: list[str | None] = [None] * len(fragment.kinds)
    for pattern, goal in zip(fragment.goals, goals, strict=True):
        for term, arg in zip(pattern.terms, goal.args, strict=True):
            if isinstance(term, str):
                if term != arg:
                    return
            elif start[term] not in (None, arg):
                return
            else:
                start[term] = arg
    bound = [value for value in start if value is not None]
    if len(set(bound)) < len(bound):
        return
    yield from _Join(index, fragment, start).run()


class _Join:
    def __init__(self, index: WorldIndex, fragment: LiftedFragment, values: list[str | None]) -> None:
        self.index = index
        self.fragment = fragment
        self.values = values
        self.rank = {variable: place for place, variable in enumerate(fragment.order)}
        last = len(fragment.order)
        self.conditions: list[list[Pattern]] = [[] for _ in range(last + 1)]
        for pattern in fragment.conditions:
            self.conditions[self._last(t for t in pattern.terms if isinstance(t, int)) + 1].append(pattern)
        self.costs: list[list[int]] = [[] for _ in range(last + 1)]
        for number, step in enumerate(fragment.steps):
            self.costs[self._last(step.variables) + 1].append(number)
        self.pools = [
            [
                (pattern, pattern.terms.index(variable))
                for pattern in self.conditions[place + 1]
                if pattern.terms.count(variable) == 1
            ]
            for place, variable in enumerate(fragment.order)
        ]
        """For each place in the order the conditions that list the values its variable may have, and where."""
        self.left = BINDINGS

    def _last(self, variables: Iterator[int] | Sequence[int]) -> int:
        """The place in the order from which on all these variables are bound; -1: from the start."""
        return max((self.rank.get(variable, -1) for variable in variables), default=-1)

    def run(self) -> Iterator[Bound]:
        fits = all(
            value is None or self._is_of(variable, value) for variable, value in enumerate(self.values)
        )
        if not fits or not self._holds(0):
            return
        cost = self._cost(0)
        if cost is not None:
            yield from self._extend(0, cost)

    def _is_of(self, variable: int, value: str) -> bool:
        return all(value in self.index.members_of_type[kind] for kind in self.fragment.kinds[variable])

    def _holds(self, place: int) -> bool:
        rows = self.index.rows
        values = self.values
        return all(
            pattern.row(values) in rows.get(pattern.predicate, ()) for pattern in self.conditions[place]
        )

    def _cost(self, place: int) -> float | None:
        """The cost of the steps whose last variable is bound at this place; None if one is undefined."""
        total = 0.0
        for number in self.costs[place]:
            step = self.fragment.steps[number]
            seconds = self.index.seconds(step.op, [self.values[v] or "" for v in step.variables])
            if seconds is None:
                return None
            total += seconds
        return total

    def _choices(self, place: int) -> list[tuple[float, str]]:
        """The values for the variable of this place, with the cost of the steps each completes."""
        variable = self.fragment.order[place]
        index = self.index
        values = self.values
        pools = [
            index.values(pattern.predicate, pattern.row(values), hole) for pattern, hole in self.pools[place]
        ]
        if not pools:
            pools = [list(index.of_type[kind]) for kind in self.fragment.kinds[variable]]
        found = []
        for value in min(pools, key=len):
            if value in values or not self._is_of(variable, value):
                continue
            values[variable] = value
            if self._holds(place + 1) and (cost := self._cost(place + 1)) is not None:
                found.append((cost, value))
        values[variable] = None
        return found

    def _extend(self, place: int, cost: float) -> Iterator[Bound]:
        order = self.fragment.order
        if place == len(order):
            if self.left > 0 and not self._is_redundant():
                self.left -= 1
                yield Bound(self.fragment, tuple(value or "" for value in self.values), cost)
            return
        variable = order[place]
        choices = self._choices(place)
        if len(choices) > 1:
            choices = self._few(place, choices)
        for more, value in choices:
            if self.left <= 0:
                break
            self.values[variable] = value
            yield from self._extend(place + 1, cost + more)
        self.values[variable] = None

    def _few(self, place: int, choices: list[tuple[float, str]]) -> list[tuple[float, str]]:
        """The cheapest choices, looking ahead as far as nothing else is to be chosen; of agents one a kind."""
        variable = self.fragment.order[place]
        kind_of = self.index.kind_of
        ranked = []
        for cost, value in choices:
            self.values[variable] = value
            ahead = self._ahead(place + 1)
            if ahead is not None:
                ranked.append((cost + ahead, value, cost))
        self.values[variable] = None
        ranked.sort()
        if variable not in self.fragment.agents:
            return [(cost, value) for _, value, cost in ranked[:PLACES]]
        best: dict[int, tuple[float, str]] = {}
        for _, value, cost in ranked:
            best.setdefault(kind_of[value], (cost, value))
        return list(best.values())[:KINDS]

    def _ahead(self, place: int) -> float | None:
        """The cost of the steps that follow without a choice; None if nothing fits."""
        if place == len(self.fragment.order):
            return 0.0
        choices = self._choices(place)
        if len(choices) != 1:
            return 0.0 if choices else None
        cost, value = choices[0]
        variable = self.fragment.order[place]
        self.values[variable] = value
        ahead = self._ahead(place + 1)
        self.values[variable] = None
        return None if ahead is None else cost + ahead

    def _is_redundant(self) -> bool:
        """True if all effects that are used of some step hold already."""
        rows = self.index.rows
        values = self.values
        return any(
            patterns and all(pattern.row(values) in rows.get(pattern.predicate, ()) for pattern in patterns)
            for patterns in self.fragment.effects
        )
