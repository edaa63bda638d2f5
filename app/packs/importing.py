"""Worlds from files of other formats, which installed packages read."""

from pathlib import Path
from typing import Any

from pydantic import ValidationError

from app.domain.errors import Invalid
from app.packs.errors import PackError
from robots.errors import ExtensionError
from robots.extensions import IMPORTERS, described, installed, load_extension
from robots.world import WorldFile


def imported_world(kind: str, file: Path) -> WorldFile:
    """The world that a package's importer makes of a file.

    :raises PackError: if there is no such importer, or it cannot be used or makes no valid world.
    :raises Invalid: if it cannot read the file.
    """
    try:
        importer = load_extension(IMPORTERS, kind)
        choices = sorted(installed(IMPORTERS))
    except ExtensionError as error:
        raise PackError(str(error)) from error
    if importer is None:
        raise PackError(f"no importer {kind!r}; choices: {', '.join(choices) or 'none is installed'}")
    source = f"{IMPORTERS}: {kind} ({described(installed(IMPORTERS)[kind])})"
    try:
        made: Any = importer(file)
    except (OSError, ValueError) as error:
        raise Invalid(f"{file} cannot be imported as {kind}: {error}") from error
    try:
        return WorldFile.model_validate(made)
    except ValidationError as error:
        slots = "\n".join(f"  {'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors())
        raise PackError(f"{source} makes no valid world of {file}:\n{slots}") from error
