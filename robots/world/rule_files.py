"""Rule files that a world file names for its robots: shipped ones by name, others by a path relative to the file."""

from importlib import resources
from pathlib import Path
from typing import Any

from robots.data import place_in

SUFFIX = ".rules"


def shipped_rules() -> dict[str, Path]:
    """The rule files that ship with Macta, by name."""
    with resources.as_file(resources.files("robots.deliberative") / "files") as folder:
        return {path.stem: path for path in sorted(folder.glob(f"*{SUFFIX}"))}


def put_in_rules(data: dict[str, Any], text: str, folder: Path | None) -> list[str]:
    """Replace the names in robots' `rules`, and in their roles', by the texts of the files.

    Returns what cannot be read, each with its place.

    :param data: of a world file. :param text: what it was read from.
    :param folder: what paths are relative to; None: there is none, so paths are faults.
    """
    faults = []
    robots = data.get("robots")
    for index, robot in enumerate(robots if isinstance(robots, list) else ()):
        role = robot.get("role") if isinstance(robot, dict) else None
        named = role.get("rules") if isinstance(role, dict) else None
        if isinstance(role, dict) and isinstance(named, str) and len(named.split()) == 1:
            try:
                role["rules"] = _file(named, folder).read_text(encoding="utf-8")
            except (OSError, ValueError) as error:
                faults.append(place_in(text, ("robots", str(index), "role", "rules"), f"{named}: {error}"))
        names = robot.get("rules") if isinstance(robot, dict) else None
        if not isinstance(names, list) or not all(isinstance(one, str) for one in names):
            continue
        texts: dict[str, str] = {}
        for number, name in enumerate(names):
            try:
                path = _file(name, folder)
                if path.stem in texts:
                    raise ValueError(f"two files are called {path.stem}")
                texts[path.stem] = path.read_text(encoding="utf-8")
            except (OSError, ValueError) as error:  # a text that is not UTF-8 is a ValueError
                faults.append(
                    place_in(text, ("robots", str(index), "rules", str(number)), f"{name}: {error}")
                )
        robot["rules"] = texts
    return faults


def _file(name: str, folder: Path | None) -> Path:
    """:raises ValueError: if there is none, with the choices."""
    if name.endswith(SUFFIX):
        if folder is None:
            raise ValueError(
                "a path, which only the file of a world that is given at the start may have; give the texts by name"
            )
        return folder / name
    shipped = shipped_rules()
    if name not in shipped:
        raise ValueError(
            f"no shipped rule file; choices: {', '.join(shipped) or 'none'}, or a path that ends in {SUFFIX}"
        )
    return shipped[name]
