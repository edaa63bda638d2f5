"""Incremental matching: which instances of conditions hold, kept up to date with each change of a belief.

As in TREAT (Miranker 1987), complete matches are kept, and partial ones are not: a new belief is joined with the others
through the store's indices, a belief that ceases takes its matches with it, and negated beliefs block theirs. The work
grows with the matches that a change makes or breaks, not with the number of beliefs.
"""

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from robots.deliberative.beliefs import BeliefStore
from robots.deliberative.guards import holds
from robots.deliberative.program import Conditions, Guard
from robots.deliberative.terms import (
    Bindings,
    Term,
    Value,
    Variable,
    instance,
    is_ground,
    match,
    variables_in,
)

Key = tuple[Value, ...]
"""The values of the variables that are told apart."""
Name = tuple[str, int]
"""What a query is for, and a number."""


@dataclass(slots=True, eq=False)
class _Match:
    """One way to satisfy the positive conditions. `blockers`: how many beliefs contradict the negated ones."""

    query: "_Query"
    key: Key
    terms: tuple[Term, ...]
    refused: tuple[Term, ...]
    blockers: int = 0


@dataclass(slots=True, eq=False)
class _Query:
    """Conditions that are matched. `kept`: the variables that tell one instance from another."""

    name: Name
    kept: tuple[str, ...]
    positive: tuple[Term, ...]
    negated: tuple[Term, ...]
    guards: tuple[Guard, ...]
    joins: "tuple[tuple[int, ...], ...]" = ()
    """For each position, in which order the others are joined to it."""
    counts: dict[Key, int] = field(default_factory=dict)
    """How many matches without a blocker each instance has."""


@dataclass(frozen=True, slots=True)
class Change:
    """An instance of a query that has begun to hold, or has ceased to."""

    query: Name
    key: Key
    holds: bool


class Matcher:
    """Matches queries against the beliefs of one store, of which each change is `told` or `untold`."""

    def __init__(self, store: BeliefStore) -> None:
        self._store = store
        self._queries: list[_Query] = []
        self._positions: dict[tuple[str, int], list[tuple[_Query, int]]] = {}
        """By form, the positive conditions of that form."""
        self._of_term: dict[Term, dict[_Match, None]] = {}
        """The matches that rest on a belief."""
        self._refusing: dict[Term, dict[_Match, None]] = {}
        """The matches that a belief blocks, of negated conditions without a variable left."""
        self._refusing_form: dict[tuple[str, int], dict[_Match, None]] = {}
        """Likewise of those with variables, which stand for anything, by their form."""
        self._changes: dict[tuple[Name, Key], tuple[_Query, bool]] = {}

    def add(self, name: Name, conditions: Conditions, kept: Sequence[str]) -> None:
        """Match these conditions from now on.

        :param kept: variables of positive conditions; instances that differ in others are one.
        """
        positive = tuple(dict.fromkeys(one.term for one in conditions.positive))
        query = _Query(
            name=name,
            kept=tuple(kept),
            positive=positive,
            negated=tuple(dict.fromkeys(one.term for one in conditions.literals if one.negated)),
            guards=conditions.guards,
        )
        query.joins = tuple(_join_order(positive, first) for first in range(len(positive)))
        self._queries.append(query)
        for position, term in enumerate(positive):
            self._positions.setdefault((term.functor, len(term.args)), []).append((query, position))
        if not positive:
            self._complete(query, {}, ())
            return
        first = _join_order(positive, None)
        for bindings in self._joined(query, first, 0, {}, None, -1):
            self._complete(query, bindings, positive)

    def told(self, term: Term) -> None:
        """Account for a term that is believed since now."""
        form = (term.functor, len(term.args))
        for one in self._refusing.get(term, ()):
            self._block(one, 1)
        for one in self._refusing_form.get(form, ()):
            self._block(one, _times(one, term))
        for query, position in self._positions.get(form, ()):
            bindings: dict[str, Value] = {}
            if match_term(query.positive[position], term, bindings):
                order = query.joins[position]
                for found in self._joined(query, order, 0, bindings, term, position):
                    self._complete(query, found, query.positive)

    def untold(self, term: Term) -> None:
        """Account for a term that is no longer believed."""
        for one in list(self._of_term.get(term, ())):
            self._drop(one)
        for one in self._refusing.get(term, ()):
            self._block(one, -1)
        for one in self._refusing_form.get((term.functor, len(term.args)), ()):
            self._block(one, -_times(one, term))

    def changes(self) -> list[Change]:
        """The instances that have begun or ceased to hold since the last call, in the order of the queries' names."""
        found = [
            Change(name, key, bool(query.counts.get(key)))
            for (name, key), (query, before) in self._changes.items()
            if bool(query.counts.get(key)) is not before
        ]
        self._changes.clear()
        return found

    def holding(self, name: Name) -> list[Key]:
        """The instances of a query that hold now."""
        return [key for query in self._queries if query.name == name for key in query.counts]

    def _joined(
        self,
        query: _Query,
        order: tuple[int, ...],
        depth: int,
        bindings: dict[str, Value],
        new: Term | None,
        position: int,
    ) -> Iterator[dict[str, Value]]:
        """Every way to satisfy the conditions in that order.

        `new` stands at its position: before that it is left out, so that no match is found twice.
        """
        if depth == len(order):
            yield bindings
            return
        other = order[depth]
        pattern = query.positive[other]
        known = [
            (index, value)
            for index, one in enumerate(pattern.args)
            if is_ground(value := bindings.get(one.name, one) if type(one) is Variable else one)
        ]
        if len(known) == len(pattern.args):
            term = Term(pattern.functor, tuple([value for _, value in known]))
            if term in self._store and not (term == new and other < position):
                yield from self._joined(query, order, depth + 1, bindings, new, position)
            return
        for term in list(self._store.candidates(pattern.functor, len(pattern.args), known)):
            if term == new and other < position:
                continue
            extended = dict(bindings)
            if match_term(pattern, term, extended):
                yield from self._joined(query, order, depth + 1, extended, new, position)

    def _complete(self, query: _Query, bindings: Bindings, positive: tuple[Term, ...]) -> None:
        if not all(holds(guard, bindings) for guard in query.guards):
            return
        refused = tuple([instance(one, bindings) for one in query.negated])
        made = _Match(
            query=query,
            key=tuple([bindings[name] for name in query.kept]),
            terms=tuple(dict.fromkeys([instance(one, bindings) for one in positive])),
            refused=refused,
        )
        for term in made.terms:
            self._of_term.setdefault(term, {})[made] = None
        for term in refused:
            if all(is_ground(one) for one in term.args):
                self._refusing.setdefault(term, {})[made] = None
                made.blockers += term in self._store
            else:
                form = (term.functor, len(term.args))
                self._refusing_form.setdefault(form, {})[made] = None
                known = [(index, one) for index, one in enumerate(term.args) if is_ground(one)]
                candidates = self._store.candidates(*form, known)
                made.blockers += sum(match_term(term, one, {}) for one in candidates)
        if not made.blockers:
            self._count(made, 1)

    def _drop(self, one: _Match) -> None:
        for term in one.terms:
            _discard(self._of_term, term, one)
        for term in one.refused:
            _discard(self._refusing, term, one)
            _discard(self._refusing_form, (term.functor, len(term.args)), one)
        if not one.blockers:
            self._count(one, -1)

    def _block(self, one: _Match, by: int) -> None:
        if not by:
            return
        before = one.blockers
        one.blockers += by
        if not before and one.blockers:
            self._count(one, -1)
        elif before and not one.blockers:
            self._count(one, 1)

    def _count(self, one: _Match, by: int) -> None:
        counts = one.query.counts
        before = counts.get(one.key, 0)
        self._changes.setdefault((one.query.name, one.key), (one.query, bool(before)))
        if before + by:
            counts[one.key] = before + by
        else:
            del counts[one.key]


