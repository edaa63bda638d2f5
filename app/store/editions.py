"""The editions of the worlds that a process runs with: the newest of each, as every service reads it."""

import threading
from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

from sqlalchemy import func, select, tuple_
from sqlalchemy.orm import Session

from app.domain.errors import UnknownWorld
from app.store.engine import Database
from app.store.tables import AddedWorldRow, EditionRow
from robots.world import Edition, WorldFile, digest_of

Value = TypeVar("Value")
FILE_REPLACED = "the world file was replaced"


class WorldDirectory(Mapping[str, WorldFile]):
    """The newest edition of each world, by name, in the order in which they came. Thread-safe.

    Another process's changes are read at the next `follow`, or by `read` within a transaction.
    """

    def __init__(self, database: Database, files: Mapping[str, WorldFile]) -> None:
        self._database = database
        self._lock = threading.Lock()
        self._files = dict(files)
        self._newest = {name: Edition(0, file) for name, file in files.items()}
        self.renewed: list[Callable[[WorldFile], None]] = []
        """Called with a world's newest edition once it is known."""
        self.removed: list[Callable[[str], None]] = []
        """Called with the name of a world that no longer runs here."""
        self._has_changed = threading.Event()
        if database.shared:
            database.watch(self._has_changed.set, EditionRow)

    def __getitem__(self, name: str) -> WorldFile:
        return self.edition(name).world

    def __contains__(self, name: object) -> bool:
        return name in self._newest

    def __iter__(self) -> Iterator[str]:
        return iter(self._newest)

    def __len__(self) -> int:
        return len(self._newest)

    def edition(self, name: str) -> Edition:
        """The newest known edition of a world.

        :raises UnknownWorld: if there is none of that name.
        """
        try:
            return self._newest[name]
        except KeyError:
            raise UnknownWorld(name, self._newest) from None

    def refuse_unknown(self, name: str) -> None:
        """:raises UnknownWorld: if there is no world of that name."""
        self.edition(name)

    def file_digest(self, name: str) -> str:
        return digest_of(self._files[name])

    def put(self, edition: Edition) -> None:
        """Take an edition that was recorded, unless a newer one is known."""
        name = edition.world.name
        with self._lock:
            if name not in self._newest or edition.number <= self._newest[name].number:
                return
            self._newest = {**self._newest, name: edition}
        self._tell(edition.world)

    def add(self, file: WorldFile, edition: Edition) -> None:
        """Know a further world, as of its newest edition."""
        with self._lock:
            self._files = {**self._files, file.name: file}
            self._newest = {**self._newest, file.name: edition}
        self._tell(edition.world)

    def remove(self, name: str) -> None:
        """Know the world no longer."""
        with self._lock:
            self._files = _without(self._files, name)
            self._newest = _without(self._newest, name)
        for notify in self.removed:
            notify(name)

    def _tell(self, world: WorldFile) -> None:
        for notify in self.renewed:
            notify(world)

    def each(self, of: Callable[[WorldFile], Value]) -> Mapping[str, Value]:
        """By world, what a function makes of its newest edition."""
        each = _Each(self, of)
        self.removed.append(each.forget)
        return each

    def start(self, session: Session) -> None:
        """Take the recorded editions; of a world whose file was replaced since, record the file as the newest.

        The file counts also for a world that was added earlier, and brings back one that was removed.
        """
        for file in self._files.values():
            newest = newest_edition(session, file)
            added = session.get(AddedWorldRow, file.name)
            if newest.number and newest.world is file:
                session.add(file_edition(newest, actor=f"world file {file.name}", reason=FILE_REPLACED))
                if added is not None:
                    added.document = file.model_dump(mode="json")
            if added is not None and added.removed_at is not None:
                session.delete(added)
            self.put(newest)

    def follow(self) -> None:
        """Read the editions that other processes have recorded, if anything was written. Called often."""
        if self._has_changed.is_set():
            self._has_changed.clear()
            with self._database.read() as session:
                self.read(session)

    def read(self, session: Session) -> None:
        """Read the editions that are recorded."""
        query = select(EditionRow.world, func.max(EditionRow.edition)).group_by(EditionRow.world)
        known = self._newest
        numbers = [
            (world, number)
            for world, number in session.execute(query.where(EditionRow.world.in_(known)))
            if number > known[world].number
        ]
        if numbers:
            keys = tuple_(EditionRow.world, EditionRow.edition)
            for row in session.scalars(select(EditionRow).where(keys.in_(numbers))):
                self.put(_edition(row))


class _Each(Mapping[str, Value]):
    """Computed again for each new edition."""

    def __init__(self, worlds: WorldDirectory, of: Callable[[WorldFile], Value]) -> None:
        self._worlds = worlds
        self._of = of
        self._known: dict[str, tuple[WorldFile, Value]] = {}

    def __getitem__(self, name: str) -> Value:
        world = self._worlds[name]
        known = self._known.get(name)
        if known is None or known[0] is not world:
            known = self._known[name] = (world, self._of(world))
        return known[1]

    def __iter__(self) -> Iterator[str]:
        return iter(self._worlds)

    def __len__(self) -> int:
        return len(self._worlds)

    def forget(self, name: str) -> None:
        self._known.pop(name, None)


def _without(known: Mapping[str, Value], name: str) -> dict[str, Value]:
    return {one: value for one, value in known.items() if one != name}


def newest_edition(session: Session, file: WorldFile) -> Edition:
    """The world as the record has it; its file as a further edition if that is another than was recorded."""
    query = (
        select(EditionRow).where(EditionRow.world == file.name).order_by(EditionRow.edition.desc()).limit(1)
    )
    row = session.scalar(query)
    if row is None:
        return Edition(0, file)
    return _edition(row) if row.file_digest == digest_of(file) else Edition(row.edition + 1, file)


def _edition(row: EditionRow) -> Edition:
    return Edition(row.edition, WorldFile.model_validate(row.document))


def file_edition(edition: Edition, *, actor: str, reason: str) -> EditionRow:
    """The record of an edition that is a whole world file."""
    return EditionRow(
        world=edition.world.name,
        edition=edition.number,
        document=edition.world.model_dump(mode="json"),
        file_digest=digest_of(edition.world),
        edits=[],
        undo=[],
        actor=actor,
        reason=reason,
        at_s=0.0,
    )
