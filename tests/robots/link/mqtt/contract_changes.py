"""What a change of the contract's schemas breaks: fields that are gone or newly required, types that differ."""

from collections.abc import Iterator, Mapping
from typing import Any

Schema = Mapping[str, Any]
SAID = (
    "type",
    "enum",
    "const",
    "items",
    "anyOf",
    "oneOf",
    "$ref",
    "additionalProperties",
    "pattern",
    "format",
)
"""What a value may be."""
LIMITS = {
    "minimum": 1,
    "exclusiveMinimum": 1,
    "minLength": 1,
    "minItems": 1,
    "maximum": -1,
    "exclusiveMaximum": -1,
    "maxLength": -1,
    "maxItems": -1,
}
"""Limits, with the direction that narrows."""


def breaking_changes(old: Mapping[str, Schema], new: Mapping[str, Schema]) -> list[str]:
    """What the newer schemas, by name, no longer accept or promise, in words."""
    found: list[str] = []
    for name, schema in old.items():
        if name not in new:
            found.append(f"{name} is gone")
            continue
        found += _changes(name, schema, new[name])
        for part, definition in schema.get("definitions", {}).items():
            others = new[name].get("definitions", {})
            if part not in others:
                found.append(f"{name}: {part} is gone")
            else:
                found += _changes(f"{name}: {part}", definition, others[part])
    return found


def _changes(where: str, old: Schema, new: Schema) -> Iterator[str]:
    for field, before in old.get("properties", {}).items():
        after = new.get("properties", {}).get(field)
        if after is None:
            yield f"{where}.{field} is gone"
        else:
            yield from _differences(f"{where}.{field}", before, after)
    for field in sorted(set(new.get("required", ())) - set(old.get("required", ()))):
        yield f"{where}.{field} is required"
    yield from _differences(where, old, new)


def _differences(where: str, old: Schema, new: Schema) -> Iterator[str]:
    for word in SAID:
        if old.get(word) != new.get(word):
            yield f"{where}: {word} differs"
    if old.get("default") != new.get("default"):
        yield f"{where}: default differs"
    for word, direction in LIMITS.items():
        before, after = old.get(word), new.get(word)
        if after is not None and (before is None or (after - before) * direction > 0):
            yield f"{where}: {word} is narrower"