def match_term(pattern: Term, term: Term, bindings: dict[str, Value]) -> bool:
    """`match` of two terms of one form."""
    for one, value in zip(pattern.args, term.args, strict=True):
        if type(one) is Variable:
            if bindings.setdefault(one.name, value) != value:
                return False
        elif type(one) is Term:
            if not match(one, value, bindings):
                return False
        elif one != value:
            return False
    return True


def satisfied(conditions: Conditions, bindings: Bindings, store: BeliefStore) -> bool:
    """Whether conditions hold now for these bindings; other variables stand for anything that is believed."""
    if not all(holds(guard, bindings) for guard in conditions.guards):
        return False
    for literal in conditions.literals:
        term = instance(literal.term, bindings)
        if all(is_ground(one) for one in term.args):
            believed = term in store
        else:
            known = [(index, one) for index, one in enumerate(term.args) if is_ground(one)]
            candidates = store.candidates(term.functor, len(term.args), known)
            believed = any(match_term(term, one, {}) for one in candidates)
        if believed is literal.negated:
            return False
    return True


def solutions(conditions: Conditions, bindings: Bindings, store: BeliefStore) -> Iterator[dict[str, Value]]:
    """Every way to satisfy conditions now, in the order of the beliefs."""
    yield from _solved([one.term for one in conditions.positive], conditions, dict(bindings), store)


def _solved(
    left: list[Term], conditions: Conditions, bindings: dict[str, Value], store: BeliefStore
) -> Iterator[dict[str, Value]]:
    if not left:
        if satisfied(conditions, bindings, store):
            yield bindings
        return
    pattern = instance(left[0], bindings)
    known = [(index, one) for index, one in enumerate(pattern.args) if is_ground(one)]
    for term in list(store.candidates(pattern.functor, len(pattern.args), known)):
        extended = dict(bindings)
        if match_term(pattern, term, extended):
            yield from _solved(left[1:], conditions, extended, store)


def _join_order(positive: Sequence[Term], first: int | None) -> tuple[int, ...]:
    """The other conditions, each time the one with the most arguments that are known by then."""
    bound = set() if first is None else set(variables_in(positive[first]))
    left = [index for index in range(len(positive)) if index != first]
    order = []
    while left:
        best = max(left, key=lambda index: (_known_share(positive[index], bound), -index))
        left.remove(best)
        order.append(best)
        bound.update(variables_in(positive[best]))
    return tuple(order)


def _known_share(term: Term, bound: set[str]) -> float:
    if not term.args:
        return 1.0
    known = sum(all(name in bound for name in variables_in(one)) for one in term.args)
    return known / len(term.args)


def _times(one: _Match, term: Term) -> int:
    """How many of the match's negated conditions with variables the term contradicts."""
    form = (term.functor, len(term.args))
    return sum(
        (other.functor, len(other.args)) == form
        and not all(is_ground(value) for value in other.args)
        and match_term(other, term, {})
        for other in one.refused
    )


def _discard(index: dict[Any, dict[_Match, None]], key: Hashable, one: _Match) -> None:
    matches = index.get(key)
    if matches is not None and one in matches:
        del matches[one]
        if not matches:
            del index[key]
