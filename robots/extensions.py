"""Python that installed packages bring: looked up by name, at the first use of a name that Macta does not have itself.

A package registers an object under a group's name as an entry point (docs/packs.md). Nothing is imported, nor are the
installed packages searched, before data name it.
"""

from collections.abc import Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from robots.errors import ExtensionError

CONDITIONS = "macta.conditions"
STIMULI = "macta.stimuli"
RESPONSES = "macta.responses"
AVOIDANCES = "macta.avoidances"
BODIES = "macta.bodies"
SENSORS = "macta.sensors"
IMPORTERS = "macta.importers"
LINKS = "macta.links"


@cache
def installed(group: str) -> Mapping[str, EntryPoint]:
    """The entry points of a group, by name.

    :raises ExtensionError: if two packages have one of the same name.
    """
    found: dict[str, EntryPoint] = {}
    for entry in sorted(entry_points(group=group), key=lambda entry: entry.name):
        other = found.setdefault(entry.name, entry)
        if other.value != entry.value:
            raise ExtensionError(
                f"{group}: {entry.name} is both {described(other)} and {described(entry)}; uninstall one of them"
            )
    return found


def described(entry: EntryPoint) -> str:
    """Its value and the package that brings it."""
    package = entry.dist
    return entry.value if package is None else f"{entry.value} of {package.name} {package.version}"


@cache
def load_extension(group: str, name: str) -> Any:
    """The object that an installed package registered; None if none did.

    :raises ExtensionError: if it cannot be imported.
    """
    entry = installed(group).get(name)
    if entry is None:
        return None
    try:
        return entry.load()
    except Exception as error:
        raise ExtensionError(
            f"{group}: {name} cannot be loaded from {described(entry)}: {type(error).__name__}: {error}"
        ) from error


def load_class(group: str, name: str, base: type) -> Any:
    """The class that an installed package registered; None if none did.

    :raises ExtensionError: if it is no subclass of `base`.
    """
    found = load_extension(group, name)
    if found is not None and not (isinstance(found, type) and issubclass(found, base)):
        raise ExtensionError(
            f"{group}: {name} is {described(installed(group)[name])}, which is no subclass of "
            f"{base.__module__}.{base.__qualname__}"
        )
    return found
