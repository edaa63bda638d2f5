"""Coordination of the processes that share a database: heartbeats, and leases of worlds.

Each process writes a heartbeat every `HEARTBEAT_S`. A process without one for `DEAD_AFTER_S`, or one that has ended,
counts as dead: the others take over its workflows and its leases of worlds. Time is the database server's, so the
machines' clocks need not agree. A process that was only suspended may continue: its leases have lapsed by then and it
dequeues nothing, and what both processes did meanwhile is recorded once, for every step finds in the record what is
done. While the server is unavailable, no process can write a heartbeat: silence counts from when the server is
available again.
"""

import logging
import os
import socket
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any, Protocol

from sqlalchemy import delete, func, select
from sqlalchemy.dialects.postgresql import insert
from sqlalchemy.orm import Session

from app.domain.clock import SYSTEM_CLOCK, WallClock, iso_utc
from app.domain.errors import Unavailable
from app.domain.heartbeats import DEAD_AFTER_S, HEARTBEAT_S
from app.store import Database, ExecutorRow, LeaseRow, is_unavailable
from app.workflows.background import Background

FORGOTTEN_AFTER_S = 60.0
"""A dead process's row is deleted after this. Until then it is checked again: it may have continued and ended again."""
LEASE_S = DEAD_AFTER_S - HEARTBEAT_S
"""How long after a heartbeat a process uses its leases and dequeues workflows; others take over later than that."""
ENDED_AT_S = 0.0
"""`seen_at` of a process that has ended regularly."""
LOST_CHECK_S = 5.0
"""Interval of a process's checks for its own lost workflows."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Executor:
    """A process as registered in the database.

    :param serves: the queues whose workflows it runs.
    :param worlds: those whose lease it holds.
    :param seen_s: seconds since its last heartbeat.
    :param planning: what its planning processes do, as of then; None if it has none.
    :param packs: the digests of its domain packs, by name; None of an earlier version.
    """

    id: str
    serves: Sequence[str]
    worlds: Sequence[str]
    host: str
    pid: int
    started_at: str
    seen_s: float
    alive: bool
    planning: Mapping[str, Any] | None = None
    packs: Mapping[str, str] | None = None


class RecoverableWorkflows(Protocol):
    """The workflows of this process and of others; `app.workflows.Workflows` implements it."""

    @property
    def executor(self) -> str:
        """The name of this process."""
        ...

    def dequeue_until(self, monotonic_s: float) -> None:
        """Dequeue nothing after that instant of the process's monotonic clock."""
        ...

    def recover_executor(self, session: Session, executor: str) -> int:
        """Recover the workflows that a dead executor left pending; returns their number.

        The processes that can run them are notified when the session's transaction commits.
        """
        ...

    def recover_lost(self) -> int:
        """Recover the workflows that this process has lost; returns their number."""
        ...


