"""Checks a packet's templates slot by slot, so that an error can name the place in the file."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import TypeAdapter, ValidationError

from robots.repertoire.parameters import LIMITS
from robots.repertoire.schema import (
    PATTERNS,
    PATTERNS_OF,
    PacketSpec,
    avoidance_methods,
    behaviour_patterns,
    filled,
    named_method,
    names_in,
    packet_results,
    sensor_conditions,
)

Place = tuple[str | int, ...]
Fault = tuple[Place, str]
"""A slot of the packet, and what is wrong there."""
OWN_NAMES = ("me", "timeout_s")
TARGET_NAMES = ("target", "stand_off_m")
"""Names that templates may use beside arguments and parameters; the latter in packets with a target."""


def template_faults(spec: PacketSpec) -> Iterator[Fault]:
    """What no packet of any arguments could have: unknown senses, forms, fields and names, numbers out of range."""
    own = (*OWN_NAMES, *(TARGET_NAMES if spec.target else ()))
    known = {*spec.arguments, *spec.optional, *spec.parameters, *LIMITS, *own}
    values = spec.defaults()
    for place, template, adapter in _templates(spec):
        if unknown := [name for name in names_in(template) if name not in known]:
            yield place, f"${unknown[0]} is not an argument or parameter; choices: {', '.join(sorted(known))}"
            continue
        try:
            adapter.validate_python(filled(template, values))
        except ValidationError as error:
            # NOTE: the adapters check lists; the first part of the place is the only entry's number.
            yield from (((*place, *one["loc"][1:]), one["msg"]) for one in error.errors())
    try:
        avoidance_methods().validate_python(named_method(filled(spec.avoid, values)))
    except ValidationError as error:
        yield from ((("avoid", *one["loc"]), f"{one['msg']} (or {PATTERNS})") for one in error.errors())


def _templates(spec: PacketSpec) -> Iterator[tuple[Place, list[Mapping[str, Any]], TypeAdapter[Any]]]:
    """Each condition and pattern, as a list of one, with its place."""
    conditions = sensor_conditions()
    for slot in ("before", "maintain", "after"):
        yield from ((place, one, conditions) for place, one in _each(slot, getattr(spec, slot)))
    yield from ((place, one, packet_results()) for place, one in _each("results", spec.results))
    for name, event in spec.events.items():
        yield from ((("events", *place), one, conditions) for place, one in _each(name, event))
    for slot in ("waiting", "patterns", "retry"):
        for place, one in _each(slot, getattr(spec, slot)):
            if one[0].keys() != {PATTERNS_OF}:
                yield place, one, behaviour_patterns()


def _each(slot: str, entries: Iterable[Mapping[str, Any]]) -> Iterator[tuple[Place, list[Mapping[str, Any]]]]:
    return (((slot, index), [one]) for index, one in enumerate(entries))
