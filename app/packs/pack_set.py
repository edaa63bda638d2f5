"""Several domain packs as one: what they hold, merged."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from yaml import YAMLError

from app.domain.mission_organiser import Library, LibraryError, load_library
from app.packs.errors import PackError
from app.packs.pack import Pack
from planner import KnowledgeBase, KnowledgeBaseError, merge_knowledge_bases
from robots.data import read_yaml
from robots.errors import RepertoireError
from robots.world import PERIPHERAL_TAGS

if TYPE_CHECKING:
    from app.domain.goal_language.verbs import Verbs
    from robots.repertoire import Repertoire


def difference(ours: Mapping[str, str], theirs: Mapping[str, str]) -> str:
    """Which packs of two processes differ, in words; empty if they have the same.

    :param ours, theirs: digests by the packs' names.
    """
    known = sorted(ours.keys() | theirs.keys())
    words = {
        name: "is another"
        if name in ours and name in theirs
        else "is missing"
        if name in ours
        else "is not here"
        for name in known
        if ours.get(name) != theirs.get(name)
    }
    return ", ".join(f"pack {name} {word}" for name, word in words.items())


@dataclass(frozen=True, slots=True)
class Packs:
    """The packs of a process, each after those that it needs.

    Spawned processes are given the files, `knowledge_bases` or `packets`, and read them again.
    """

    packs: tuple[Pack, ...]

    @property
    def knowledge_bases(self) -> tuple[Path, ...]:
        return tuple(path for pack in self.packs for path in pack.knowledge_bases)

    @property
    def libraries(self) -> tuple[Path, ...]:
        return tuple(path for pack in self.packs for path in pack.libraries)

    @property
    def packets(self) -> tuple[Path, ...]:
        return tuple(path for pack in self.packs for path in pack.packets)

    @property
    def names(self) -> str:
        return ", ".join(pack.name for pack in self.packs)

    def digests(self) -> Mapping[str, str]:
        """Each pack's digest by its name.

        :raises PackError: if a file cannot be read.
        """
        return {pack.name: pack.digest() for pack in self.packs}

    def worlds(self) -> Mapping[str, Path]:
        """The worlds' files by name.

        :raises PackError: if two packs have a world of the same name.
        """
        worlds: dict[str, Path] = {}
        for pack in self.packs:
            for name, path in pack.worlds.items():
                if worlds.setdefault(name, path) != path:
                    raise PackError(f"world {name} is in two packs: {worlds[name]}, and {path}")
        return worlds

    @property
    def default_world(self) -> str:
        """The world that is meant if none is named: the first of the last pack that has some.

        :raises PackError: if none has.
        """
        names = next((list(pack.worlds) for pack in reversed(self.packs) if pack.worlds), None)
        if names is None:
            raise PackError(f"no world is in the packs {self.names}; give --world")
        return names[0]

    @property
    def example(self) -> str:
        """A goal of the default world, as a sentence; empty if the pack of that world has none."""
        return next((pack.example for pack in reversed(self.packs) if pack.worlds), "")

    def knowledge_base(self) -> KnowledgeBase:
        """:raises PackError: naming the file, the line and the slot of what is wrong with it."""
        if not self.knowledge_bases:
            raise PackError(f"no knowledge base is in the packs {self.names}; most packs need `store`")
        try:
            return merge_knowledge_bases(self.knowledge_bases)
        except KnowledgeBaseError as error:
            raise PackError(str(error)) from error

    def tags(self) -> tuple[str, ...]:
        """The tags that robots may have; the packets' contents are not checked, and their software is not imported.

        :raises PackError: naming the file that is no YAML.
        """
        files = {path: self._mapping(path) for path in self.packets}
        return tuple(sorted({str(f["tag"]) for f in files.values() if "tag" in f and not f.get("basic")}))

    def _mapping(self, path: Path) -> Mapping[str, Any]:
        try:
            content = read_yaml(path.read_text())
        except (OSError, ValueError, YAMLError) as error:
            raise PackError(f"{path}: {error}") from error
        return content if isinstance(content, Mapping) else {}

    def repertoire(self) -> "Repertoire":
        """:raises PackError: naming the file, the line and the slot of what is wrong with it."""
        from robots.repertoire import read_repertoire  # here: `macta world validate` needs the tags only

        try:
            return read_repertoire(self.packets)
        except RepertoireError as error:
            raise PackError(str(error)) from error

    def verbs(self) -> "Verbs":
        """:raises PackError: naming the file, and the line or slot of what is wrong with it."""
        from app.domain.goal_language.verbs import Verbs, VerbsError, load_verbs  # here: as in `repertoire`

        verbs = Verbs({}, {})
        try:
            for pack in self.packs:
                for path in pack.verbs:
                    verbs = verbs.merged(load_verbs(path))
            verbs.check_predicates(self.knowledge_base().relation_names())
        except VerbsError as error:
            raise PackError(error.detail) from error
        return verbs

    def library(self) -> Library:
        """:raises PackError: naming the file, the line and the slot of what is wrong with it."""
        if not self.libraries:
            raise PackError(f"no behaviours library is in the packs {self.names}; most packs need `store`")
        repertoire = self.repertoire()
        tags = (*repertoire.tags, *repertoire.basic_tags, *PERIPHERAL_TAGS)
        try:
            return load_library(self.knowledge_base(), *self.libraries, tags=tags)
        except LibraryError as error:
            raise PackError(error.detail) from error
