"""Facts that robots perceive beside those they always can: by which sensor condition, as data."""

import re
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from pydantic import Field, TypeAdapter, ValidationError, field_validator

from robots.conditions.verdict import Condition
from robots.data import Checked
from robots.repertoire.schema import filled, names_in, sensor_conditions
from robots.wire import SymbolicFact

KEY = "sensed_facts"
ME = "me"
_SHAPE = re.compile(r"^([a-z][a-z0-9_]*)\(([^()]*)\)$")
_TERM = re.compile(r"^\$?[A-Za-z][A-Za-z0-9_]*$")

Place = tuple[str | int, ...]


class SensedFact(Checked):
    """A fact in rel/ref form and the condition by which a robot perceives it.

    Arguments are names or `$words`, which stand for any name and are used in the condition; `$me` is the robot itself.
    """

    fact: str
    by: dict[str, Any]

    @field_validator("fact")
    @classmethod
    def _is_a_template(cls, text: str) -> str:
        match = _SHAPE.match(text)
        terms = [term.strip() for term in match[2].split(",")] if match and match[2].strip() else []
        if match is None or any(not _TERM.match(term) for term in terms):
            raise ValueError(f"{text!r} is not of the form predicate($argument, …)")
        return text

    @property
    def predicate(self) -> str:
        return self.fact.partition("(")[0]

    @property
    def terms(self) -> tuple[str, ...]:
        inside = self.fact.partition("(")[2].rstrip(")")
        return tuple(term.strip() for term in inside.split(",")) if inside.strip() else ()

    def condition(self, fact: SymbolicFact, me: str) -> Condition | None:
        """The condition for a fact; None if it is another."""
        if fact.predicate != self.predicate or len(fact.args) != len(self.terms):
            return None
        values: dict[str, str] = {ME: me}
        for term, value in zip(self.terms, fact.args, strict=True):
            if (values.setdefault(term[1:], value) if term.startswith("$") else term) != value:
                return None
        return _one(filled(self.by, values))

    def is_perceived_with(self, sensors: Collection[str], quantities: Collection[str] | None) -> bool:
        """True if these sensors, and what they measure, are all that its condition reads; see `Repertoire.senses`."""
        condition = _one(self.by)
        measured = quantities is None or condition.quantities <= frozenset(quantities)
        return measured and condition.needs <= frozenset(sensors)

    def faults(self) -> Iterator[tuple[Place, str]]:
        """What is wrong with its condition, whatever the arguments."""
        known = {ME, *(term[1:] for term in self.terms if term.startswith("$"))}
        if unknown := [name for name in names_in(self.by) if name not in known]:
            yield ("by",), f"${unknown[0]} is not in {self.fact}; choices: {', '.join(sorted(known))}"
            return
        try:
            _one(self.by)
        except ValidationError as error:
            yield from ((("by", *one["loc"][1:]), one["msg"]) for one in error.errors())


class SensedFacts(Checked):
    """A file of a repertoire that holds no packet."""

    sensed_facts: tuple[SensedFact, ...] = Field(min_length=1)


def _one(template: Mapping[str, Any]) -> Condition:
    conditions: TypeAdapter[tuple[Condition, ...]] = sensor_conditions()
    return conditions.validate_python([template])[0]