class ExecutorRegistry:
    """Writes this process's heartbeat, holds the leases of its worlds, and recovers workflows of dead processes.

    On SQLite there is only one process: it always holds its leases, and needs no heartbeat.
    """

    def __init__(
        self,
        database: Database,
        workflows: RecoverableWorkflows,
        *,
        serves: Sequence[str],
        worlds: Collection[str],
        planning: Callable[[], Mapping[str, Any] | None] = lambda: None,
        packs: Mapping[str, str] | None = None,
        clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """
        :param serves: the queues whose workflows this process runs.
        :param worlds: those whose leases this process may hold; read again for each heartbeat.
        :param planning: what this process's planning processes do now, for JSON.
        :param packs: the digests of its domain packs, by name.
        """
        self._database = database
        self._workflows = workflows
        self._serves = list(serves)
        self._executor = workflows.executor
        self._worlds = worlds
        self._planning = planning
        self._packs = packs
        self._clock = clock
        self._lost_check_at_s = 0.0
        self._started_at = iso_utc(clock.epoch_s())
        self._leases_until: Mapping[str, float] = {}
        self._background = Background("heartbeat", self._run)

    def register(self, simulates: Collection[str] = ()) -> None:
        """Write the first heartbeat, before this process begins anything that others would have to recover.

        :param simulates: the worlds that exist only in this process, so that no other process may hold their leases.
            This waits for the lease of a process that has just ended to lapse.
        :raises Unavailable: if a running process holds such a lease.
        """
        give_up_s = self._clock.monotonic_s() + DEAD_AFTER_S + 2 * HEARTBEAT_S
        while True:
            self.beat()
            others = [world for world in simulates if not self.holds_lease(world)]
            if not others:
                return
            if self._clock.monotonic_s() > give_up_s:
                raise Unavailable(
                    f"another process on this database drives world {', '.join(others)}; "
                    "give this one a database of its own, or reach the world's robots over --broker"
                )
            self._clock.wait(self._background.ending, HEARTBEAT_S)

    def start(self) -> None:
        if self._database.shared:
            self._background.start()

    def stop(self) -> None:
        """Stop heartbeats and recovery, because this process is about to end. Safe to call again."""
        self._background.end()

    def close(self) -> None:
        """Record the end of this process, so that others recover its workflows at once."""
        if not self._background.end():
            return
        try:
            with self._database.write() as session:
                row = session.get(ExecutorRow, self._executor, with_for_update=True)
                if row is not None:
                    row.seen_at = ENDED_AT_S
        except Exception as error:  # the others take over after `DEAD_AFTER_S`
            logger.warning(
                "could not record the end of this process, its work is taken over after a delay: %s", error
            )

    def holds_lease(self, world: str) -> bool:
        """True if this process, and no other, is to deliver to the world's robots and to record what they report."""
        if not self._database.shared:
            return world in self._worlds
        return self._clock.monotonic_s() < self._leases_until.get(world, 0.0)

    def executors(self) -> Sequence[Executor]:
        """All known processes, the oldest first."""
        return [
            replace(one, planning=self._planning()) if one.id == self._executor else one
            for one in executors(self._database, self._clock)
        ]

    def beat(self) -> None:
        """Write a heartbeat, and take or renew the leases that no other running process holds."""
        until = self._clock.monotonic_s() + LEASE_S
        planning = self._planning()
        with self._database.write() as session:
            now = _now(session, self._database, self._clock)
            row = session.get(ExecutorRow, self._executor, with_for_update=True)
            if row is None:
                row = ExecutorRow(id=self._executor)
                session.add(row)
            row.serves = self._serves
            row.host = socket.gethostname()
            row.pid = os.getpid()
            row.started_at = self._started_at
            row.seen_at = now
            row.planning = None if planning is None else dict(planning)
            row.packs = None if self._packs is None else dict(self._packs)
            session.flush()
            dead_before = _dead_before(session, self._database, now)
            worlds = sorted(self._worlds)
            held = [world for world in worlds if self._takes(session, world, dead_before)]
            here = LeaseRow.holder == self._executor
            session.execute(delete(LeaseRow).where(here, LeaseRow.world.not_in(worlds)))
        self._leases_until = dict.fromkeys(held, until)
        if self._database.shared:
            self._workflows.dequeue_until(until)

    def recover(self) -> None:
        """Recover the workflows of dead processes and, every `LOST_CHECK_S`, lost ones of this process."""
        self._recover_from_dead()
        if self._clock.monotonic_s() < self._lost_check_at_s:
            return
        self._lost_check_at_s = self._clock.monotonic_s() + LOST_CHECK_S
        if count := self._workflows.recover_lost():
            logger.warning("resumed %d workflows of this process that were no longer running", count)

    def _run(self) -> None:
        while not self._background.ending.is_set():
            try:
                self.beat()
                self.recover()
            except Exception as error:
                if is_unavailable(error):
                    logger.warning("heartbeat failed: database unavailable")
                else:
                    logger.exception("heartbeat failed")
            self._clock.wait(self._background.ending, HEARTBEAT_S)

    def _takes(self, session: Session, world: str, dead_before: float) -> bool:
        """Take or renew the lease of a world, unless another running process has it."""
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

    def _recover_from_dead(self) -> None:
        """Recover the workflows of dead processes; the first process to lock a dead one's row does."""
        with self._database.write() as session:
            now = _now(session, self._database, self._clock)
            query = select(ExecutorRow).where(
                ExecutorRow.seen_at < _dead_before(session, self._database, now)
            )
            for dead in session.scalars(query.with_for_update(skip_locked=True)).all():
                if count := self._workflows.recover_executor(session, dead.id):
                    logger.warning(
                        "took over %d workflows of executor %s on %s, which sends no heartbeat",
                        count,
                        dead.id,
                        dead.host,
                    )
                if dead.seen_at < now - FORGOTTEN_AFTER_S:
                    session.execute(delete(ExecutorRow).where(ExecutorRow.id == dead.id))


def executors(database: Database, clock: WallClock = SYSTEM_CLOCK) -> Sequence[Executor]:
    """The known processes on a database, the oldest first."""
    with database.read() as session:
        now = _now(session, database, clock)
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
        planning=row.planning if alive else None,
        packs=row.packs,
    )


def _now(session: Session, database: Database, clock: WallClock) -> float:
    """Epoch seconds, by the database server's clock if there is one."""
    if not database.shared:
        return clock.epoch_s()
    return float(session.scalars(select(func.extract("epoch", func.clock_timestamp()))).one())


def _dead_before(session: Session, database: Database, now: float) -> float:
    """The instant: a process last seen before it is dead, silent for `DEAD_AFTER_S` while the server was up."""
    if not database.shared:
        return inf  # there is one process
    started_at = session.scalars(select(func.extract("epoch", func.pg_postmaster_start_time()))).one()
    if float(started_at) < now - DEAD_AFTER_S:
        return now - DEAD_AFTER_S
    return ENDED_AT_S + 1.0  # the server has just started: only those that have ended regularly are dead
