"""Which of a database's errors pass, so that trying again helps."""

import pytest
from sqlalchemy import text
from sqlalchemy.exc import DBAPIError

from app.store import Database, WorldRow, is_unavailable, is_unwritable
from tests.databases import ON_BOTH

pytestmark = ON_BOTH


def test_a_record_that_may_only_be_read_is_waited_for(database: Database) -> None:
    forbid = "SET TRANSACTION READ ONLY" if database.shared else "PRAGMA query_only=1"
    with database.engine.connect() as connection:
        connection.execute(text(forbid))
        with pytest.raises(DBAPIError) as refused:
            connection.execute(text("DELETE FROM worlds"))
    assert is_unwritable(refused.value)
    assert is_unavailable(refused.value)


def test_what_can_never_be_written_is_not_waited_for(database: Database) -> None:
    with pytest.raises(DBAPIError) as refused, database.write() as session:
        session.add_all([WorldRow(id="lab", title="", layout={}), WorldRow(id="lab", title="", layout={})])
    assert not is_unwritable(refused.value)
    assert not is_unavailable(refused.value)
