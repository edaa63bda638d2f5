"""Loads a world by its name (the ones shipped here) or from a YAML file."""

from collections.abc import Callable
from importlib import resources
from pathlib import Path

import yaml
from pydantic import ValidationError

from robots.data import read_yaml
from robots.errors import RobotError
from robots.wire import PacketTunings
from robots.world.file import WorldFile


class WorldFileError(ValueError):
    """Raised when a world file is missing, not YAML, or not a valid world; the message says what and where."""


def named_worlds() -> list[str]:
    """The names of the worlds that ship with Macta."""
    folder = resources.files("robots.world") / "files"
    return sorted(
        entry.name.removesuffix(".yaml") for entry in folder.iterdir() if entry.name.endswith(".yaml")
    )


def load_world(
    name_or_file: str | Path, *, check_tuning: Callable[[PacketTunings], object] | None = None
) -> WorldFile:
    """Read and check a world.

    :param check_tuning: called with the `tuning` of each robot that has one; raises a `RobotError` if it is not valid.

    :raises WorldFileError: naming the file, the slot and the choices.
    """
    text, origin = _read(str(name_or_file))
    try:
        data = read_yaml(text)
    except yaml.YAMLError as error:
        raise WorldFileError(f"{origin} is not YAML: {error}") from error
    if not isinstance(data, dict):
        raise WorldFileError(f"{origin} holds no mapping of world properties")
    try:
        world = WorldFile.model_validate(data)
    except ValidationError as error:
        slots = [f"  {'.'.join(map(str, e['loc'])) or 'world'}: {e['msg']}" for e in error.errors()]
        raise WorldFileError("\n".join([f"{origin} is not a valid world:", *slots])) from error
    if check_tuning is not None:
        _check_tunings(world, check_tuning, origin)
    return world


def _check_tunings(world: WorldFile, check_tuning: Callable[[PacketTunings], object], origin: str) -> None:
    for robot in world.robots:
        if robot.tuning:
            try:
                check_tuning(robot.tuning)
            except RobotError as error:
                raise WorldFileError(
                    f"{origin} is not a valid world:\n  robots.{robot.name}.tuning: {error}"
                ) from error


def _read(name: str) -> tuple[str, str]:
    if name in named_worlds():
        return (resources.files("robots.world") / "files" / f"{name}.yaml").read_text(), f"world {name}"
    path = Path(name)
    if not path.is_file():
        raise WorldFileError(f"no world or file {name!r}; worlds: {', '.join(named_worlds())}")
    try:
        return path.read_text(encoding="utf-8"), str(path)
    except (OSError, UnicodeDecodeError) as error:
        raise WorldFileError(f"{path} cannot be read: {error}") from error
