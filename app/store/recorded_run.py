"""The recorded run and edition of a world, read before the service is created."""

from sqlalchemy import inspect, select

from app.store.editions import newest_edition
from app.store.engine import Database
from app.store.tables import EditionRow, WorldRow
from robots.world import Edition, WorldFile


def recorded_edition(database_url: str, file: WorldFile) -> Edition:
    """The world as its recorded changes have made it; as in its file if there are none, or the file was replaced."""
    database = Database(database_url)
    try:
        if not inspect(database.engine).has_table(EditionRow.__tablename__):
            return Edition(0, file)
        with database.read() as session:
            return newest_edition(session, file)
    finally:
        database.close()


def recorded_run(database_url: str, world: str) -> str | None:
    """The run that the record's facts of a world belong to; None if there is no record, or no run to continue."""
    database = Database(database_url)
    try:
        known = inspect(database.engine)
        columns = known.get_columns(WorldRow.__tablename__) if known.has_table(WorldRow.__tablename__) else []
        if all(column["name"] != WorldRow.run.key for column in columns):
            return None  # an older version's database; it is migrated when the service starts
        with database.read() as session:
            return session.scalar(select(WorldRow.run).where(WorldRow.id == world))
    finally:
        database.close()
