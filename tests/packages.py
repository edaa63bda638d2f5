"""Packages as an installer leaves them: modules and metadata in a folder of the module path."""

import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import invalidate_caches
from pathlib import Path

import pytest

from robots import extensions


def write_package(folder: Path, name: str, entry_points: str, files: Mapping[str, str]) -> Path:
    """An installed package in the folder.

    :param entry_points: the text of its `entry_points.txt`.
    :param files: their texts, by path.
    """
    metadata = folder / f"{name}-1.2.dist-info"
    texts = {
        metadata / "METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.2\n",
        metadata / "entry_points.txt": entry_points,
        **{folder / path: text for path, text in files.items()},
    }
    for path, text in texts.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def write_project(folder: Path, project: Path) -> Path:
    """A project of one package, as if it were installed in the folder; its files are copied, nothing is built."""
    described = tomllib.loads((project / "pyproject.toml").read_text())["project"]
    groups = described["entry-points"].items()
    lines = [
        line for group, names in groups for line in (f"[{group}]", *(f"{k} = {v}" for k, v in names.items()))
    ]
    name: str = described["name"]
    paths = [path for path in (project / name).rglob("*") if path.suffix in (".py", ".yaml")]
    files = {str(path.relative_to(project)): path.read_text() for path in paths}
    return write_package(folder, name, "\n".join(lines) + "\n", files)


@contextmanager
def installed(folder: Path) -> Iterator[None]:
    """The folder's packages are installed in this process within the block."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        forget()
        yield
    forget()


def forget() -> None:
    """Search the installed packages again at the next use."""
    invalidate_caches()
    extensions.installed.cache_clear()
    extensions.load_extension.cache_clear()
