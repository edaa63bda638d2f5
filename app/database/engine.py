"""Transactions on the record.

On SQLite a write transaction takes the write lock at once (BEGIN IMMEDIATE), so that what it read is still true when
it writes; readers go on beside it (WAL). On PostgreSQL rows that are read to be changed are locked by the caller.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.orm import Session
from sqlalchemy.pool import ConnectionPoolEntry


class Database:
    """The engine and its two kinds of transaction."""

    def __init__(self, url: str) -> None:
        self.url = url
        self.engine = _engine(url)
        self.committed: list[Callable[[], None]] = []
        """Called after each write transaction that has committed, in this process."""

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

    def close(self) -> None:
        self.engine.dispose()


_AFTER_COMMIT = "after_commit"


def after_commit(session: Session, call: Callable[[], None]) -> None:
    """Have this called, in this process, once the session's write transaction has committed."""
    session.info.setdefault(_AFTER_COMMIT, []).append(call)


def _engine(url: str) -> Engine:
    if not url.startswith("sqlite"):
        return create_engine(url, pool_pre_ping=True)
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
