"""Loads a world by its name (the ones shipped here) or from a YAML file."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from importlib import resources
from pathlib import Path

import yaml
from pydantic import ValidationError

from robots.data import faults_in, place_in, read_yaml
from robots.errors import RobotError
from robots.wire import PacketTunings
from robots.world.file import WorldFile
from robots.world.rule_files import put_in_rules


class WorldFileError(ValueError):
    """Raised when a world file is missing, not YAML, or not a valid world; the message says what and where.

    :param faults: what does not fit, each with its place in the file; none if it cannot be read at all.
    """

    def __init__(self, message: str, faults: Iterable[str] = ()) -> None:
        self.faults = tuple(faults)
        lines = (f"  {fault}" for fault in self.faults)
        super().__init__("\n".join([message, *lines]))


def shipped_worlds() -> dict[str, Path]:
    """The files of the worlds that ship with Macta, by name."""
    with resources.as_file(resources.files("robots.world") / "files") as folder:
        return {path.stem: path for path in sorted(folder.glob("*.yaml"))}


def named_worlds() -> list[str]:
    """The names of the worlds that ship with Macta."""
    return sorted(shipped_worlds())


def load_world(
    name_or_file: str | Path,
    *,
    worlds: Mapping[str, Path] | None = None,
    tags: Collection[str] | None = None,
    check_tuning: Callable[[PacketTunings], object] | None = None,
    check_rules: Callable[[Mapping[str, str]], object] | None = None,
) -> WorldFile:
    """Read and check a world.

    :param worlds: the files of the worlds that have names; None: of those that ship with Macta.
    :param tags: those that robots' repertoires may name; None: any.
    :param check_tuning: called with the `tuning` of each robot that has one; raises a `RobotError` if it is not valid.
    :param check_rules: the same of its `rules`.

    :raises WorldFileError: naming the file, the slot and the choices.
    """
    text, origin, folder = _read(str(name_or_file), shipped_worlds() if worlds is None else worlds)
    return read_world(
        text, origin, tags=tags, check_tuning=check_tuning, check_rules=check_rules, folder=folder
    )


def read_world(
    text: str,
    origin: str,
    *,
    tags: Collection[str] | None = None,
    check_tuning: Callable[[PacketTunings], object] | None = None,
    check_rules: Callable[[Mapping[str, str]], object] | None = None,
    folder: Path | None = None,
) -> WorldFile:
    """The world that a text describes, in YAML or JSON, checked; `tags` and `check_...` as of `load_world`.

    :param origin: what messages call the text.
    :param folder: what the paths of rule files are relative to; None: it may have none.
    :raises WorldFileError: naming the origin, the slot and the choices.
    """
    try:
        data = read_yaml(text)
    except yaml.YAMLError as error:
        raise WorldFileError(f"{origin} is not YAML: {error}") from error
    except ValueError as error:
        raise WorldFileError(f"{origin} cannot be read: {error}") from error
    if not isinstance(data, dict):
        raise WorldFileError(f"{origin} does not contain a mapping of world properties")
    if faults := put_in_rules(data, text, folder):
        raise _invalid(origin, faults)
    try:
        world = WorldFile.model_validate(data)
    except ValidationError as error:
        raise _invalid(origin, faults_in(text, error)) from error
    if stray := [why for zone in world.zones if (why := zone.misplaced(world.compartments))]:
        raise _invalid(origin, (f"zones.{why}" for why in stray))
    if tags is not None and (faults := list(_unknown_tags(world, tags, text))):
        raise _invalid(origin, faults)
    for robot in world.robots:
        try:
            if robot.tuning and check_tuning is not None:
                check_tuning(robot.tuning)
        except RobotError as error:
            raise _invalid(origin, [f"robots.{robot.name}.tuning: {error}"]) from error
        try:
            if robot.rule_files and check_rules is not None:
                check_rules(robot.rule_files)
        except RobotError as error:
            raise _invalid(origin, [f"robots.{robot.name}.rules: {error}"]) from error
    return world


def _invalid(origin: str, faults: Iterable[str]) -> WorldFileError:
    return WorldFileError(f"{origin} is not a valid world:", faults)


def _unknown_tags(world: WorldFile, tags: Collection[str], text: str) -> Iterator[str]:
    choices = ", ".join(sorted(tags)) or "none"
    for robot in world.robots:
        role = robot.role
        for index, tag in enumerate((role.tags or ()) if role is not None else ()):
            if tag not in robot.repertoire:
                slot = ("robots", robot.name, "role", "tags", str(index))
                own = ", ".join(robot.repertoire)
                yield place_in(text, slot, f"{robot.name} has no packet {tag!r}; its packets: {own}")
        for index, tag in enumerate(robot.repertoire):
            if tag not in tags:
                where = ("robots", robot.name, "repertoire", str(index))
                yield place_in(
                    text, where, f"no packet of a repertoire has the tag {tag!r}; choices: {choices}"
                )


def _read(name: str, worlds: Mapping[str, Path]) -> tuple[str, str, Path]:
    """A world's text, what messages call it, and its folder."""
    path = worlds.get(name, Path(name))
    if not path.is_file():
        raise WorldFileError(f"no world or file {name!r}; worlds: {', '.join(sorted(worlds))}")
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise WorldFileError(f"{path} cannot be read: {error}") from error
    return text, f"world {name}" if name in worlds else str(path), path.parent
