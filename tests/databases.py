"""Databases for tests: SQLite in the test's own folder, or PostgreSQL, a database a test that is dropped at its end."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import psycopg
import pytest

from benchmarks.databases import database_on

SERVER = os.environ.get("MACTA_TEST_POSTGRESQL", "postgresql://postgres@127.0.0.1:5432")
"""A server on which databases may be made; without its password, if it wants one, which PGPASSWORD is for."""
SQLITE, POSTGRESQL = "sqlite", "postgresql"
ON_BOTH = pytest.mark.parametrize("database_url", [SQLITE, POSTGRESQL], indirect=True)
ON_POSTGRESQL = pytest.mark.parametrize("database_url", [POSTGRESQL], indirect=True)


@cache
def why_no_postgresql() -> str:
    """Why there is no PostgreSQL to test with; empty if there is one."""
    try:
        psycopg.connect(f"{SERVER}/postgres", connect_timeout=3).close()
    except psycopg.OperationalError as error:
        return f"no PostgreSQL at {SERVER}: {error}"
    return ""


@contextmanager
def postgresql(template: str = "template1") -> Iterator[str]:
    """The address of a database of its own for the length of the block; the test is skipped without a server."""
    if why := why_no_postgresql():
        pytest.skip(why)
    with database_on(SERVER, template, waits_for_disk=False) as url:
        yield url


@contextmanager
def fresh(kind: str, folder: Path) -> Iterator[str]:
    """The address of an empty database of this kind."""
    if kind == POSTGRESQL:
        with postgresql() as url:
            yield url
    else:
        yield f"sqlite:///{folder / 'macta.sqlite'}"
