"""Numeric facts: counted ones always agree with the symbolic facts, others have source, time and version."""

from contextlib import suppress
from random import Random
from typing import Any

import pytest
from sqlalchemy import delete, select

from app.domain.errors import Invalid
from app.domain.world_model import Facts, initial_facts, revise_beliefs
from app.domain.world_model.layout import layout_of
from app.domain.world_model.numbers import initial_numbers
from app.store import Database, EventRow, NumberRow, WorldRow
from app.store.event_log import EventLog
from app.store.facts import FactStore
from planner import Fact
from robots.world import WorldFile, WorldNumber
from tests.app.berthed_store import berthed_store
from tests.app.sample_store import Store
from tests.databases import ON_BOTH

STORE = Store()
RACKS = berthed_store()
WORLD = RACKS.name
BATTERY = ("battery", ("yard_1",))


def facts_store(database: Database, world: WorldFile = RACKS) -> FactStore:
    """A started world."""
    store = FactStore(EventLog(database), STORE.base)
    with database.write() as session:
        session.add(WorldRow(id=world.name, title="", layout=layout_of(world)))
        session.flush()
        facts = initial_facts(world, STORE.base)
        store.change(session, world.name, add=facts, source="file", at_s=0.0)
        store.numbers.complete(session, world, facts, source="file", at_s=0.0)
    return store


def rows(database: Database) -> dict[str, NumberRow]:
    with database.read() as session:
        return {row.term: row for row in session.scalars(select(NumberRow))}


def changes(database: Database) -> list[dict[str, Any]]:
    with database.read() as session:
        query = select(EventRow.data).where(EventRow.type == "world.numbers_changed").order_by(EventRow.seq)
        return list(session.scalars(query))


PLACES = [place.name for place in RACKS.places if place.capacity]
ROBOTS = [robot.name for robot in RACKS.robots]
SAMPLES = [sample.name for sample in RACKS.samples]


def location(place: str) -> str:
    return next(name for name, row in RACKS.places_by_location.items() if place in {one.name for one in row})


@ON_BOTH
@pytest.mark.parametrize("seed", range(3))
def test_loads_and_numbers_of_samples_are_always_those_of_the_facts(database: Database, seed: int) -> None:
    store = facts_store(database)
    random = Random(seed)
    for step in range(1, 30):
        sample = random.choice(SAMPLES)
        place = random.choice([*PLACES, *ROBOTS, None])
        with suppress(LookupError), database.write() as session:
            world = store.read_locked(session, WORLD)
            before = world.facts
            held = {f for f in before if f.predicate == "object_position" and f.args[0] == sample}
            news = [] if place is None else [Fact("object_position", (sample, "in", place))]
            after = revise_beliefs(before, news, gone=held)
            world.change(add=after - before, remove=before - after, source=f"report {step}", at_s=step)
            if random.random() < 0.2:
                raise LookupError
        with database.read() as session:
            facts = store.facts(session, WORLD)
            numbers = store.numbers.numbers(session, WORLD)
        assert {term: value for term, value in numbers.items() if term[0] != "battery"} == counted(facts)


def counted(facts: Facts) -> dict[tuple[str, tuple[str, ...]], float]:
    """By hand, with none of the code that is tested."""
    lies = [fact.args[2] for fact in facts if fact.predicate == "object_position"]
    found = {("load", (robot,)): lies.count(robot) for robot in ROBOTS}
    for name, row in RACKS.places_by_location.items():
        if row[0].capacity:
            found["samples", (name,)] = sum(lies.count(berth.name) for berth in row)
    return {term: float(count) for term, count in found.items()}


@ON_BOTH
def test_a_number_keeps_its_source_and_time_until_it_changes(database: Database) -> None:
    store = facts_store(database)
    began = rows(database)
    with database.write() as session:
        assert not store.numbers.set(session, WORLD, {BATTERY: 1.0}, source="report of yard_1", at_s=3.0)
        assert store.numbers.set(session, WORLD, {BATTERY: 0.9}, source="report of yard_1", at_s=4.0)
    now = rows(database)
    battery = now["battery(yard_1)"]
    assert (battery.value, battery.source, battery.at_s) == (0.9, "report of yard_1", 4.0)
    assert battery.version == max(row.version for row in began.values()) + 1
    assert {term: row.version for term, row in now.items() if row is not battery} == {
        term: row.version for term, row in began.items() if term != battery.term
    }
    assert changes(database)[-1]["changed"] == [
        {"quantity": "battery", "args": ["yard_1"], "value": 0.9, "before": 1.0}
    ]


