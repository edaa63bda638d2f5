"""Numeric facts: what a world has numbers of, which are counted from its facts, and which it starts with.

A number is known by its quantity and arguments, `battery(rover_1)`. A location with several berths has one number, that
of all its berths together.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, Self

from app.domain.errors import Invalid
from app.domain.world_model.beliefs import Facts
from app.domain.world_model.layout import layout_of
from app.domain.world_model.problem import LOCATION, LONG_OBJECT, OBJECT, ROBOT
from planner import Fact, KnowledgeBase, Numbers, QuantitySpec, number_words
from planner.knowledge.comparison import Term
from planner.knowledge.literal import Literal
from planner.knowledge.schema import ANY
from robots.world import WorldFile

BATTERY = "battery"


@dataclass(frozen=True, slots=True, kw_only=True)
class Things:
    """What numbers may be told of: the types of robots, samples and locations, and the location of each berth.

    :param storing: the locations that hold samples.
    """

    types: Mapping[str, str]
    location_of: Mapping[str, str]
    storing: frozenset[str]

    @classmethod
    def of_layout(cls, layout: Mapping[str, Any]) -> Self:
        """:param layout: a world's, as it is recorded."""
        location_of = {berth: rack["name"] for rack in layout.get("racks", ()) for berth in rack["berths"]}
        places = {
            location_of.get(one["name"], one["name"]): one["capacity"] for one in layout.get("locations", ())
        }
        types = dict.fromkeys(places, LOCATION)
        types |= {
            one["name"]: LONG_OBJECT if one["length_m"] else OBJECT for one in layout.get("samples", ())
        }
        types |= {one["name"]: ROBOT for one in layout.get("robots", ())}
        storing = frozenset(name for name, capacity in places.items() if capacity)
        return cls(types=types, location_of=location_of, storing=storing)

    @classmethod
    def of(cls, world: WorldFile) -> Self:
        return cls.of_layout(layout_of(world))

    def args(self, args: Iterable[str]) -> tuple[str, ...]:
        """The arguments with locations instead of berths."""
        return tuple(self.location_of.get(arg, arg) for arg in args)

    def for_planner(self, numbers: Numbers) -> dict[Term, float]:
        """The numbers with those of locations for each of their berths, which plans name."""
        berths: dict[str, list[str]] = {}
        for berth, location in self.location_of.items():
            berths.setdefault(location, []).append(berth)
        return {
            (quantity, named): value
            for (quantity, args), value in numbers.items()
            for named in product(*(berths.get(arg, (arg,)) for arg in args))
        }


def check_term(quantity: str, args: Iterable[str], things: Things, knowledge_base: KnowledgeBase) -> Term:
    """The number that is meant.

    :raises Invalid: if there is no such quantity, or it tells nothing of these arguments.
    """
    spec = knowledge_base.quantities.get(quantity)
    if spec is None:
        raise Invalid(
            f"unknown quantity {quantity!r}",
            code="unknown-quantity",
            thing=quantity,
            choices=sorted(knowledge_base.quantities),
        )
    given = things.args(args)
    if len(given) != len(spec.arguments):
        raise Invalid(
            f"{quantity} takes ({', '.join(spec.arguments)}), not ({', '.join(given)})",
            code="malformed-number",
            thing=quantity,
        )
    for arg, kind in zip(given, spec.arguments.values(), strict=True):
        if not _is_a(arg, kind, things, knowledge_base):
            raise Invalid(
                f"{quantity}({', '.join(given)}): {arg!r} is no {kind} of the world",
                code="unknown-name",
                thing=arg,
                choices=_named(kind, things, knowledge_base),
            )
    return quantity, given


def check_value(quantity: str, value: float, knowledge_base: KnowledgeBase) -> None:
    """:raises Invalid: if the quantity cannot be so much, or is counted from facts."""
    spec = knowledge_base.quantities[quantity]
    if spec.counts:
        raise Invalid(
            f"{quantity} is counted from the facts {spec.counts}; correct these",
            code="counted-number",
            thing=quantity,
            choices=sorted(name for name, one in knowledge_base.quantities.items() if not one.counts),
        )
    if not spec.admits(value):
        raise Invalid(
            f"{quantity} is {spec.range_words}, not {number_words(value)}",
            code="out-of-range",
            thing=quantity,
        )


