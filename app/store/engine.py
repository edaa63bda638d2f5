"""Database transactions.

On SQLite a write transaction takes the write lock at once (BEGIN IMMEDIATE), so that what it read is still true when
it writes; readers run concurrently (WAL). On PostgreSQL the caller locks the rows that it reads to change, in the order
goal, plan, mission, script, world, conversation, dialogue; and other processes are notified of what was written
(`announce`).
"""

import sqlite3
import uuid
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from hashlib import sha256
from pathlib import Path
from threading import Lock
from typing import Any

import psycopg
from pydantic_core import from_json
from sqlalchemy import (
    Connection,
    Engine,
    Executable,
    Function,
    Table,
    UpdateBase,
    create_engine,
    event,
    func,
    insert,
    make_url,
    select,
)
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.exc import DBAPIError, DisconnectionError, InterfaceError, OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeoutError
from sqlalchemy.orm import DeclarativeBase, Session
from sqlalchemy.pool import ConnectionPoolEntry, PoolProxiedConnection

from app.domain.clock import SYSTEM_CLOCK

CHANNEL = "macta"
"""The PostgreSQL notification channel of the processes that share a database."""
WRITTEN = "written"
"""The topic of every write transaction that appended an event."""
IN_ORDER = "in order"
"""The name of the lock under which rows that are numbered in commit order are written."""
TESTED_AFTER_S = 0.1
"""A pooled connection that was not used for this long (wall clock) is tested before its next use. No server can start
again in less time.
"""
STATEMENT_CANCELLED = "57014"
"""PostgreSQL's SQLSTATE of a cancelled statement: the server is available."""
POSTGRESQL_UNWRITABLE = ("53100", "25006")
"""PostgreSQL's SQLSTATEs for a full disk and for a read-only transaction."""
SQLITE_UNWRITABLE = (
    sqlite3.SQLITE_FULL,
    sqlite3.SQLITE_READONLY,
    sqlite3.SQLITE_IOERR,
    sqlite3.SQLITE_CANTOPEN,
)
"""SQLite's codes likewise, and for I/O errors."""
SQLITE_DAMAGED = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)
"""SQLite's codes for a file that is damaged or not a database."""


