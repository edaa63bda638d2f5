"""What a query is known not to find, so that services that look often ask the database only after a change."""

from collections.abc import Callable, Sequence
from typing import TypeVar

from sqlalchemy.orm import DeclarativeBase

from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.store.engine import Database

Found = TypeVar("Found")
KNOWN_FOR_S = 5.0
"""Wall-clock seconds after which a query is made again: the notification of another process's commit may be lost."""


class KnownEmpty:
    """The worlds for which a query has found nothing since its tables were written last. For one thread a world."""

    def __init__(
        self, database: Database, *tables: type[DeclarativeBase], clock: WallClock = SYSTEM_CLOCK
    ) -> None:
        """:param tables: all that the query reads."""
        self._database = database
        self._clock = clock
        self._writes = 0
        self._empty: dict[str, tuple[int, float]] = {}
        """By world, the writes before the query that found nothing, and when it was made."""
        database.watch(self._count, *tables)

    def forget(self, world: str) -> None:
        """Make the world's query at the next call."""
        self._empty.pop(world, None)

    def close(self) -> None:
        """Watch the tables no longer."""
        self._database.unwatch(self._count)

    def _count(self) -> None:
        self._writes += 1

    def read(self, world: str, query: Callable[[], Sequence[Found]]) -> Sequence[Found]:
        """What the query finds; it is not made while it is known to find nothing."""
        now_s = self._clock.monotonic_s()
        writes, made_s = self._empty.get(world, (None, now_s))
        if writes == self._writes and now_s < made_s + KNOWN_FOR_S:
            return ()
        before = self._writes
        found = query()
        if found:
            self._empty.pop(world, None)
        else:
            self._empty[world] = before, now_s
        return found
