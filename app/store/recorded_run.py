"""The recorded run of a world, read before the service is created."""

from sqlalchemy import inspect, select

from app.store.engine import Database
from app.store.tables import WorldRow


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