class Database:
    """The engine and its two kinds of transaction."""

    def __init__(self, url: str) -> None:
        self.url = url
        self.engine = _engine(url)
        # On PostgreSQL each statement of a transaction sees what is committed by then (READ COMMITTED), so that a
        # transaction adds two messages to the server to a read, and nothing else.
        self._reader = (
            self.engine.execution_options(isolation_level="AUTOCOMMIT") if self.shared else self.engine
        )
        self.name = uuid.uuid4().hex
        """Identifies this process among those that share the database."""
        self._turn: AbstractContextManager[object] = nullcontext() if self.shared else Lock()
        """Writers on SQLite queue here: SQLite's own wait polls ten times a second, and lets later ones overtake."""
        self.committed: list[Callable[[], None]] = []
        """Called after each committed write transaction of this process and, once notified, of other processes."""
        self.watching: list[tuple[frozenset[str], Callable[[], None]]] = []
        """Calls of `watch`, each with the names of its tables."""
        _note_written_tables(self.engine)

    @property
    def shared(self) -> bool:
        """True if other processes may use the database: PostgreSQL."""
        return self.engine.dialect.name != "sqlite"

    def watch(self, call: Callable[[], None], *tables: type[DeclarativeBase]) -> None:
        """Have a function called after each commit that wrote to one of these tables.

        After commits of other processes, whose tables are not known, it is always called, once notified.
        """
        self.watching.append((frozenset(table.__tablename__ for table in tables), call))

    def unwatch(self, call: Callable[[], None]) -> None:
        """Undo `watch`."""
        self.watching = [one for one in self.watching if one[1] != call]

    def written_elsewhere(self) -> None:
        """Another process has written."""
        for call in (*(call for _, call in self.watching), *self.committed):
            call()

    @contextmanager
    def write(self) -> Iterator[Session]:
        """A read-write transaction; commits at the end, rolls back on an exception."""
        with self._turn, self.engine.connect() as connection:
            written = connection.info[_WRITES] = []
            if connection.dialect.name == "sqlite":
                connection.exec_driver_sql("BEGIN IMMEDIATE")
            with Session(connection, expire_on_commit=False) as session:
                try:
                    yield session
                    session.flush()
                    self._write_last(session)
                except BaseException:
                    connection.rollback()
                    raise
                connection.commit()
        # First: what the others wake may ask what was written.
        for tables, call in self.watching:
            if not tables.isdisjoint(written):
                call()
        for call in (*self.committed, *session.info.get(_AFTER_COMMIT, ())):
            call()

    @contextmanager
    def read(self) -> Iterator[Session]:
        """A read-only view: consistent on SQLite, on PostgreSQL each statement for itself."""
        with self._reader.connect() as connection:
            if connection.dialect.name == "sqlite":
                connection.exec_driver_sql("BEGIN")
            with Session(connection, expire_on_commit=False) as session:
                yield session
            connection.rollback()

    def lock(self, session: Session, *names: str) -> None:
        """Hold the named locks until the end of the write transaction; on SQLite it excludes all others anyway.

        Locks of one kind are to be named in alphabetical order, so that no two transactions wait for each other.
        """
        if self.shared:
            session.connection().execute(select(*map(_lock, names)))

    def _write_last(self, session: Session) -> None:
        """Write the rows numbered in commit order and notify other processes; no lock is taken after this."""
        last = session.info.pop(_LAST, {})
        topics = {*session.info.pop(_TOPICS, ()), *([WRITTEN] if last else [])}
        connection = session.connection()
        if self.shared and topics:
            # One statement. Others get the notifications when the transaction commits.
            notify = (func.pg_notify(CHANNEL, f"{topic} {self.name}") for topic in sorted(topics))
            connection.execute(select(*([_lock(IN_ORDER)] if last else []), *notify))
        for table, rows in last.items():
            connection.execute(insert(table.__table__), rows)

    def close(self) -> None:
        self.engine.dispose()


# Keys of `Session.info`.
_AFTER_COMMIT = "after_commit"
_LAST = "last"
_TOPICS = "topics"
# Keys of a pooled connection's `info`.
_USED_S = "used_s"
_WRITES = "writes"


def count_writes(session: Session) -> int:
    """The number of statements by which the session's transaction has changed something so far."""
    if session.new or session.dirty or session.deleted:
        session.flush()
    return len(session.connection().info.get(_WRITES, ()))


def write_last(session: Session, table: type[DeclarativeBase], **values: Any) -> None:
    """Insert a row at the very end of the session's write transaction, so that rows are numbered in commit order.

    On PostgreSQL a transaction could otherwise commit after another one that got higher numbers.
    """
    session.info.setdefault(_LAST, {}).setdefault(table, []).append(values)


def _lock(name: str) -> Function[None]:
    key = int.from_bytes(sha256(f"macta {name}".encode()).digest()[:8], signed=True)
    return func.pg_advisory_xact_lock(key)


def announce(session: Session, topic: str) -> None:
    """Notify other processes of a topic when the session's write transaction commits."""
    session.info.setdefault(_TOPICS, set()).add(topic)


def is_unwritable(error: BaseException | None) -> bool:
    """True if the database cannot be written for now, e.g. because the disk is full; the transaction is rolled back."""
    if isinstance(error, DBAPIError):
        error = error.orig
    if isinstance(error, psycopg.Error):
        return error.sqlstate in POSTGRESQL_UNWRITABLE
    # The low byte of an extended error code is the primary code.
    return (
        isinstance(error, sqlite3.Error) and getattr(error, "sqlite_errorcode", 0) & 0xFF in SQLITE_UNWRITABLE
    )


