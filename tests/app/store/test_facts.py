"""Facts are read from the database again exactly if they have changed."""

from contextlib import suppress

import pytest

from app.store import Database, WorldRow
from app.store.event_log import EventLog
from app.store.facts import FactStore
from planner import Fact
from tests.app.sample_store import Store

STORE = Store()
WORLD = "store"
HERE = STORE.fact("in(sample_1, bay_1)")
THERE = STORE.fact("in(sample_1, bay_7)")


@pytest.fixture
def facts(database: Database) -> FactStore:
    with database.write() as session:
        session.add(WorldRow(id=WORLD, title="Store", layout={}))
        session.flush()
        store = _store(database)
        store.change(session, WORLD, add=[HERE], source="file", at_s=0.0)
    return store


def _store(database: Database) -> FactStore:
    return FactStore(EventLog(database), STORE.base)


def _known(database: Database, facts: FactStore) -> frozenset[Fact]:
    with database.read() as session:
        return facts.facts(session, WORLD)


def test_a_change_by_another_process_is_seen(database: Database, facts: FactStore) -> None:
    assert _known(database, facts) == {HERE}
    with database.write() as session:
        _store(database).change(session, WORLD, add=[THERE], remove=[HERE], source="other", at_s=1.0)
    assert _known(database, facts) == {THERE}
    assert _known(database, facts) == {THERE}


def test_a_transaction_sees_its_own_changes_and_nobody_does_once_they_are_rolled_back(
    database: Database, facts: FactStore
) -> None:
    assert _known(database, facts) == {HERE}
    with suppress(LookupError), database.write() as session:
        facts.change(session, WORLD, add=[THERE], source="robot", at_s=1.0)
        assert facts.facts(session, WORLD) == {HERE, THERE}
        raise LookupError
    with database.write() as session:  # it has the version that was rolled back
        _store(database).change(session, WORLD, remove=[HERE], source="other", at_s=1.0)
    assert _known(database, facts) == frozenset()


def test_unchanged_facts_are_not_read_again(database: Database, facts: FactStore) -> None:
    assert _known(database, facts) is _known(database, facts)
