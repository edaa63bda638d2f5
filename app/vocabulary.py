"""What the service asks of the planner's knowledge base: the two forms of a fact, and which facts robots can sense.

The planner's form names the relation as an argument, `object_position(sample_1, in, bay_7)`; the wire and the API use
the rel/ref form, `in(sample_1, bay_7)` (MACTA §5: "rel1, ref1 … relationship-reference pairs").
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol

from planner.fact import Fact
from robots.wire import SymbolicFact


class PredicateTraits(Protocol):
    """The traits of a predicate that matter here; `sensed`: a robot can perceive whether it holds."""

    @property
    def sensed(self) -> bool: ...


class Vocabulary(Protocol):
    """The part of `planner.KnowledgeBase` that is used here."""

    @property
    def predicates(self) -> Mapping[str, PredicateTraits]: ...

    def to_relation(self, fact: Fact) -> tuple[str, tuple[str, ...]]: ...

    def from_relation(self, predicate: str, args: Sequence[str], objects: Mapping[str, str]) -> Fact: ...


def symbolic(fact: Fact, vocabulary: Vocabulary) -> SymbolicFact:
    """The fact in the rel/ref form of the wire and the API."""
    predicate, args = vocabulary.to_relation(fact)
    return SymbolicFact(predicate=predicate, args=tuple(args))


def symbolic_all(facts: Iterable[Fact], vocabulary: Vocabulary) -> tuple[SymbolicFact, ...]:
    return tuple(symbolic(fact, vocabulary) for fact in facts)


def planner_fact(fact: SymbolicFact, vocabulary: Vocabulary, objects: Mapping[str, str]) -> Fact:
    """The fact in the planner's form.

    :param objects: name → type, which tells relations on robots from relations on objects.
    :raises planner.KnowledgeBaseError: if no predicate takes these arguments; the message names the choices.
    """
    return vocabulary.from_relation(fact.predicate, fact.args, objects)