def is_unavailable(error: BaseException) -> bool:
    """True if the database cannot be used for now, so that a retry makes sense.

    Its server does not answer or ended the connection (also after a deadlock), it cannot be written, or all of this
    process's connections have been in use for too long.
    """
    if is_unwritable(error) or isinstance(error, PoolTimeoutError):
        return True
    if not isinstance(error, DBAPIError) or not isinstance(error.orig, psycopg.Error):
        return False  # SQLite is always available
    ended = (
        isinstance(error, OperationalError | InterfaceError) and error.orig.sqlstate != STATEMENT_CANCELLED
    )
    return ended or error.connection_invalidated


def unusable_reason(error: BaseException) -> str | None:
    """The driver's message if the database is unavailable, damaged, or its URL cannot be connected to; else None."""
    if not isinstance(error, DBAPIError):
        return None
    damaged = getattr(error.orig, "sqlite_errorcode", 0) & 0xFF in SQLITE_DAMAGED
    if damaged or error.statement is None or is_unavailable(error):
        return str(error.orig).partition("\n")[0]
    return None


def after_commit(session: Session, call: Callable[[], None]) -> None:
    """Call a function of this process when the session's write transaction has committed."""
    session.info.setdefault(_AFTER_COMMIT, []).append(call)


def _engine(url: str) -> Engine:
    if not url.startswith("sqlite"):
        engine = create_engine(
            url,
            json_deserializer=from_json,
            pool_size=10,
            max_overflow=20,
            pool_use_lifo=True,
            connect_args={"connect_timeout": 5, "keepalives_idle": 10, "keepalives_interval": 5},
        )
        replace_broken_connections(engine)
        return engine
    if path := make_url(url).database:
        _make_private(Path(path))
    engine = create_engine(
        url,
        json_deserializer=from_json,
        pool_size=20,
        max_overflow=20,
        connect_args={"check_same_thread": False},
    )

    @event.listens_for(engine, "connect")
    def _prepare(connection: DBAPIConnection, _: ConnectionPoolEntry) -> None:
        # The driver would begin transactions itself, but too late: `Database` begins them.
        connection.isolation_level = None
        cursor = connection.cursor()
        for pragma in ("busy_timeout=30000", "journal_mode=WAL", "synchronous=NORMAL", "foreign_keys=ON"):
            cursor.execute(f"PRAGMA {pragma}")
        cursor.close()

    @event.listens_for(engine, "begin")
    def _do_not_begin(connection: Connection) -> None:
        """`Database` issues BEGIN."""

    return engine


def _note_written_tables(engine: Engine) -> None:
    """Note the table of each statement of a transaction that changes rows."""

    @event.listens_for(engine, "before_execute")
    def _note(connection: Connection, statement: Executable, *_: object) -> None:
        if isinstance(statement, UpdateBase) and isinstance(statement.table, Table):
            connection.info.setdefault(_WRITES, []).append(statement.table.name)


def replace_broken_connections(engine: Engine) -> None:
    """Replace a pooled connection that is broken, if it was not used lately; others are not asked for each use."""

    @event.listens_for(engine, "checkin")
    def _note(_: DBAPIConnection | None, entry: ConnectionPoolEntry) -> None:
        entry.info[_USED_S] = SYSTEM_CLOCK.monotonic_s()

    @event.listens_for(engine, "checkout")
    def _test(connection: DBAPIConnection, entry: ConnectionPoolEntry, _: PoolProxiedConnection) -> None:
        used_s = entry.info.get(_USED_S)
        if used_s is None or SYSTEM_CLOCK.monotonic_s() - used_s < TESTED_AFTER_S:
            return
        try:
            engine.dialect.do_ping(connection)
        except engine.dialect.loaded_dbapi.Error as error:
            raise DisconnectionError from error  # the pool makes a new one


def _make_private(path: Path) -> None:
    """Let only its owner read an SQLite database; SQLite gives new files beside it the same mode."""
    with suppress(OSError):  # SQLite's own error for the path is clearer
        path.touch(mode=0o600)
        for file in (path, path.with_name(f"{path.name}-wal"), path.with_name(f"{path.name}-shm")):
            if file.exists():
                file.chmod(0o600)
