"""Loads a world by its name (the ones shipped here) or from a YAML file."""

import re
from collections.abc import Callable, Sequence
from importlib import resources
from pathlib import Path

import yaml
from pydantic import ValidationError

from robots.data import LOADER, read_yaml
from robots.errors import RobotError
from robots.wire import PacketTunings
from robots.world.file import WorldFile

_SLOT = re.compile(r"[a-z]+(?:\.[A-Za-z0-9_]+)+")


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
    except ValueError as error:
        raise WorldFileError(f"{origin} cannot be read: {error}") from error
    if not isinstance(data, dict):
        raise WorldFileError(f"{origin} does not contain a mapping of world properties")
    try:
        world = WorldFile.model_validate(data)
    except ValidationError as error:
        slots = [f"  {place_in(text, e['loc'], e['msg'])}" for e in error.errors()]
        raise WorldFileError("\n".join([f"{origin} is not a valid world:", *slots])) from error
    if check_tuning is not None:
        _check_tunings(world, check_tuning, origin)
    return world


def place_in(text: str, slot: Sequence[str | int], message: str) -> str:
    """`line 31, robots.2.start: …`; a message that itself begins with a slot, `robots.fred starts …`, keeps it."""
    said = message.removeprefix("Value error, ")
    named = _SLOT.match(said)
    where = [str(part) for part in slot] or (named[0].split(".") if named else [])
    line = _line_of(text, where)
    name = f"{'.'.join(map(str, slot))}: " if slot else "" if named else "world: "
    return f"line {line}, {name}{said}"


def _line_of(text: str, where: Sequence[str]) -> int:
    """The line of the deepest part that is there; the parts of a list are named by number or by their `name`."""
    node = yaml.compose(text, Loader=LOADER)
    line = 1
    for part in where:
        children = _children(node)
        if part not in children:
            break
        node = children[part]
        line = node.start_mark.line + 1
    return line


def _children(node: yaml.Node | None) -> dict[str, yaml.Node]:
    if isinstance(node, yaml.MappingNode):
        return {str(key.value): value for key, value in node.value}
    if not isinstance(node, yaml.SequenceNode):
        return {}
    children: dict[str, yaml.Node] = {}
    for index, child in enumerate(node.value):
        children[str(index)] = child
        if isinstance(name := _children(child).get("name"), yaml.ScalarNode):
            children[name.value] = child
    return children


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
