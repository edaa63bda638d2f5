"""Migrations: an old record comes up to date with its rows, and the tables are what the code says."""

from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import text

from app.store import Base, Database
from app.store.migrate import migrate, migration_config
from tests.databases import ON_BOTH

pytestmark = ON_BOTH


def test_migrations_make_the_tables_that_the_code_declares(database_url: str) -> None:
    record = Database(database_url)
    migrate(record)
    with record.engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), Base.metadata) == []
    record.close()


def test_a_record_of_the_first_version_keeps_its_rows(database_url: str) -> None:
    record = Database(database_url)
    with record.engine.connect() as connection:
        command.upgrade(migration_config(connection), "0001")
        connection.execute(
            text("INSERT INTO worlds (id, title, layout, version) VALUES ('lab', 'Lab', '{}', 7)")
        )
        connection.commit()
    migrate(record)
    with record.engine.connect() as connection:
        rows = connection.execute(text("SELECT id, version, releases FROM worlds")).all()
    assert [tuple(row) for row in rows] == [("lab", 7, 0)]
    record.close()
