"""Changes of numbers by actions, written `wear(tool) += 0.01 * duration()`, as data.

They happen evenly while the action lasts (PDDL 2.1's linear effects). Planners of sequences do not know of them; plans
are checked and supplemented by `planner.problem.number_courses` and `planner.engines.replenishment`.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from planner.errors import KnowledgeBaseError
from planner.knowledge.expression import Expression, Functions

DURATION = ("duration", ())
DISTANCE = ("distance", ())
ENERGY = ("energy", ())
"""What one of the action's robots takes in seconds, drives in metres and uses in joules: `energy()`."""
OWN_TERMS = (DURATION, DISTANCE, ENERGY)
WAITING = ("waiting", ())
"""What a robot uses a second while it waits for the action, beyond what it uses at rest: `waiting()`, in a `drain`."""

_SHAPE = re.compile(r"^\s*([a-z][a-z0-9_]*)\s*\(([^()]*)\)\s*([+-])=\s*(\S.*)$")


@dataclass(frozen=True, slots=True)
class NumberChange:
    """By how much an action raises (sign 1) or lowers (-1) a quantity of these terms in all."""

    quantity: str
    terms: tuple[str, ...]
    sign: int
    amount: Expression

    @classmethod
    def parse(cls, text: str) -> "NumberChange":
        """:raises KnowledgeBaseError: if the text is not `quantity(term, …) += expression`, or with -=."""
        match = _SHAPE.match(text)
        if match is None:
            raise KnowledgeBaseError(
                f"{text!r} is not of the form quantity(term, …) += expression, or with -="
            )
        terms = tuple(term.strip() for term in match[2].split(",")) if match[2].strip() else ()
        return cls(match[1], terms, 1 if match[3] == "+" else -1, Expression.parse(match[4]))

    def value(self, binding: Mapping[str, str], functions: Functions, known: Functions) -> float:
        """By how much it changes the number; 0 where a function has no value.

        :param known: the values of `duration()`, `distance()` and `energy()`.
        """
        return self.sign * (self.amount.value(binding, functions, known) or 0.0)
