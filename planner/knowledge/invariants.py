"""Implicit variables of a knowledge base: sets of facts of which at most one holds at a time.

Found as Helmert (2009, Concise finite-domain representations for PDDL planning tasks) does: a set of patterns that
share one object, such that an action that adds a fact of the set needs and deletes another, of the same object.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache

from planner.fact import Fact
from planner.knowledge import KnowledgeBase, Operator
from planner.knowledge.literal import Literal

MAX_PARTS = 4
"""Maximum number of patterns of a variable."""

Admits = Callable[[str], bool]
"""Whether an object of the sort considered can be bound to a parameter of this type."""


@dataclass(frozen=True, slots=True)
class Part:
    """Facts of a predicate that name the object at `place` and have these constants (None: any argument)."""

    predicate: str
    place: int
    constants: tuple[str | None, ...]

    def covers(self, other: "Part") -> bool:
        return (self.predicate, self.place) == (other.predicate, other.place) and all(
            mine in (None, theirs) for mine, theirs in zip(self.constants, other.constants, strict=True)
        )

    def has(self, predicate: str, terms: tuple[str, ...], name: str) -> bool:
        """True if a fact (or literal) of this predicate and these terms is of the part, said of `name`."""
        return (
            predicate == self.predicate
            and terms[self.place] == name
            and all(want is None or want == term for want, term in zip(self.constants, terms, strict=True))
        )


@dataclass(frozen=True, slots=True)
class Variable:
    """At most one fact of all the parts holds of one object."""

    parts: tuple[Part, ...]

    def of(self, literals: Iterable[Literal], name: str) -> Literal | None:
        """The first literal that is of the variable, said of the parameter `name`."""
        return next((one for one in literals if self.has(one.predicate, one.terms, name)), None)

    def value(self, facts: Iterable[Fact], name: str) -> Fact | None:
        """The value of an object's variable among these facts."""
        return next((fact for fact in facts if self.has(fact.predicate, fact.args, name)), None)

    def is_single(self, facts: Iterable[Fact], name: str) -> bool:
        """True if at most one of the facts is of the variable."""
        return sum(self.has(fact.predicate, fact.args, name) for fact in facts) <= 1

    def has(self, predicate: str, terms: tuple[str, ...], name: str) -> bool:
        return any(part.predicate == predicate and part.has(predicate, terms, name) for part in self.parts)


@lru_cache(maxsize=64)
def variables_of(
    knowledge_base: KnowledgeBase, kinds: frozenset[str], present: frozenset[str]
) -> tuple[Variable, ...]:
    """The variables of objects of some types, none of them contained in another.

    :param present: the types of all objects of the problem: operators for others are ignored.
    """
    operators = knowledge_base.operators_among(present)

    def admits(wanted: str) -> bool:
        return any(knowledge_base.file.is_a(kind, wanted) for kind in kinds)

    found: dict[frozenset[Part], None] = {}
    seeds = dict.fromkeys(
        seed
        for op in operators
        for literal in (*op.intended_effects, *op.other_effects)
        for part in _parts(op, literal, admits)
        for seed in (Part(part.predicate, part.place, (None,) * len(part.constants)), part)
    )
    for seed in seeds:
        for parts in _grown((seed,), operators, admits):
            found[frozenset(parts)] = None
    whole = [
        parts for parts in found if not any(parts != other and _contains(other, parts) for other in found)
    ]
    return tuple(Variable(tuple(sorted(parts, key=str))) for parts in whole)


def _contains(parts: Iterable[Part], others: Iterable[Part]) -> bool:
    return all(any(part.covers(other) for part in parts) for other in others)


def _grown(
    parts: tuple[Part, ...], operators: tuple[Operator, ...], admits: Admits
) -> Iterator[tuple[Part, ...]]:
    """The set completed by the parts that actions delete when they add one of the set."""
    for op in operators:
        if _is_vague(op, parts, admits):
            return
        fault = _unbalanced(op, parts, admits)
        if fault is None:
            continue
        if not fault or len(parts) == MAX_PARTS:
            return
        more = [
            part
            for literal in op.deletes
            if literal in op.preconditions
            for part in _parts(op, literal, admits)
            if literal.terms[part.place] == fault
        ]
        for part in more:
            if not _contains(parts, (part,)):
                kept = tuple(one for one in parts if not part.covers(one))
                yield from _grown((*kept, part), operators, admits)
        return
    yield parts


def _is_vague(op: Operator, parts: tuple[Part, ...], admits: Admits) -> bool:
    """True if an open parameter stands where a part wants a constant, or a delete is not a condition too."""
    for literal in (*op.preconditions, *op.deletes, *op.intended_effects, *op.other_effects):
        for part in parts:
            if part.predicate != literal.predicate or not _admitted(op, literal.terms[part.place], admits):
                continue
            pairs = zip(part.constants, literal.terms, strict=True)
            if any(want is not None and term in op.parameters for want, term in pairs):
                return True
            name = literal.terms[part.place]
            mine = literal in op.deletes and part.has(literal.predicate, literal.terms, name)
            if mine and literal not in op.preconditions:
                return True
    return False


def _unbalanced(op: Operator, parts: tuple[Part, ...], admits: Admits) -> str | None:
    """The parameter of which the operator adds a fact without deleting one; "" if it adds several at once."""
    added = [
        literal.terms[part.place]
        for literal in dict.fromkeys((*op.intended_effects, *op.other_effects))
        for part in parts
        if part.predicate == literal.predicate
        and part.has(literal.predicate, literal.terms, literal.terms[part.place])
        and _admitted(op, literal.terms[part.place], admits)
    ]
    if len(added) != len(set(added)):
        return ""
    variable = Variable(parts)
    return next((name for name in added if variable.of(op.deletes, name) is None), None)


def _parts(op: Operator, literal: Literal, admits: Admits) -> Iterator[Part]:
    """The literal's patterns: each of its terms that can be the object, the constants as they are."""
    constants = tuple(None if term in op.parameters else term for term in literal.terms)
    for place, term in enumerate(literal.terms):
        if _admitted(op, term, admits):
            yield Part(literal.predicate, place, constants)


def _admitted(op: Operator, term: str, admits: Admits) -> bool:
    return term in op.parameters and admits(op.parameters[term])
