"""The event log on a database that several processes write to: in order, without gaps for those who follow it."""

import random
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from sqlalchemy import event

from app.domain.events import Event
from app.store import Database
from app.store.event_log import EventLog
from app.store.migrate import migrate
from app.workflows.notifications import NotificationListener
from tests.app.stepped_clock import SteppedClock
from tests.databases import ON_BOTH, ON_POSTGRESQL
from tests.waiting import until

WRITERS, EACH = 4, 60
PROMPT_S = 20.0


class ThingHappened(Event, type="thing.happened"):
    number: int


@contextmanager
def process(url: str) -> Iterator[tuple[Database, EventLog]]:
    """The record and its event log as another process has them."""
    database = Database(url)
    yield database, EventLog(database)
    database.close()


@pytest.fixture
def made(database_url: str) -> str:
    database = Database(database_url)
    migrate(database)
    database.close()
    return database_url


def write(url: str, writer: int) -> None:
    """Append events, two a transaction, and take a while to commit."""
    chance = random.Random(writer)
    database = Database(url)
    event.listen(database.engine, "commit", lambda _: time.sleep(chance.uniform(0.0, 0.004)))
    log = EventLog(database)
    for number in range(0, EACH, 2):
        with database.write() as session:
            log.append(session, ThingHappened(subject=f"writer-{writer}", number=number))
            log.append(session, ThingHappened(subject=f"writer-{writer}", number=number + 1))
    database.close()


@ON_BOTH
def test_who_follows_the_log_misses_nothing_that_several_processes_write(made: str) -> None:
    writers = [threading.Thread(target=write, args=(made, writer)) for writer in range(WRITERS)]
    for writer in writers:
        writer.start()
    seen: list[tuple[int, str, int]] = []
    with process(made) as (_, log):
        give_up = time.monotonic() + 120
        while len(seen) < WRITERS * EACH:
            alive = any(writer.is_alive() for writer in writers)
            rows = log.since(seen[-1][0] if seen else 0)
            seen += [(row.seq, row.subject, row.data["number"]) for row in rows]
            assert rows or alive, f"{WRITERS * EACH - len(seen)} events were passed over"
            assert time.monotonic() < give_up
    for writer in range(WRITERS):
        assert [n for _, who, n in seen if who == f"writer-{writer}"] == list(range(EACH))


@ON_POSTGRESQL
def test_a_stream_that_waits_is_woken_by_what_another_process_writes(made: str) -> None:
    with process(made) as (here, events), process(made) as (there, events_there):
        listening = NotificationListener(here, {}, wake=lambda _: None)
        listening.start()
        seen = events.wait(0, PROMPT_S)  # it looks once when it begins to listen
        with there.write() as session:
            events_there.append(session, ThingHappened(subject="there", number=0))
        assert events.wait(seen, PROMPT_S) != seen
        assert [row.subject for row in events.since(0)] == ["there"]
        listening.close()


@ON_POSTGRESQL
def test_listening_goes_on_after_its_connection_was_cut(made: str) -> None:
    with process(made) as (here, _), process(made) as (there, _):
        topics: list[str] = []
        listening = NotificationListener(
            here, {"planning": lambda: topics.append("planning")}, wake=lambda _: None, clock=SteppedClock()
        )
        listening.start()
        until(lambda: len(topics) == 1)
        with there.write() as session:
            listens = "datname = current_database() AND query = 'LISTEN macta'"
            cut = f"SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE {listens}"
            session.connection().exec_driver_sql(cut)
        until(lambda: len(topics) == 2)
        listening.close()
