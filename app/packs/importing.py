"""Worlds from files of other formats: maps of ROS, and what installed packages read."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from app.domain.errors import Invalid
from app.packs.errors import PackError
from robots.errors import ExtensionError
from robots.extensions import IMPORTERS, described, installed, load_extension
from robots.world import WorldFile
from robots.world.grid_world import ros_map_world

SHIPPED: Mapping[str, Callable[[Path], Any]] = {"ros_map": ros_map_world}
"""Macta's own importers, which packages cannot replace."""


def imported_world(kind: str, file: Path) -> WorldFile:
    """The world that an importer makes of a file.

    :raises PackError: if there is no such importer, or it cannot be used or makes no valid world.
    :raises Invalid: if it cannot read the file.
    """
    try:
        importer = SHIPPED.get(kind) or load_extension(IMPORTERS, kind)
        choices = sorted({*SHIPPED, *installed(IMPORTERS)})
    except ExtensionError as error:
        raise PackError(str(error)) from error
    if importer is None:
        raise PackError(f"no importer {kind!r}; choices: {', '.join(choices)}")
    source = kind if kind in SHIPPED else f"{IMPORTERS}: {kind} ({described(installed(IMPORTERS)[kind])})"
    try:
        made: Any = importer(file)
    except (OSError, ValueError) as error:
        raise Invalid(f"{file} cannot be imported as {kind}: {error}") from error
    try:
        return WorldFile.model_validate(made)
    except ValidationError as error:
        slots = "\n".join(f"  {'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors())
        raise PackError(f"{source} makes no valid world of {file}:\n{slots}") from error
