"""Reads a command's settings and makes the data folder; errors name the option or variable."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from app.domain.errors import Invalid
from app.settings import Settings, make_folder


def settings_of(given: Mapping[str, Any], *, keeps_folder: bool = True) -> Settings:
    """The settings; options of the command override the environment.

    :param keeps_folder: make the data folder.
    :raises Invalid: naming the option or the variable, and what is wrong with it.
    """
    try:
        settings = Settings(**given)
    except ValidationError as error:
        wrong = (
            f"{_source(str(e['loc'][0]), given)}: {e['msg'].removeprefix('Value error, ')}"
            for e in error.errors()
        )
        raise Invalid("; ".join(wrong)) from error
    if keeps_folder:
        _make_folder(settings.data, _source("data", given))
    return settings


def _source(name: str, given: Mapping[str, Any]) -> str:
    option = {"broker_url": "broker", "packs": "pack"}.get(name, name)
    return f"--{option.replace('_', '-')}" if name in given else f"MACTA_{name.upper()}"


def _make_folder(folder: Path, source: str) -> None:
    try:
        make_folder(folder)
    except FileExistsError as error:
        raise Invalid(f"{source}: {folder} is a file, not a folder") from error
    except OSError as error:
        raise Invalid(f"{source}: the data folder {folder} cannot be made: {error.strerror}") from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise Invalid(f"{source}: the data folder {folder} is not writable")
