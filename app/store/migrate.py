"""Makes the tables, or upgrades them with Alembic from the migrations in this package."""

import re
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import Column, Connection, MetaData, String, Table, insert, inspect, select

from app.domain.errors import Invalid
from app.store.engine import Database
from app.store.tables import Base

if TYPE_CHECKING:
    from alembic.config import Config

MIGRATIONS = Path(__file__).parent / "migrations"
REVISION = re.compile("[0-9]{4}")
"""The form of our migrations' names; they are numbered in order."""
VERSION = Table(
    "alembic_version",
    MetaData(naming_convention={"pk": "%(table_name)s_pkc"}),
    Column("version_num", String(32), primary_key=True),
)
"""Where Alembic notes the newest migration that a database has. Read and made here: Alembic is loaded only for a
database that lacks migrations, for it takes a tenth of the service's start.
"""


FOREIGN = "the database is another program's, name one for Macta alone (MACTA_DATABASE_URL, --data)"


def migrate(database: Database) -> None:
    """Bring the tables up to date in one transaction; if several processes start at once, one of them does.

    An empty database gets the tables as the code declares them, any other the migrations that it lacks.

    :raises Invalid: if the database is of a newer version or of another program; it is left as it is.
    """
    with database.write() as session:
        database.lock(session, "migrations")
        connection = session.connection()
        tables = sorted(inspect(connection).get_table_names())
        revision = connection.scalar(select(VERSION.c.version_num)) if VERSION.name in tables else None
        newest = newest_migration()
        if revision is not None:
            _refuse_others(revision, newest)
            if revision != newest:
                _upgrade(connection)
        elif tables:
            raise Invalid(f"{FOREIGN}: it holds {', '.join(tables[:3])}", code="foreign-database")
        else:
            Base.metadata.create_all(connection)
            VERSION.create(connection)
            connection.execute(insert(VERSION).values(version_num=newest))


def _upgrade(connection: Connection) -> None:
    from alembic import command

    command.upgrade(migration_config(connection), "head")


def newest_migration() -> str:
    """The number of the newest migration, by the names of the files."""
    return max(file.name[:4] for file in (MIGRATIONS / "versions").glob("[0-9][0-9][0-9][0-9]_*.py"))


def _refuse_others(revision: str, newest: str) -> None:
    if REVISION.fullmatch(revision) is None:
        raise Invalid(f"{FOREIGN}: its migration is {revision!r}", code="foreign-database")
    if revision > newest:
        raise Invalid(
            f"the database is of a newer version of Macta: its migration is {revision}, this version has {newest}; "
            "update Macta, or name another database (MACTA_DATABASE_URL, --data)",
            code="newer-database",
        )


def migration_config(connection: Connection) -> "Config":
    """Alembic's, for our migrations."""
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    config.set_main_option("path_separator", "os")
    config.attributes["connection"] = connection
    return config
