"""Writes a new domain pack: a small one that works, to be changed."""

import re
from importlib import resources
from pathlib import Path

from app.packs import SHIPPED
from app.packs.errors import PackError

EXAMPLE = "example"
NAME = re.compile(r"[a-z][a-z0-9_]{0,63}")


def write_example(name: str, folder: Path) -> list[Path]:
    """Write the example pack under another name; returns the files.

    :raises PackError: if the name is none, or the folder cannot be written or has something in it.
    """
    if not NAME.fullmatch(name) or name in SHIPPED:
        raise PackError(
            f"{name!r} cannot be a pack's name: it needs small letters, digits and _, a letter first, and no pack "
            f"but those of Macta is named {' or '.join(SHIPPED)}"
        )
    try:
        if folder.exists() and any(folder.iterdir()):
            raise PackError(f"{folder} is not empty; choose another --folder")
        return list(_written(name, folder))
    except OSError as error:
        raise PackError(f"{error.filename or folder} cannot be written: {error.strerror}") from error


def _written(name: str, folder: Path) -> list[Path]:
    written = []
    with resources.as_file(resources.files("app.packs") / EXAMPLE) as example:
        for file in sorted(example.rglob("*.yaml")):
            path = folder / str(file.relative_to(example)).replace(EXAMPLE, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            text = file.read_text(encoding="utf-8")
            path.write_text(_renamed(text, name), encoding="utf-8")
            written.append(path)
    return written


def _renamed(text: str, name: str) -> str:
    return text.replace(f"name: {EXAMPLE}", f"name: {name}")
