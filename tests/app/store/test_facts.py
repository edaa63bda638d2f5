"""Facts are read from the database again exactly if another process has changed them."""

import random
from contextlib import suppress

import pytest

from app.store import Database, WorldRow
from app.store.event_log import EventLog
from app.store.facts import FactStore
from planner import Fact, KnowledgeBase
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


def test_a_new_run_has_none_of_the_facts_of_the_last_one(database: Database, facts: FactStore) -> None:
    other = _store(database)
    assert _known(database, facts) == _known(database, other) == {HERE}
    with database.write() as session:
        row = session.get_one(WorldRow, WORLD)
        row.run, row.version = "next", row.version - 1  # as of a world that was removed and added again
        facts.begin_run(session, WORLD)
        assert facts.facts(session, WORLD) == frozenset()
        facts.change(session, WORLD, add=[THERE], source="file", at_s=0.0)
    assert _known(database, facts) == _known(database, other) == {THERE}
    with database.read() as session:
        assert [one.fact for one in _store(database).believed(session, WORLD)] == [THERE]


@pytest.mark.parametrize("seed", range(20))
def test_what_is_in_memory_is_what_is_recorded(database: Database, facts: FactStore, seed: int) -> None:
    """Two processes change facts, withdraw them and give them other sources, and some of it is rolled back."""
    chance = random.Random(seed)
    processes = (facts, _store(database))
    some = [STORE.fact(f"in(sample_{n}, bay_{m})") for n in (1, 2) for m in (1, 2, 3)]
    for step in range(30):
        process = chance.choice(processes)
        with suppress(LookupError), database.write() as session:
            for _ in range(chance.randint(1, 3)):
                world = process.read_locked(session, WORLD)
                source, at_s = chance.choice(["yard_1", "store_1"]), float(step)
                if chance.random() < 0.2:
                    world.attest(chance.sample(some, 2), source=source, at_s=at_s)
                else:
                    world.change(
                        add=chance.sample(some, chance.randint(0, 2)),
                        remove=chance.sample(some, chance.randint(0, 2)),
                        source=source,
                        at_s=at_s,
                        corrects=chance.random() < 0.5,
                    )
            if chance.random() < 0.3:
                raise LookupError
        fresh = _store(database)
        with database.write() as session:
            recorded = fresh.read_locked(session, WORLD).kept()
        for each in processes:
            assert _known(database, each) == recorded.facts
            with database.write() as session:
                assert each.read_locked(session, WORLD).kept() == recorded


def test_a_goal_that_is_achieved_each_time_counts_only_from_when_it_was_done_again(
    database: Database,
) -> None:
    file = STORE.base.file
    predicates = dict(file.predicates)
    predicates[HERE.predicate] = predicates[HERE.predicate].model_copy(update={"each_time": True})
    base = KnowledgeBase(file.model_copy(update={"predicates": predicates}))
    facts = FactStore(EventLog(database), base)
    with database.write() as session:
        session.add(WorldRow(id=WORLD, title="Store", layout={}))
        session.flush()
        facts.change(session, WORLD, add=[HERE, THERE], source="yard_1", at_s=5.0)
    with database.write() as session:
        version = facts.version(session, WORLD)
        assert facts.counting_for(session, WORLD, [HERE], since_s=None) == {THERE}
        assert facts.counting_for(session, WORLD, [HERE], since_s=6.0) == {THERE}
        assert facts.counting_for(session, WORLD, [HERE], since_s=5.0) == {HERE, THERE}
        assert facts.change(session, WORLD, add=[HERE], source="yard_2", at_s=4.0) == version, "a late report"
        assert facts.change(session, WORLD, add=[HERE], source="yard_2", at_s=7.0) == version + 1
    with database.write() as session:
        assert facts.counting_for(session, WORLD, [HERE], since_s=6.0) == {HERE, THERE}
        assert [(one.source, one.at_s) for one in facts.believed(session, WORLD)] == [
            ("yard_2", 7.0),
            ("yard_1", 5.0),
        ]


def test_other_goals_count_as_soon_as_they_are_true(database: Database, facts: FactStore) -> None:
    with database.write() as session:
        assert facts.counting_for(session, WORLD, [HERE], since_s=None) == {HERE}
        version = facts.version(session, WORLD)
        assert facts.change(session, WORLD, add=[HERE], source="yard_1", at_s=9.0) == version
