"""A process' place among those that share its database.

Each says every `BEAT_S` that it lives. Of one that was silent for `DEAD_AFTER_S`, or has ended, the others take over
the workflows, and the worlds it spoke for. Time is the database server's, so the machines' clocks need not agree. A
process that was only held up may come back: it lays down by itself what it can no longer be sure of, takes up nothing
more, and what both did meanwhile is recorded once, as steps and messages are anyway. While the server is away nobody
can say anything: it counts from when the server is back.
"""

import logging
import os
import socket
import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Protocol

from sqlalchemy import delete, func, select
from sqlalchemy.dialects.postgresql import insert
from sqlalchemy.orm import Session

from app.domain.errors import Unavailable
from app.store import Database, ExecutorRow, LeaseRow, is_away
from app.store.tables import utc_now
from app.workflows.background import Background

BEAT_S = 1.0
DEAD_AFTER_S = 6.0
FORGOTTEN_AFTER_S = 60.0
"""A dead process' row goes then; until then it is looked whether it came back, began something, and died again."""
HELD_S = DEAD_AFTER_S - BEAT_S
"""So long after its last beat a process counts on its worlds, and takes up workflows: less than it takes others to take
them.
"""
ENDED = 0.0
"""When a process that has ended in order was last seen."""
TAKE_UP_S = 5.0
"""How often a process looks for workflows of its own that it has lost."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Executor:
    """A process as the others know it.

    :param serves: the queues whose workflows it runs; `worlds` those it speaks for, towards their robots.
    :param seen_s: seconds since it last said that it lives.
    """

    id: str
    serves: Sequence[str]
    worlds: Sequence[str]
    host: str
    pid: int
    started_at: str
    seen_s: float
    alive: bool


class Undone(Protocol):
    """Workflows that a process has left undone, and who that is."""

    @property
    def executor(self) -> str:
        """The name of this process."""
        ...

    def may_begin(self, until: float) -> None:
        """Others count on this process until that instant (`time.monotonic`): it may take up workflows till then."""
        ...

    def take_over(self, executor: str) -> int:
        """Have those of a dead executor run again; answers how many."""
        ...

    def take_up(self) -> int:
        """Have those run again that this process has lost; answers how many."""
        ...


class ExecutorRegistry:
    """Says that this process lives, holds the worlds it speaks for, and takes over what dead ones left.

    On SQLite there is one process: it holds its worlds always, and nothing needs to be said.
    """

    def __init__(
        self,
        database: Database,
        workflows: Undone,
        *,
        serves: Sequence[str],
        speaks_for: Collection[str],
    ) -> None:
        """
        :param speaks_for: the worlds that this process may speak for.
        """
        self._database, self._workflows, self._serves = database, workflows, list(serves)
        self._executor = workflows.executor
        self._speaks_for = sorted(speaks_for)
        self._take_up_at = 0.0
        self._started_at = utc_now()
        self._held: Mapping[str, float] = {}
        self._background = Background("presence", self._run)

    def register(self, simulates: Collection[str] = ()) -> None:
        """Say that this process lives, before it begins anything that others would have to take over.

        :param simulates: the worlds that there are only here: nobody else is to speak for them. Waited for, should a
            process that has just died have done so.
        :raises Unavailable: if one that lives does.
        """
        give_up = time.monotonic() + DEAD_AFTER_S + 2 * BEAT_S
        while True:
            self._beat()
            others = [world for world in simulates if not self.speaks_for(world)]
            if not others:
                return
            if time.monotonic() > give_up:
                raise Unavailable(
                    f"another process on this database has world {', '.join(others)}; "
                    "give this one a database of its own, or reach the world's robots over --broker"
                )
            self._background.ending.wait(BEAT_S)

    def start(self) -> None:
        if self._database.shared:
            self._background.start()

    def stop(self) -> None:
        """Look after nobody any more; this process is about to end. Safe to call again."""
        self._background.end()

    def close(self) -> None:
        """What is left undone here is the others' from now on."""
        if not self._background.end():
            return
        try:
            with self._database.write() as session:
                row = session.get(ExecutorRow, self._executor, with_for_update=True)
                if row is not None:
                    row.seen_at = ENDED
        except Exception as error:  # they will notice
            logger.warning("the others could not be told that this process ends: %s", error)

    def speaks_for(self, world: str) -> bool:
        """True if this process, and no other, is to deliver to the world's robots and to record what they report."""
        if not self._database.shared:
            return world in self._speaks_for
        return time.monotonic() < self._held.get(world, 0.0)

    def executors(self) -> Sequence[Executor]:
        """All that are known, the longest there first."""
        return executors(self._database)

    def _run(self) -> None:
        while not self._background.ending.is_set():
            try:
                self._beat()
                self._look_after_dead()
                self._look_after_own()
            except Exception as error:
                if is_away(error):
                    logger.warning("no word to the other processes: the database is away")
                else:
                    logger.exception("no word to the other processes")
            self._background.ending.wait(BEAT_S)

    def _beat(self) -> None:
        until = time.monotonic() + HELD_S
        with self._database.write() as session:
            now = _now(session, self._database)
            row = session.get(ExecutorRow, self._executor, with_for_update=True)
            if row is None:
                row = ExecutorRow(id=self._executor)
                session.add(row)
            row.serves, row.host, row.pid = self._serves, socket.gethostname(), os.getpid()
            row.started_at, row.seen_at = self._started_at, now
            session.flush()
            dead_before = _dead_before(session, self._database, now)
            held = [world for world in self._speaks_for if self._holds(session, world, dead_before)]
        self._held = dict.fromkeys(held, until)
        if self._database.shared:
            self._workflows.may_begin(until)

    def _holds(self, session: Session, world: str, dead_before: float) -> bool:
        """Take the world, unless a living process has it."""
        if self._database.shared:
            session.execute(insert(LeaseRow).values(world=world, holder="").on_conflict_do_nothing())
        elif session.get(LeaseRow, world) is None:
            session.add(LeaseRow(world=world, holder=""))
            session.flush()
        lease = session.get_one(LeaseRow, world, with_for_update=True)
        if lease.holder != self._executor:
            holder = session.get(ExecutorRow, lease.holder)
            if holder is not None and holder.seen_at >= dead_before:
                return False
            lease.holder = self._executor
        return True

    def _look_after_dead(self) -> None:
        """Take over from those that are silent; of several processes at once, one does."""
        with self._database.write() as session:
            now = _now(session, self._database)
            query = select(ExecutorRow).where(
                ExecutorRow.seen_at < _dead_before(session, self._database, now)
            )
            for dead in session.scalars(query.with_for_update(skip_locked=True)).all():
                if count := self._workflows.take_over(dead.id):
                    logger.warning("took over %d workflows of %s on %s", count, dead.id, dead.host)
                if dead.seen_at < now - FORGOTTEN_AFTER_S:
                    session.execute(delete(ExecutorRow).where(ExecutorRow.id == dead.id))

    def _look_after_own(self) -> None:
        if time.monotonic() < self._take_up_at:
            return
        self._take_up_at = time.monotonic() + TAKE_UP_S
        if count := self._workflows.take_up():
            logger.warning("took up %d workflows that were lost on their way here", count)


