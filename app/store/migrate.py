"""Brings the record's tables up to date with Alembic, from the migrations that ship in this package."""

from pathlib import Path

from alembic import command
from alembic.config import Config
from sqlalchemy import Connection

from app.store.engine import Database


def migrate(database: Database) -> None:
    """Apply every migration that is missing, in one transaction; of several processes at once, one does."""
    with database.write() as session:
        database.lock(session, "migrations")
        command.upgrade(_config(session.connection()), "head")


def _config(connection: Connection) -> Config:
    config = Config()
    config.set_main_option("script_location", str(Path(__file__).parent / "migrations"))
    config.set_main_option("path_separator", "os")
    config.attributes["connection"] = connection
    return config
