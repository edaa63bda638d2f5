"""The two forms of a fact, and the types of the names in facts.

The planner's form names the relation as an argument, `object_position(sample_1, in, bay_7)`; the wire and the
API use the rel/ref form, `in(sample_1, bay_7)` (MACTA §5, "relationship-reference pairs").
"""

from collections.abc import Iterable, Mapping
from functools import lru_cache

from planner import Fact, KnowledgeBase, KnowledgeBaseError
from robots.wire import SymbolicFact

KNOWN_RELATIONS = 10_000
"""Facts in rel/ref form that are kept: the same ones are in plans, events and answers again and again."""


@lru_cache(maxsize=KNOWN_RELATIONS)
def _relation(predicate: str, args: tuple[str, ...]) -> SymbolicFact:
    return SymbolicFact(predicate=predicate, args=args)


def symbolic(fact: Fact, knowledge_base: KnowledgeBase) -> SymbolicFact:
    """The fact in the rel/ref form of the wire and the API."""
    return _relation(*knowledge_base.to_relation(fact))


def symbolic_all(facts: Iterable[Fact], knowledge_base: KnowledgeBase) -> tuple[SymbolicFact, ...]:
    return tuple(symbolic(fact, knowledge_base) for fact in facts)


def planner_fact(fact: SymbolicFact, knowledge_base: KnowledgeBase, objects: Mapping[str, str]) -> Fact:
    """The fact in the planner's form.

    :param objects: name → type, which tells relations on robots from relations on objects.
    :raises planner.KnowledgeBaseError: if no predicate takes these arguments; the message names the choices.
    """
    return knowledge_base.from_relation(fact.predicate, fact.args, objects)


def stated_fact(
    predicate: str, args: Iterable[str], knowledge_base: KnowledgeBase, objects: Mapping[str, str]
) -> Fact:
    """A fact as somebody states it, who cannot state what follows from a number.

    :raises planner.KnowledgeBaseError: as `planner_fact`.
    """
    if (comparison := knowledge_base.comparisons.get(predicate)) is not None:
        number = comparison.of(*args)
        raise KnowledgeBaseError(
            f"{predicate} stands for {number}; state the number of {comparison.quantity}"
        )
    return knowledge_base.from_relation(predicate, args, objects)


def types_in(facts: Iterable[Fact], knowledge_base: KnowledgeBase) -> dict[str, str]:
    """The names in the facts and the narrowest type that each is used as; constants are left out."""
    types: dict[str, str] = {}
    is_a = knowledge_base.file.is_a
    for fact in facts:
        predicate = knowledge_base.predicates.get(fact.predicate)
        if predicate is None:
            continue
        for name, kind in zip(fact.args, predicate.arguments.values(), strict=True):
            if name not in knowledge_base.constants and (name not in types or is_a(kind, types[name])):
                types[name] = kind
    return types
