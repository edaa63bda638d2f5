"""Databases on PostgreSQL for benchmarks and tests, one a run."""

import uuid
from collections.abc import Iterator
from contextlib import contextmanager

import psycopg

SERVER = "postgresql://postgres@127.0.0.1:5432"


@contextmanager
def database_on(server: str, template: str = "template1", *, waits_for_disk: bool = True) -> Iterator[str]:
    """The address of a database that exists during the block.

    :param template: the name of the database that it begins as a copy of.
    :param waits_for_disk: False: commits do not wait until they are on disk; all else is the same.
    """
    name = f"macta_run_{uuid.uuid4().hex[:12]}"
    with psycopg.connect(f"{server}/postgres", autocommit=True) as connection:
        connection.execute(f"CREATE DATABASE {name} TEMPLATE {template}")
        if not waits_for_disk:
            connection.execute(f"ALTER DATABASE {name} SET synchronous_commit = off")
        try:
            yield server.replace("postgresql://", "postgresql+psycopg://") + f"/{name}"
        finally:
            connection.execute(f"DROP DATABASE {name} WITH (FORCE)")
