"""What is looked for often is asked for again only once it may have been written."""

from collections.abc import Callable, Sequence

import pytest

from app.store import Database, RoleRow, TuningRow, WorldRow
from app.store.known_empty import KNOWN_FOR_S, KnownEmpty
from tests.app.stepped_clock import SteppedClock

WORLD = "store"


class Looked:
    """A query of the tunings, which counts how often it is made."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self.clock = SteppedClock()
        self.known = KnownEmpty(database, TuningRow, clock=self.clock)
        self.count = 0
        self.meanwhile: Callable[[], None] = lambda: None
        with database.write() as session:
            session.add(WorldRow(id=WORLD, title="Store", layout={}))

    def look(self) -> Sequence[TuningRow]:
        return self.known.read(WORLD, self._query)

    def _query(self) -> Sequence[TuningRow]:
        self.count += 1
        with self._database.read() as session:
            found = session.query(TuningRow).all()
        self.meanwhile()
        return found

    def tune(self) -> None:
        with self._database.write() as session:
            session.add(TuningRow(world=WORLD, robot="rover_1", version=1, tuning={}, delivery="pending"))

    def give_role(self) -> None:
        with self._database.write() as session:
            session.add(RoleRow(world=WORLD, robot="rover_1", version=1, role="scout", comment=""))


@pytest.fixture
def looked(database: Database) -> Looked:
    return Looked(database)


def test_nothing_is_asked_for_while_nothing_is_written_to_its_tables(looked: Looked) -> None:
    assert [*looked.look(), *looked.look()] == []
    looked.give_role()
    assert not looked.look()
    assert looked.count == 1


def test_what_was_written_is_found_and_asked_for_each_time(looked: Looked) -> None:
    assert not looked.look()
    looked.tune()
    assert [row.robot for row in looked.look()] == ["rover_1"]
    assert [row.robot for row in looked.look()] == ["rover_1"]
    assert looked.count == 3


def test_what_is_written_during_the_query_is_found_by_the_next_one(looked: Looked) -> None:
    looked.meanwhile = looked.tune
    assert not looked.look()
    looked.meanwhile = lambda: None
    assert [row.robot for row in looked.look()] == ["rover_1"]


def test_who_is_woken_by_a_commit_finds_what_it_has_written(looked: Looked, database: Database) -> None:
    found: list[int] = []
    database.committed.append(lambda: found.append(len(looked.look())))
    assert not looked.look()
    looked.tune()
    database.written_elsewhere()
    assert found == [1, 1]


def test_another_processes_write_is_looked_for(looked: Looked, database: Database) -> None:
    other = Database(database.url)
    assert not looked.look()
    with other.write() as session:
        session.add(TuningRow(world=WORLD, robot="rover_1", version=1, tuning={}, delivery="pending"))
    other.close()
    database.written_elsewhere()
    assert [row.robot for row in looked.look()] == ["rover_1"]


def test_a_write_whose_notification_is_lost_is_found_a_while_later(looked: Looked) -> None:
    assert not looked.look()
    looked.clock.advance(KNOWN_FOR_S)
    looked.look()
    assert looked.count == 2


def test_closed_it_no_longer_watches(looked: Looked, database: Database) -> None:
    looked.known.close()
    assert not database.watching
