"""SQL that is compiled once in a process of the tests, not anew for each database.

SQLAlchemy keeps compiled statements by engine, and each test has engines of its own: an eighth of the CPU time of a
test with a service went to compiling the same statements again.
"""

from collections.abc import MutableMapping
from typing import Any

from sqlalchemy import Engine
from sqlalchemy.dialects import registry
from sqlalchemy.dialects.postgresql.psycopg import PGDialect_psycopg
from sqlalchemy.dialects.sqlite.pysqlite import SQLiteDialect_pysqlite
from sqlalchemy.engine import Dialect

_COMPILED: MutableMapping[Any, Any] = {}
"""By dialect and statement."""


class _Alike(Dialect):
    """A dialect that equals those with the same options, so that what is compiled for one of them serves all."""

    def __init__(self, **options: Any) -> None:
        self._options = options
        super().__init__(**options)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, type(self)) and other._options == self._options

    def __hash__(self) -> int:
        return hash(type(self))

    @classmethod
    def engine_created(cls, engine: Engine) -> None:
        engine.update_execution_options(compiled_cache=_COMPILED)


class AlikeSQLite(_Alike, SQLiteDialect_pysqlite):
    supports_statement_cache = True


class AlikePostgreSQL(_Alike, PGDialect_psycopg):
    supports_statement_cache = True


def share() -> None:
    """Have engines that are made from now on share their compiled statements."""
    for name in ("sqlite", "sqlite.pysqlite"):
        registry.register(name, __name__, AlikeSQLite.__name__)
    for name in ("postgresql", "postgresql.psycopg"):
        registry.register(name, __name__, AlikePostgreSQL.__name__)
