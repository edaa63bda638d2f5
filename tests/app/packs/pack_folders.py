"""Pack folders for tests."""

from pathlib import Path

import yaml

from app.packs.scaffold import write_example


def example(folder: Path, name: str = "looks") -> Path:
    """The example pack."""
    write_example(name, folder / name)
    return folder / name


def bare(folder: Path, name: str, version: str = "1.0", **needs: str) -> Path:
    """A pack that holds nothing."""
    path = folder / name
    path.mkdir()
    (path / "pack.yaml").write_text(yaml.safe_dump({"name": name, "version": version, "needs": needs}))
    return path


def change(file: Path, right: str, wrong: str) -> None:
    text = file.read_text()
    assert right in text
    file.write_text(text.replace(right, wrong))
