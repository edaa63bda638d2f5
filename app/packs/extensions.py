"""The Python that installed packages add, by entry point."""

from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from pydantic import BaseModel

from app.packs.errors import PackError
from robots.errors import ExtensionError
from robots.extensions import (
    AVOIDANCES,
    BODIES,
    CONDITIONS,
    IMPORTERS,
    LINKS,
    RESPONSES,
    SENSORS,
    STIMULI,
    described,
    installed,
    load_class,
    load_extension,
)

PACKS = "macta.packs"
PREFIX = "macta."


class Extension(BaseModel):
    """Something that an installed package adds under a name; `source` is the object and its package."""

    group: str
    name: str
    source: str


def _condition() -> type:
    from robots.conditions.verdict import Condition

    return Condition


def _stimulus() -> type:
    from robots.reactive.stimuli import Stimulus

    return Stimulus


def _response() -> type:
    from robots.reactive.responses import Response

    return Response


def _avoidance() -> type:
    from robots.reactive.avoidance import AvoidanceMethod

    return AvoidanceMethod


def _body() -> type:
    from robots.world.bodies import PackageBodySpec

    return PackageBodySpec


def _sensor() -> type:
    from robots.world.sensors import PackageSensorSpec

    return PackageSensorSpec


BASES: Mapping[str, Callable[[], type]] = {
    CONDITIONS: _condition,
    STIMULI: _stimulus,
    RESPONSES: _response,
    AVOIDANCES: _avoidance,
    BODIES: _body,
    SENSORS: _sensor,
}
"""The groups of classes, and the class that each must be a subclass of."""
ENGINES = "macta.engines"
CALLED = (ENGINES, IMPORTERS, LINKS)
"""The groups of functions."""


def installed_extensions() -> Iterator[Extension]:
    """All but packs, in the order of groups and names.

    :raises PackError: if two packages register one name.
    """
    groups = sorted(group for group in entry_points().groups if group.startswith(PREFIX) and group != PACKS)
    try:
        for group in groups:
            for name, entry in installed(group).items():
                yield Extension(group=group, name=name, source=described(entry))
    except ExtensionError as error:
        raise PackError(str(error)) from error


def extension_faults(pack: str) -> Iterator[str]:
    """What is wrong with the Python that the package of an installed pack adds; none for other packs."""
    entry = installed(PACKS).get(pack)
    package = None if entry is None else entry.dist
    for one in () if package is None else package.entry_points:
        if one.group.startswith(PREFIX) and one.group != PACKS and (fault := _fault(one)):
            yield fault


def _fault(entry: EntryPoint) -> str | None:
    if entry.group not in (*BASES, *CALLED):
        choices = ", ".join(sorted((PACKS, *BASES, *CALLED)))
        return f"{described(entry)}: there is no group {entry.group}; choices: {choices}"
    try:
        if entry.group in CALLED:
            called = callable(load_extension(entry.group, entry.name))
            return (
                None
                if called
                else f"{entry.group}: {entry.name} is {described(entry)}, which cannot be called"
            )
        found: Any = load_class(entry.group, entry.name, BASES[entry.group]())
    except ExtensionError as error:
        return str(error)
    named = getattr(found, "variant_name", entry.name)
    return None if named == entry.name else f"{described(entry)}: register {entry.name} as {named}"