def counted_predicates(knowledge_base: KnowledgeBase) -> frozenset[str]:
    """The predicates whose facts some quantity counts."""
    return frozenset(one.predicate for one in _counts(knowledge_base).values())


def counted_numbers(facts: Facts, things: Things, knowledge_base: KnowledgeBase) -> dict[Term, float]:
    """The numbers that are counted from the facts, also those that are 0."""
    numbers: dict[Term, float] = {}
    for quantity, counted in _counts(knowledge_base).items():
        spec = knowledge_base.quantities[quantity]
        known = Counter(
            args
            for fact in facts
            if (args := _counted_args(fact, counted, spec, things)) is not None
            and all(
                _is_a(arg, kind, things, knowledge_base)
                for arg, kind in zip(args, spec.arguments.values(), strict=True)
            )
        )
        if len(spec.arguments) == 1:
            (kind,) = spec.arguments.values()
            names = _named(kind, things, knowledge_base)
            numbers |= {
                (quantity, (name,)): 0.0
                for name in names
                if things.types[name] != LOCATION or name in things.storing
            }
        numbers |= {(quantity, args): float(count) for args, count in known.items()}
    return numbers


def initial_numbers(world: WorldFile, knowledge_base: KnowledgeBase) -> dict[Term, float]:
    """The numbers that hold at the start and are not counted: of the file, and the batteries of its robots.

    :raises Invalid: if a number of the file is not of the vocabulary, or stated twice.
    """
    things = Things.of(world)
    numbers: dict[Term, float] = {}
    if BATTERY in knowledge_base.quantities:
        numbers |= {(BATTERY, (robot.name,)): robot.battery for robot in world.robots}
    for stated in world.numbers:
        term = check_term(stated.quantity, stated.args, things, knowledge_base)
        check_value(stated.quantity, stated.value, knowledge_base)
        if term in numbers:
            raise Invalid(
                f"{stated.quantity}({', '.join(stated.args)}) is stated already; a robot's battery stands in `robots`",
                code="stated-twice",
                thing=stated.quantity,
            )
        numbers[term] = stated.value
    return numbers


def words_of(term: Term, value: float, knowledge_base: KnowledgeBase) -> str:
    """The number as an operator reads it: `rover_1's battery is at 80 %`."""
    quantity, args = term
    spec = knowledge_base.quantities.get(quantity)
    if spec is None:
        return f"{quantity}({', '.join(args)}) is {number_words(round(value, 6))}"
    return spec.words(quantity, args, value)


def _counts(knowledge_base: KnowledgeBase) -> dict[str, Literal]:
    return {
        name: Literal.parse(spec.counts) for name, spec in knowledge_base.quantities.items() if spec.counts
    }


def _counted_args(fact: Fact, counted: Literal, spec: QuantitySpec, things: Things) -> tuple[str, ...] | None:
    """The arguments of the number that the fact adds to; None if it adds to none."""
    if fact.predicate != counted.predicate:
        return None
    bound: dict[str, str] = {}
    for term, arg in zip(counted.terms, fact.args, strict=True):
        name = things.location_of.get(arg, arg)
        if term in spec.arguments:
            if bound.setdefault(term, name) != name:
                return None
        elif term not in (ANY, arg):
            return None
    return tuple(bound[name] for name in spec.arguments) if len(bound) == len(spec.arguments) else None


def _named(kind: str, things: Things, knowledge_base: KnowledgeBase) -> list[str]:
    return sorted(name for name in things.types if _is_a(name, kind, things, knowledge_base))


def _is_a(name: str, kind: str, things: Things, knowledge_base: KnowledgeBase) -> bool:
    own = things.types.get(name) or knowledge_base.constants.get(name)
    return own is not None and knowledge_base.file.is_a(own, kind)
