"""Conditions on numeric facts, written `battery(robot) >= 0.3`, as literals of predicates that no action changes.

Planners without numbers thus treat them like any static fact. Whether they hold is decided once, from the numbers known
when a problem is built.
"""

import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite
from types import MappingProxyType

from planner.errors import KnowledgeBaseError
from planner.fact import Fact
from planner.knowledge.literal import Literal

Term = tuple[str, tuple[str, ...]]
"""A number by its quantity and arguments, e.g. ("battery", ("rover_1",))."""
Numbers = Mapping[Term, float]
"""Numeric facts, e.g. ("battery", ("rover_1",)) -> 0.8."""

_SHAPE = re.compile(r"^\s*([a-z][a-z0-9_]*)\s*\(([^()]*)\)\s*(>=|<=|>|<)\s*(\S+)\s*$")
_SIGNS = re.compile(r"[<>=]")
_HOLDS: Mapping[str, Callable[[float, float], bool]] = MappingProxyType(
    {">=": operator.ge, "<=": operator.le, ">": operator.gt, "<": operator.lt}
)
_OPPOSITE = MappingProxyType({">=": "<", "<=": ">", ">": "<=", "<": ">="})
_NAMES = MappingProxyType({">=": "at_least", "<=": "at_most", ">": "above", "<": "below"})


@dataclass(frozen=True, slots=True)
class Comparison:
    """A quantity compared with a number, of whatever arguments."""

    quantity: str
    sign: str
    number: float

    @property
    def predicate(self) -> str:
        """The predicate that stands for it: `battery_at_least_0_3`."""
        number = number_words(self.number).replace("-", "minus_").replace("+", "").replace(".", "_")
        return f"{self.quantity}_{_NAMES[self.sign]}_{number}"

    @property
    def opposite(self) -> "Comparison":
        return Comparison(self.quantity, _OPPOSITE[self.sign], self.number)

    def holds(self, value: float) -> bool:
        return _HOLDS[self.sign](value, self.number)

    def of(self, *args: str) -> str:
        """`battery(rover_1) >= 0.3`"""
        return f"{self.quantity}({', '.join(args)}) {self.sign} {number_words(self.number)}"

    def phrase(self, *args: str) -> str:
        """`rover_1 has battery >= 0.3`, for readers of sentences."""
        if len(args) != 1:
            return self.of(*args)
        return f"{args[0]} has {self.quantity} {self.sign} {number_words(self.number)}"

    def facts(self, numbers: Numbers) -> frozenset[Fact]:
        """The facts of its predicate that hold; of what has no number, none does."""
        return frozenset(
            Fact(self.predicate, args)
            for (quantity, args), value in numbers.items()
            if quantity == self.quantity and self.holds(value)
        )


def read_comparison(text: str) -> tuple[Comparison, tuple[str, ...]] | None:
    """The comparison and its terms; None if the text is a plain literal.

    :raises KnowledgeBaseError: if it compares in another way than `quantity(term, …) >= number`.
    """
    match = _SHAPE.match(text)
    if match is None:
        if _SIGNS.search(text):
            raise KnowledgeBaseError(
                f"{text!r} is not of the form quantity(term, …) >= number, or with <=, > or <"
            )
        return None
    try:
        number = float(match[4])
    except ValueError:
        number = float("nan")
    if not isfinite(number):
        raise KnowledgeBaseError(f"{text!r}: {match[4]!r} is no number")
    terms = tuple(term.strip() for term in match[2].split(",")) if match[2].strip() else ()
    return Comparison(match[1], match[3], number), terms


def condition(text: str) -> Literal:
    """The literal of a pre-condition, which may be a comparison.

    :raises KnowledgeBaseError: if it is neither.
    """
    read = read_comparison(text)
    return Literal.parse(text) if read is None else Literal(read[0].predicate, read[1])


def number_words(value: float) -> str:
    """The shortest decimal of the number: `0.3`, `12`."""
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


SHARE = "share"
"""The unit of numbers that are read as percentages."""


def value_words(value: float, unit: str) -> str:
    """A number with its unit, as an operator reads it: `80 %`, `12.5 lx`, `3`."""
    if unit == SHARE:
        return f"{number_words(round(100 * value, 1))} %"
    return f"{number_words(round(value, 6))} {unit}".rstrip()