def executors(database: Database) -> Sequence[Executor]:
    """The processes on a database that are known, the longest there first."""
    with database.read() as session:
        now = _now(session, database)
        worlds: dict[str, list[str]] = {}
        for lease in session.scalars(select(LeaseRow).order_by(LeaseRow.world)):
            worlds.setdefault(lease.holder, []).append(lease.world)
        rows = session.scalars(select(ExecutorRow).order_by(ExecutorRow.started_at, ExecutorRow.id)).all()
    silences = {row.id: max(now - row.seen_at, 0.0) if database.shared else 0.0 for row in rows}
    return [_executor(row, worlds.get(row.id, ()), silences[row.id]) for row in rows]


def _executor(row: ExecutorRow, worlds: Sequence[str], seen_s: float) -> Executor:
    alive = seen_s < DEAD_AFTER_S
    return Executor(
        id=row.id,
        serves=row.serves,
        worlds=worlds if alive else (),
        host=row.host,
        pid=row.pid,
        started_at=row.started_at,
        seen_s=round(seen_s, 3),
        alive=alive,
    )


def _now(session: Session, database: Database) -> float:
    """Epoch seconds, of the server where there is one."""
    if not database.shared:
        return time.time()
    return float(session.scalars(select(func.extract("epoch", func.clock_timestamp()))).one())


def _dead_before(session: Session, database: Database, now: float) -> float:
    """Who was last seen before this instant is dead: it was silent for so long, and the server there to hear."""
    if not database.shared:
        return inf  # there is one process
    started_at = session.scalars(select(func.extract("epoch", func.pg_postmaster_start_time()))).one()
    if float(started_at) < now - DEAD_AFTER_S:
        return now - DEAD_AFTER_S
    return ENDED + 1.0  # until then only those are gone that said so
