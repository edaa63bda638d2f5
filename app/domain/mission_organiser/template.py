"""Fact templates with variables, and matching them to ground facts."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from planner import Fact

_SHAPE = re.compile(r"^\s*([a-z][a-z0-9_]*)\s*\(([^()]*)\)\s*$")
_TERM = re.compile(r"^\??[A-Za-z][A-Za-z0-9_]*$")

Substitution = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Template:
    """A fact with variables, e.g. `object_position(?object, in, ?ref1)`."""

    predicate: str
    terms: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.predicate}({', '.join(self.terms)})"

    @classmethod
    def parse(cls, text: str) -> "Template":
        """:raises ValueError: if the text is not `predicate(term, …)` with names and ?variables."""
        match = _SHAPE.match(text)
        if match is None:
            raise ValueError(f"{text!r} is not of the form predicate(term, …)")
        terms = tuple(term.strip() for term in match[2].split(","))
        if bad := [term for term in terms if not _TERM.match(term)]:
            raise ValueError(f"{text!r}: {bad[0]!r} is neither a name nor a ?variable")
        return cls(match[1], terms)

    def matched(self, fact: Fact, known: Substitution) -> Substitution | None:
        """`known` widened so that the template becomes the fact; None if it cannot."""
        if fact.predicate != self.predicate or len(fact.args) != len(self.terms):
            return None
        found = dict(known)
        for term, value in zip(self.terms, fact.args, strict=True):
            if (found.setdefault(term, value) if term.startswith("?") else term) != value:
                return None
        return found


def matches(
    templates: Sequence[Template], facts: Sequence[Fact], known: Substitution
) -> Iterator[Substitution]:
    """Every way to make each template a fact of its own among `facts`."""
    if not templates:
        yield known
        return
    first, *rest = templates
    for position, fact in enumerate(facts):
        found = first.matched(fact, known)
        if found is not None:
            yield from matches(rest, [*facts[:position], *facts[position + 1 :]], found)
