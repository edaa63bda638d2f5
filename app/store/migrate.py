"""Upgrades the tables with Alembic, from the migrations in this package."""

from pathlib import Path

from alembic import command
from alembic.config import Config
from sqlalchemy import Connection

from app.store.engine import Database


def migrate(database: Database) -> None:
    """Apply the missing migrations in one transaction; of several processes, one does."""
    with database.write() as session:
        database.lock(session, "migrations")
        command.upgrade(migration_config(session.connection()), "head")


def migration_config(connection: Connection) -> Config:
    config = Config()
    config.set_main_option("script_location", str(Path(__file__).parent / "migrations"))
    config.set_main_option("path_separator", "os")
    config.attributes["connection"] = connection
    return config
