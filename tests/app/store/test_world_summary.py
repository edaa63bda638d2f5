"""The summary of a world's record is read once, and again after what could change it."""

from contextlib import suppress

from sqlalchemy import event
from sqlalchemy.orm import Session

from app.store import Database, LostRobotRow, WorldRow
from app.store.records import lock_world, lost_robots
from app.store.standing_holds import standing_rows
from app.store.world_summary import NOTHING, summary_of
from tests.databases import ON_POSTGRESQL

WORLD = "store"


def _world(database: Database) -> None:
    with database.write() as session:
        session.add(WorldRow(id=WORLD, title="Store", layout={}))


def _lost(session: Session) -> None:
    session.add(
        LostRobotRow(world=WORLD, robot="rover_1", declared_by="anna", since_s=1.0, silent=False, comment="")
    )


def test_what_the_transaction_has_written_is_in_its_summary(database: Database) -> None:
    _world(database)
    with database.write() as session:
        assert summary_of(session, WORLD).has_lost is False
        _lost(session)
        assert [row.robot for row in lost_robots(session, WORLD)] == ["rover_1"]
        session.get_one(WorldRow, WORLD).releases = 7
        assert summary_of(session, WORLD).releases == 7


def test_what_was_rolled_back_is_in_no_later_summary(database: Database) -> None:
    _world(database)
    with suppress(LookupError), database.write() as session:
        _lost(session)
        assert summary_of(session, WORLD).has_lost
        raise LookupError
    with database.read() as session:
        assert not lost_robots(session, WORLD)


def test_it_is_read_once_in_a_transaction_that_writes_nothing(database: Database) -> None:
    _world(database)
    statements: list[str] = []
    with database.read() as session:
        event.listen(database.engine, "before_cursor_execute", lambda *given: statements.append(given[2]))
        for _ in range(3):
            assert not lost_robots(session, WORLD)
            assert not standing_rows(session, WORLD)
    assert len(statements) == 1


@ON_POSTGRESQL
def test_what_was_committed_before_the_world_is_locked_is_seen_once_it_is(database: Database) -> None:
    _world(database)
    with database.write() as session:
        assert not lost_robots(session, WORLD)
        with database.write() as other:
            _lost(other)
        lock_world(session, WORLD)
        assert [row.robot for row in lost_robots(session, WORLD)] == ["rover_1"]


def test_a_world_that_is_not_recorded_has_nothing(database: Database) -> None:
    with database.read() as session:
        assert summary_of(session, "nowhere") == NOTHING
        assert not lost_robots(session, "nowhere")
