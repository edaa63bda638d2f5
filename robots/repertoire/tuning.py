"""Tuning: overrides of the numbers in a packet's patterns.

A pattern is named "dof/name", as in telemetry, a parameter by its place in the pattern: `stimulus.reach_m`, `r.gain`,
`u.value`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any

from pydantic import ValidationError

from robots.errors import RepertoireError
from robots.reactive.patterns import BehaviourPattern
from robots.repertoire.schema import PacketSpec, behaviour_patterns, filled

Tuning = Mapping[str, Mapping[str, float]]
"""Of one packet: pattern, parameter, number."""
PARTS = ("stimulus", "r", "u")

Template = Mapping[str, Any]


def tuned(spec: PacketSpec, tuning: Tuning) -> PacketSpec:
    """The packet with overridden parameters.

    :raises RepertoireError: naming packet, pattern and parameter, if one is unknown or out of its range.
    """
    known = [_name(one) for one in (*spec.waiting, *spec.patterns, *spec.retry)]
    for name in tuning:
        if name not in known:
            choices = ", ".join(dict.fromkeys(known))
            raise RepertoireError(f"{spec.tag} has no pattern {name}; it has {choices}")

    def group(patterns: Sequence[Template]) -> tuple[Template, ...]:
        return tuple(_overridden(spec, one, tuning.get(_name(one), {})) for one in patterns)

    return spec.model_copy(
        update={slot: group(getattr(spec, slot)) for slot in ("waiting", "patterns", "retry")}
    )


def parameters(spec: PacketSpec) -> dict[str, dict[str, float]]:
    """Every number of the packet's patterns, defaults included, by pattern and parameter."""
    templates = [*spec.waiting, *spec.patterns, *spec.retry]
    patterns = behaviour_patterns().validate_python([filled(one, spec.defaults()) for one in templates])
    return {f"{one.dof}/{one.name}": dict(_numbers(one)) for one in patterns}


def _numbers(pattern: BehaviourPattern) -> Iterator[tuple[str, float]]:
    for part in PARTS:
        word = getattr(pattern, part)
        for field in fields(word):
            value = getattr(word, field.name)
            if isinstance(value, int | float) and not isinstance(value, bool):
                yield f"{part}.{field.name}", value


def _name(pattern: Template) -> str:
    return f"{pattern['dof']}/{pattern['name']}"


def _overridden(spec: PacketSpec, pattern: Template, values: Mapping[str, float]) -> Template:
    for key, value in values.items():
        where = f"{spec.tag}: {_name(pattern)}: {key} = {value}"
        part, _, parameter = key.partition(".")
        if part not in PARTS or not parameter:
            raise RepertoireError(f"{where}: a parameter is named {', '.join(f'{one}.X' for one in PARTS)}")
        pattern = {**pattern, part: {**pattern[part], parameter: value}}
        try:
            behaviour_patterns().validate_python([filled(pattern, spec.defaults())])
        except ValidationError as error:
            raise RepertoireError(f"{where}: {error.errors()[0]['msg']}") from None
    return pattern
