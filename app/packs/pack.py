"""One domain pack: what its folder holds, and the manifest that names it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Annotated

import yaml
from pydantic import Field, ValidationError

from app.packs.errors import PackError
from robots.data import Checked, faults_in, read_yaml

MANIFEST = "pack.yaml"
KNOWLEDGE_BASE = "knowledge_base.yaml"
LIBRARY = "behaviours_library.yaml"
VERBS = "verbs.yaml"
REPERTOIRE = "repertoire"
WORLDS = "worlds"

Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=64)]
Version = Annotated[str, Field(pattern=r"^\d{1,9}(\.\d{1,9}){0,3}$", coerce_numbers_to_str=True)]


class Manifest(Checked):
    """The file `pack.yaml`.

    `needs` are other packs with the least version of each, `example` is a goal of the first world.
    """

    name: Name
    version: Version
    about: str = Field(default="", max_length=400)
    example: str = Field(default="", max_length=400)
    needs: dict[Name, Version] = Field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Pack:
    """A pack and its files.

    :param place: what options name it by: its name if it is installed, else its folder.
    :param source: where it comes from, for people: a folder, or the package that brings it.
    :param worlds: files by name.
    """

    name: str
    version: str
    place: str
    source: str
    about: str = ""
    example: str = ""
    needs: Mapping[str, str] = field(default_factory=dict)
    knowledge_bases: tuple[Path, ...] = ()
    libraries: tuple[Path, ...] = ()
    packets: tuple[Path, ...] = ()
    verbs: tuple[Path, ...] = ()
    worlds: Mapping[str, Path] = field(default_factory=dict)

    def digest(self) -> str:
        """Of its name, version and files, wherever they lie; a change of any changes it.

        :raises PackError: if a file cannot be read.
        """
        seen = sha256(f"{self.name} {self.version}".encode())
        for slot in (self.knowledge_bases, self.libraries, self.packets, self.verbs, self.worlds.values()):
            for file in slot:
                try:
                    content = file.read_bytes()
                except OSError as error:
                    raise PackError(f"{file} cannot be read: {error.strerror}") from error
                seen.update(f"{file.name} {len(content)} ".encode() + content)
            seen.update(b";")
        return seen.hexdigest()[:16]

    def is_at_least(self, version: str) -> bool:
        return _numbers(self.version) >= _numbers(version)


def _numbers(version: str) -> tuple[int, ...]:
    """Without trailing zeros: 1.0 is 1."""
    numbers = [int(part) for part in version.split(".")]
    while numbers and numbers[-1] == 0:
        numbers.pop()
    return tuple(numbers)


def read_pack(folder: Path, shipped_as: str = "") -> Pack:
    """The pack in a folder; its files are found, not yet read.

    :param shipped_as: how it was installed, and so is named without its folder; empty: it was not.
    :raises PackError: if there is no valid manifest, or a YAML file that no part of a pack has the name of.
    """
    manifest = _manifest(folder / MANIFEST)
    try:
        _refuse_strangers(folder)
        return Pack(
            name=manifest.name,
            version=manifest.version,
            place=manifest.name if shipped_as else str(folder),
            source=shipped_as or str(folder),
            about=manifest.about,
            example=manifest.example,
            needs=manifest.needs,
            knowledge_bases=_present(folder / KNOWLEDGE_BASE),
            libraries=_present(folder / LIBRARY),
            packets=tuple(sorted((folder / REPERTOIRE).glob("*.yaml"))),
            verbs=_present(folder / VERBS),
            worlds={path.stem: path for path in sorted((folder / WORLDS).glob("*.yaml"))},
        )
    except OSError as error:
        raise PackError(f"{error.filename or folder} cannot be read: {error.strerror}") from error


def _manifest(file: Path) -> Manifest:
    try:
        text = file.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise PackError(f"{file.parent} is no domain pack: it has no {MANIFEST}") from error
    except (OSError, UnicodeDecodeError) as error:
        raise PackError(f"{file} cannot be read: {error}") from error
    try:
        return Manifest.model_validate(read_yaml(text))
    except ValidationError as error:
        faults = "\n".join(f"  {fault}" for fault in faults_in(text, error))
        raise PackError(f"{file} is not valid:\n{faults}") from error
    except (yaml.YAMLError, ValueError) as error:
        raise PackError(f"{file} cannot be read: {error}") from error


def _present(file: Path) -> tuple[Path, ...]:
    return (file,) if file.is_file() else ()


def _refuse_strangers(folder: Path) -> None:
    """:raises PackError: naming a YAML file or folder of them that would not be read."""
    known = (MANIFEST, KNOWLEDGE_BASE, LIBRARY, VERBS)
    choices = (*known, f"{REPERTOIRE}/*.yaml", f"{WORLDS}/*.yaml")
    for path in _yaml_files(folder):
        parts = path.relative_to(folder).parts
        fits = parts[0] in known if len(parts) == 1 else len(parts) == 2 and parts[0] in (REPERTOIRE, WORLDS)
        if not fits or path.suffix != ".yaml":
            raise PackError(
                f"{path} is no part of a domain pack, so that it would not be read", choices=choices
            )


def _yaml_files(folder: Path) -> Iterable[Path]:
    """Those of the folder and of its folders."""
    return sorted(
        path
        for pattern in ("*.yaml", "*.yml", "*/*.yaml", "*/*.yml")
        for path in folder.glob(pattern)
        if not path.relative_to(folder).parts[0].startswith(".")
    )
