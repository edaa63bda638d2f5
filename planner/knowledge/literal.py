"""Literals as the knowledge base writes them: `robot_position(robots, rel1, ref1)`."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from planner.errors import KnowledgeBaseError
from planner.fact import Fact

_SHAPE = re.compile(r"^\s*([a-z][a-z0-9_]*)\s*(?:\(([^()]*)\))?\s*$")


@dataclass(frozen=True, slots=True)
class Literal:
    """A positive literal; each term is the name of a parameter or a constant."""

    predicate: str
    terms: tuple[str, ...]

    @classmethod
    def parse(cls, text: str) -> "Literal":
        """:raises KnowledgeBaseError: if the text is not `predicate(term, …)`."""
        match = _SHAPE.match(text)
        if match is None:
            raise KnowledgeBaseError(f"{text!r} is not of the form predicate(term, …)")
        inner = (match[2] or "").strip()
        return cls(match[1], tuple(term.strip() for term in inner.split(",")) if inner else ())

    def ground(self, binding: Mapping[str, str]) -> Fact:
        """The fact under the binding; terms it does not bind are constants."""
        return Fact(self.predicate, tuple([binding.get(term, term) for term in self.terms]))

    def rename(self, names: Mapping[str, str]) -> "Literal":
        return Literal(self.predicate, tuple(names.get(term, term) for term in self.terms))

    def __str__(self) -> str:
        return f"{self.predicate}({', '.join(self.terms)})"


def ground_all(literals: Iterable[Literal], binding: Mapping[str, str]) -> tuple[Fact, ...]:
    """The facts under the binding, as `Literal.ground` makes each; large plans ask for hundreds of thousands."""
    of = binding.get
    return tuple([Fact(one.predicate, tuple(map(of, one.terms, one.terms))) for one in literals])
