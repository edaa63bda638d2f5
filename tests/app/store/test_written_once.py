from sqlalchemy import Column, Integer, MetaData, Table, insert, select

from app.store.engine import Database
from app.store.tables import WrittenOnce
from tests.databases import ON_BOTH


@ON_BOTH
def test_a_value_that_never_changes_is_parsed_once(database: Database) -> None:
    """And parts of it can be selected, as of other JSON."""
    table = Table("notes", MetaData(), Column("id", Integer), Column("body", WrittenOnce))
    with database.write() as session:
        connection = session.connection()
        table.create(connection)
        connection.execute(
            insert(table), [{"id": 1, "body": {"goals": ["in(sample_1, bay_7)"]}}, {"id": 2, "body": None}]
        )
        one, none = connection.scalars(select(table.c.body).order_by(table.c.id))
        again = connection.scalar(select(table.c.body).where(table.c.id == 1))
        part = connection.scalar(select(table.c.body["goals"]).where(table.c.id == 1))
    assert one == {"goals": ["in(sample_1, bay_7)"]}
    assert again is one
    assert none is None
    assert part == ["in(sample_1, bay_7)"]