def test_a_sample_that_moves_changes_the_numbers_of_both_places_and_no_other(database: Database) -> None:
    store = facts_store(database)
    sample = SAMPLES[0]
    with database.write() as session:
        world = store.read_locked(session, WORLD)
        before = world.facts
        after = revise_beliefs(before, [Fact("object_position", (sample, "in", "yard_1"))])
        world.change(add=after - before, remove=before - after, source="report of yard_1", at_s=7.0)
    told = changes(database)[-1]
    lay = location(RACKS.initial_places[sample])
    assert [(one["quantity"], one["args"], one["value"]) for one in told["changed"]] == [
        ("load", ["yard_1"], 1.0),
        ("samples", [lay], 0.0),
    ]
    assert (told["source"], told["at_s"]) == ("report of yard_1", 7.0)


def test_the_berths_of_a_location_count_together(database: Database) -> None:
    store = facts_store(database)
    with database.write() as session:
        world = store.read_locked(session, WORLD)
        before = world.facts
        news = [
            Fact("object_position", (sample, "in", berth.name))
            for sample, berth in zip(SAMPLES, RACKS.places_by_location["bay_7"], strict=False)
        ]
        after = revise_beliefs(before, news)
        world.change(add=after - before, remove=before - after, source="operator", at_s=1.0)
    assert rows(database)["samples(bay_7)"].value == min(3, len(SAMPLES))
    with database.read() as session:
        planned = store.numbers.for_planner(session, WORLD)
    assert planned["samples", ("bay_7_2",)] == min(3, len(SAMPLES))
    assert ("samples", ("bay_7",)) not in planned


def test_a_report_older_than_what_is_known_is_not_believed(database: Database) -> None:
    store = facts_store(database)
    with database.write() as session:
        store.numbers.set(session, WORLD, {BATTERY: 0.5}, source="operator x", at_s=9.0)
    with database.write() as session:
        assert not store.numbers.set(session, WORLD, {BATTERY: 0.7}, source="late", at_s=8.0, is_told=True)
        assert store.numbers.set(session, WORLD, {BATTERY: 0.6}, source="newer", at_s=9.0, is_told=True)
    assert rows(database)["battery(yard_1)"].value == 0.6


def test_a_report_that_finds_a_number_unchanged_renews_its_source_and_time(database: Database) -> None:
    store = facts_store(database)
    for source, at_s, told in (("one", 5.0, True), ("two", 9.0, True), ("late", 7.0, False)):
        with database.write() as session:
            assert (
                store.numbers.set(session, WORLD, {BATTERY: 0.8}, source=source, at_s=at_s, is_told=True)
                is told
            )
    battery = rows(database)["battery(yard_1)"]
    assert (battery.source, battery.at_s) == ("two", 9.0)


def test_numbers_that_were_rolled_back_are_not_remembered(database: Database) -> None:
    store = facts_store(database)
    with suppress(LookupError), database.write() as session:
        store.numbers.set(session, WORLD, {BATTERY: 0.5}, source="report", at_s=1.0)
        assert store.numbers.numbers(session, WORLD)[BATTERY] == 0.5
        raise LookupError
    with database.write() as session:  # it has the version that was rolled back
        store.numbers.set(session, WORLD, {BATTERY: 0.4}, source="other", at_s=1.0)
    with database.read() as session:
        assert store.numbers.numbers(session, WORLD)[BATTERY] == 0.4


@ON_BOTH
def test_a_record_without_numbers_gets_them_and_one_of_another_world_loses_them(database: Database) -> None:
    store = facts_store(database)
    with database.write() as session:
        session.execute(delete(NumberRow).where(NumberRow.quantity != "battery"))
        gone = NumberRow(
            world=WORLD,
            term="battery(old_1)",
            quantity="battery",
            args=["old_1"],
            value=1,
            source="",
            at_s=0,
            version=1,
        )
        session.add(gone)
    with database.write() as session:
        store.numbers.complete(session, RACKS, store.facts(session, WORLD), source="start", at_s=0.0)
    known = rows(database)
    assert "battery(old_1)" not in known
    assert changes(database)[-1]["gone"] == ["battery(old_1)"]
    assert known["load(yard_1)"].value == 0
    assert known["battery(yard_1)"].source == "file"


def test_a_world_file_states_numbers_of_its_own() -> None:
    robots = tuple(one.model_copy(update={"battery": 0.4}) for one in RACKS.robots)
    world = RACKS.model_copy(update={"robots": robots})
    assert initial_numbers(world, STORE.base)["battery", ("yard_2",)] == 0.4


def test_a_world_file_states_a_battery_with_its_robot_only() -> None:
    stated = WorldNumber(quantity="battery", args=("yard_2",), value=0.6)
    world = RACKS.model_copy(update={"numbers": (stated,)})
    with pytest.raises(
        Invalid, match=r"battery\(yard_2\) is stated already; a robot's battery stands in `robots`"
    ):
        initial_numbers(world, STORE.base)
