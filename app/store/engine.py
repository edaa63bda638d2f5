"""Transactions on the record.

On SQLite a write transaction takes the write lock at once (BEGIN IMMEDIATE), so that what it read is still true when
it writes; readers go on beside it (WAL). On PostgreSQL rows that are read to be changed are locked by the caller, in
the order goal, plan, mission, script, world; and other processes are told of what was written (`announce`).
"""

import sqlite3
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from hashlib import sha256

import psycopg
from sqlalchemy import Connection, Engine, create_engine, event, func, select
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.exc import DBAPIError, InterfaceError, OperationalError
from sqlalchemy.orm import Session
from sqlalchemy.pool import ConnectionPoolEntry

CHANNEL = "macta"
"""Where processes that share a database tell each other what they wrote."""
WRITTEN = "written"
"""The topic of every write transaction that has left an event."""
IN_ORDER = "in order"
"""The lock under which rows that are numbered in order are written."""
CANCELLED = "57014"
"""PostgreSQL's state of a statement that was cancelled: the server is there."""
UNWRITABLE = ("53100", "25006")
"""PostgreSQL's states when the disk is full, and when only reading is allowed."""
UNWRITABLE_HERE = (
    sqlite3.SQLITE_FULL,
    sqlite3.SQLITE_READONLY,
    sqlite3.SQLITE_IOERR,
    sqlite3.SQLITE_CANTOPEN,
)
"""SQLite's codes likewise, and when the disk does not do as it is told."""


class Database:
    """The engine and its two kinds of transaction."""

    def __init__(self, url: str) -> None:
        self.url = url
        self.engine = _engine(url)
        self.name = uuid.uuid4().hex
        """Of this process among those that share the database."""
        self.committed: list[Callable[[], None]] = []
        """Called after each write transaction that has committed, in this process or, told so, in another."""

    @property
    def shared(self) -> bool:
        """True if other processes may work on it: PostgreSQL."""
        return self.engine.dialect.name != "sqlite"

    @contextmanager
    def write(self) -> Iterator[Session]:
        """One transaction that reads and writes; commits at the end, rolls back on an exception."""
        with self.engine.connect() as connection:
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
        for call in (*self.committed, *session.info.get(_AFTER_COMMIT, ())):
            call()

    @contextmanager
    def read(self) -> Iterator[Session]:
        """One consistent view; nothing is written."""
        with self.engine.connect() as connection:
            if connection.dialect.name == "sqlite":
                connection.exec_driver_sql("BEGIN")
            with Session(connection, expire_on_commit=False) as session:
                yield session
            connection.rollback()

    def lock(self, session: Session, name: str) -> None:
        """Have the write transaction hold the lock of this name to its end; on SQLite it is alone anyway."""
        if self.shared:
            key = int.from_bytes(sha256(f"macta {name}".encode()).digest()[:8], signed=True)
            session.execute(select(func.pg_advisory_xact_lock(key)))

    def _write_last(self, session: Session) -> None:
        """Number what is numbered in order, and tell other processes. Nothing is waited for after this lock."""
        if rows := session.info.pop(_LAST, ()):
            self.lock(session, IN_ORDER)
            session.add_all(rows)
            session.flush()
            announce(session, WRITTEN)
        if self.shared:
            for topic in sorted(session.info.pop(_TOPICS, ())):
                session.execute(select(func.pg_notify(CHANNEL, f"{topic} {self.name}")))

    def close(self) -> None:
        self.engine.dispose()


_AFTER_COMMIT, _LAST, _TOPICS = "after_commit", "last", "topics"


def write_last(session: Session, row: object) -> None:
    """Write a row at the very end of the session's write transaction.

    Rows that get their numbers so are seen in the order of their numbers: on PostgreSQL a transaction may else commit
    after another that got higher ones.
    """
    session.info.setdefault(_LAST, []).append(row)


def announce(session: Session, topic: str) -> None:
    """Tell the processes that share the database, once the session's write transaction has committed."""
    session.info.setdefault(_TOPICS, set()).add(topic)


def is_unwritable(error: BaseException | None) -> bool:
    """True if the record cannot be written for now: the disk is full, say. Nothing of the transaction is kept."""
    if isinstance(error, DBAPIError):
        error = error.orig
    if isinstance(error, psycopg.Error):
        return error.sqlstate in UNWRITABLE
    # NOTE: the extended codes have the code in their last byte.
    return (
        isinstance(error, sqlite3.Error) and getattr(error, "sqlite_errorcode", 0) & 0xFF in UNWRITABLE_HERE
    )


def is_unavailable(error: BaseException) -> bool:
    """True if the database cannot be used for now: its server does not answer, or ended the connection, a deadlock
    included, or it cannot be written. Worth another try.
    """
    if is_unwritable(error):
        return True
    if not isinstance(error, DBAPIError) or not isinstance(error.orig, psycopg.Error):
        return False  # SQLite is always there
    ended = isinstance(error, OperationalError | InterfaceError) and error.orig.sqlstate != CANCELLED
    return ended or error.connection_invalidated


def unavailable_reason(error: BaseException) -> str | None:
    """In its driver's words why the database cannot be used for now; None if that is not what the error says."""
    if not isinstance(error, DBAPIError) or not is_unavailable(error):
        return None
    return str(error.orig).partition("\n")[0]


def after_commit(session: Session, call: Callable[[], None]) -> None:
    """Have this called, in this process, once the session's write transaction has committed."""
    session.info.setdefault(_AFTER_COMMIT, []).append(call)


def _engine(url: str) -> Engine:
    if not url.startswith("sqlite"):
        return create_engine(
            url,
            pool_pre_ping=True,
            pool_size=10,
            max_overflow=20,
            connect_args={"connect_timeout": 5, "keepalives_idle": 10, "keepalives_interval": 5},
        )
    engine = create_engine(url, pool_size=20, max_overflow=20, connect_args={"check_same_thread": False})

    @event.listens_for(engine, "connect")
    def _prepare(connection: DBAPIConnection, _: ConnectionPoolEntry) -> None:
        # The driver would begin transactions by itself, and too late: we begin them.
        connection.isolation_level = None
        cursor = connection.cursor()
        for pragma in ("busy_timeout=30000", "journal_mode=WAL", "synchronous=NORMAL", "foreign_keys=ON"):
            cursor.execute(f"PRAGMA {pragma}")
        cursor.close()

    @event.listens_for(engine, "begin")
    def _leave_begin_to_us(connection: Connection) -> None:
        """No BEGIN of the driver's own."""

    return engine
