"""DBOS's connections to the database: its system tables lie beside the service's own tables."""

import sqlite3
from typing import Any

from sqlalchemy import Engine, ExceptionContext, create_engine, event
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.pool import ConnectionPoolEntry

from app.store import is_unwritable
from app.store.engine import replace_broken_connections

POOL_SIZE = 25
IDLE_TRANSACTION_TIMEOUT_MS = 60_000
"""PostgreSQL ends a session that holds a transaction open for longer, which releases its locks."""


def create_system_engine(url: str) -> Engine:
    """An engine for `DBOSConfig` and `DBOSClient`: immediate write transactions on SQLite."""
    pool: dict[str, Any] = {"pool_size": POOL_SIZE, "max_overflow": 0, "pool_use_lifo": True}
    if url.startswith("sqlite"):
        engine = create_engine(url, **pool)
        event.listen(engine, "connect", _prepare_sqlite)
    else:
        options = f"-c idle_in_transaction_session_timeout={IDLE_TRANSACTION_TIMEOUT_MS}"
        engine = create_engine(url, **pool, connect_args={"connect_timeout": 10, "options": options})
        replace_broken_connections(engine)
    event.listen(engine, "handle_error", _report_as_locked)
    return engine


def retire(engine: Engine) -> None:
    """Close all connections and allow no new ones, so that a workflow thread that outlives DBOS can record nothing."""
    event.listen(engine, "do_connect", _refuse_connection)
    event.listen(engine, "checkin", _invalidate)
    engine.dispose()


def _prepare_sqlite(connection: DBAPIConnection, _: ConnectionPoolEntry) -> None:
    connection.isolation_level = "IMMEDIATE"
    cursor = connection.cursor()
    cursor.execute("PRAGMA busy_timeout=30000")
    cursor.execute("PRAGMA foreign_keys=ON")
    cursor.close()


def _refuse_connection(*_: object) -> None:
    """:raises RuntimeError: always; DBOS tries again only after errors of the database driver."""
    raise RuntimeError("the workflow engine is closed")


def _invalidate(_: DBAPIConnection | None, entry: ConnectionPoolEntry) -> None:
    entry.invalidate()


def _report_as_locked(context: ExceptionContext) -> None:
    """Let DBOS retry when the database cannot be written for now (disk full, read-only), as when it is locked.

    :raises sqlite3.OperationalError: in place of SQLite's own error.
    """
    error = context.original_exception
    if isinstance(error, sqlite3.Error) and is_unwritable(error):
        raise sqlite3.OperationalError(f"database is locked: {error}") from error
