"""Which of a database's errors pass, so that trying again helps."""

from pathlib import Path

import pytest
from sqlalchemy import create_engine, text
from sqlalchemy.exc import DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeoutError

from app.store import Database, WorldRow, is_unavailable, is_unwritable
from tests.databases import ON_BOTH


@ON_BOTH
def test_a_record_that_may_only_be_read_is_waited_for(database: Database) -> None:
    forbid = "SET TRANSACTION READ ONLY" if database.shared else "PRAGMA query_only=1"
    with database.engine.connect() as connection:
        connection.execute(text(forbid))
        with pytest.raises(DBAPIError) as refused:
            connection.execute(text("DELETE FROM worlds"))
    assert is_unwritable(refused.value)
    assert is_unavailable(refused.value)


@ON_BOTH
def test_what_can_never_be_written_is_not_waited_for(database: Database) -> None:
    with pytest.raises(DBAPIError) as refused, database.write() as session:
        session.add_all([WorldRow(id="lab", title="", layout={}), WorldRow(id="lab", title="", layout={})])
    assert not is_unwritable(refused.value)
    assert not is_unavailable(refused.value)


def test_a_connection_is_waited_for_while_all_are_in_use(tmp_path: Path) -> None:
    engine = create_engine(f"sqlite:///{tmp_path / 'any'}", pool_size=1, max_overflow=0, pool_timeout=0.01)
    with engine.connect(), pytest.raises(PoolTimeoutError) as refused:
        engine.connect()
    assert is_unavailable(refused.value)
