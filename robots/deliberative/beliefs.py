"""The belief store: ground terms with their source and age, indexed by functor and argument."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import TypeVar

from robots.data import StrEnum
from robots.deliberative.terms import NOT, Term, Value, as_term, is_ground, opposite
from robots.errors import RuleError

MAX_BELIEFS = 10_000
"""Of one agent; further ones are refused (our choice)."""


class Origin(StrEnum):
    """Where a belief comes from."""

    INITIAL = "initial"
    """Stated in the rule file."""
    ADOPTED = "adopted"
    """Adopted by a commitment; it lasts until it is retracted."""
    PERCEPTOR = "perceptor"
    """Sensed by a condition; it lasts while the sensors say so."""
    EVENT = "event"
    """An event, report or message; it lasts for one cycle."""


LASTING = (Origin.INITIAL, Origin.ADOPTED)


@dataclass(frozen=True, slots=True, kw_only=True)
class Belief:
    """A belief. `source`: the origin's name, such as a rule or perceptor; `words`: what was perceived."""

    term: Term
    origin: Origin
    source: str = ""
    since_s: float
    words: str = ""

    @property
    def value(self) -> bool:
        """False for `not(t)`, which is believed not to hold."""
        return self.term.functor != NOT

    @property
    def about(self) -> Term:
        """The term whose value it is."""
        return self.term if self.value else as_term(self.term.args[0])


Index = dict[Term, None]
"""Terms in the order of adoption."""
NONE: Index = {}


class BeliefStore:
    """The beliefs of one agent. A term and its opposite are never both believed: the newer one replaces the other."""

    def __init__(self) -> None:
        self._beliefs: dict[Term, Belief] = {}
        self._by_form: dict[tuple[str, int], Index] = {}
        self._by_argument: dict[tuple[str, int, int, Value], Index] = {}

    def __contains__(self, term: object) -> bool:
        return term in self._beliefs

    def __len__(self) -> int:
        return len(self._beliefs)

    def __iter__(self) -> Iterator[Belief]:
        return iter(self._beliefs.values())

    def get(self, term: Term) -> Belief | None:
        return self._beliefs.get(term)

    def adopt(self, belief: Belief) -> tuple[Term, ...]:
        """Believe it, and return the terms that ceased and the new one; nothing if it was believed already.

        A belief that is already held keeps its age, and lasts if either of the two does.

        :raises RuleError: if it has variables, or there are too many.
        """
        term = belief.term
        known = self._beliefs.get(term)
        if known is not None:
            if belief.origin in LASTING and known.origin not in LASTING:
                self._beliefs[term] = Belief(
                    term=term, origin=belief.origin, source=belief.source, since_s=known.since_s
                )
            return ()
        if not is_ground_term(term):
            raise RuleError(f"a belief has no variables: {term}")
        if len(self._beliefs) >= MAX_BELIEFS:
            raise RuleError(f"{term} is not believed: there are {MAX_BELIEFS} beliefs already")
        other = opposite(term)
        ceased = self.retract(other)
        self._beliefs[term] = belief
        functor, args = term
        self._by_form.setdefault((functor, len(args)), {})[term] = None
        for position, value in enumerate(args):
            self._by_argument.setdefault((functor, len(args), position, value), {})[term] = None
        return (other, term) if ceased else (term,)

    def retract(self, term: Term) -> bool:
        """Cease to believe it; False if it was not believed."""
        if self._beliefs.pop(term, None) is None:
            return False
        functor, args = term
        _remove(self._by_form, (functor, len(args)), term)
        for position, value in enumerate(args):
            _remove(self._by_argument, (functor, len(args), position, value), term)
        return True

    def candidates(self, functor: str, arity: int, known: Collection[tuple[int, Value]]) -> Index:
        """Believed terms of a form; of those with one of the known arguments, given by position, the fewest."""
        found = self._by_form.get((functor, arity), NONE)
        for position, value in known:
            fewer = self._by_argument.get((functor, arity, position, value), NONE)
            if len(fewer) < len(found):
                found = fewer
        return found


def is_ground_term(term: Term) -> bool:
    return all(is_ground(one) for one in term.args)


Key = TypeVar("Key")


def _remove(index: dict[Key, Index], key: Key, term: Term) -> None:
    terms = index[key]
    del terms[term]
    if not terms:
        del index[key]
