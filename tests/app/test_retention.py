"""What is old goes, what is needed stays."""

import time
from collections.abc import Iterator
from queue import Queue

import pytest
from sqlalchemy import select

from app.database import Database, EventRow, GoalRow, MessageRow, MissionRow, PlanRow, ScriptRow, WorldRow
from app.database.migrate import migrate
from app.durable import PLANNING, Workflows
from app.events import EventLog
from app.retention import Retention, Swept
from tests.databases import ON_BOTH

pytestmark = ON_BOTH
LONG_AGO, DAY_S = "2020-01-01T00:00:00.000Z", 86400.0


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    database = Database(database_url)
    migrate(database)
    yield database
    database.close()


@pytest.fixture
def done() -> "Queue[str]":
    return Queue()


@pytest.fixture
def workflows(database: Database, done: "Queue[str]") -> Iterator[Workflows]:
    workflows = Workflows(database.url)
    workflows.register("note", done.put)
    workflows.launch()
    yield workflows
    workflows.close()


def write_events(database: Database, *times: str | None) -> None:
    for at in times:
        with database.write() as session:
            session.add(EventRow(type="told", subject="it", data={}, **({"time": at} if at else {})))


def kept(database: Database) -> list[int]:
    with database.read() as session:
        return list(session.scalars(select(EventRow.seq).order_by(EventRow.seq)))


def test_old_events_go_and_numbers_go_on(database: Database, workflows: Workflows) -> None:
    log = EventLog(database)
    write_events(database, LONG_AGO, LONG_AGO, None, None)
    retention = Retention(database, workflows, days=30, events=1000)
    assert retention.sweep() == Swept(events=2, messages=0, workflows=0)
    assert kept(database) == [3, 4]
    assert [log.has_forgotten(seen) for seen in (0, 1, 2, 3, 4)] == [True, True, False, False, False]
    write_events(database, None)
    assert kept(database) == [3, 4, 5]


def test_of_too_many_events_the_newest_are_kept(database: Database, workflows: Workflows) -> None:
    write_events(database, *[None] * 20)
    assert Retention(database, workflows, days=30, events=8).sweep().events == 12
    assert kept(database) == list(range(13, 21))


def test_the_newest_event_stays_however_old_it_is(database: Database, workflows: Workflows) -> None:
    write_events(database, LONG_AGO, LONG_AGO, LONG_AGO)
    Retention(database, workflows, days=30, events=1000).sweep()
    assert kept(database) == [3]


def add_mission(database: Database, name: str, state: str) -> None:
    """A mission with one script, of which a robot said something long ago and something now."""
    with database.write() as session:
        if session.get(WorldRow, "lab") is None:
            session.add(WorldRow(id="lab", title="", layout={}, version=1))
        session.flush()
        session.add(
            GoalRow(
                id=f"goal-{name}",
                world="lab",
                text="",
                goal=[],
                priority=0,
                auto_approve=False,
                state="committed",
                created_by="",
            )
        )
        session.flush()
        session.add(
            PlanRow(
                id=f"plan-{name}",
                goal_id=f"goal-{name}",
                world="lab",
                state="approved",
                body={},
                world_version=1,
            )
        )
        session.flush()
        session.add(
            MissionRow(
                id=name,
                goal_id=f"goal-{name}",
                plan_id=f"plan-{name}",
                world="lab",
                state=state,
                estimate_s=1.0,
                original_estimate_s=1.0,
                margin_s=1.0,
            )
        )
        session.flush()
        given = {"plan_id": f"plan-{name}"} if hasattr(ScriptRow, "plan_id") else {}
        session.add(
            ScriptRow(
                id=f"{name}-fred",
                mission_id=name,
                robot="fred",
                body={},
                delivery="acknowledged",
                packets={},
                perceived=[],
                **given,
            )
        )
        body = {"body": {"kind": "packet_report", "script_id": f"{name}-fred"}}
        for age, recorded in (("old", {"recorded_at": LONG_AGO}), ("new", {})):
            row = MessageRow(id=f"{name}-{age}", robot="fred", kind="packet_report", body=body, **recorded)
            session.add(row)


def test_of_a_mission_that_is_not_over_every_message_is_kept(
    database: Database, workflows: Workflows
) -> None:
    add_mission(database, "over", "completed")
    add_mission(database, "open", "unknown")
    with database.write() as session:
        upkeep = {"body": {"kind": "upkeep_report"}}
        session.add(
            MessageRow(id="upkeep", robot="fred", kind="upkeep_report", body=upkeep, recorded_at=LONG_AGO)
        )
    assert Retention(database, workflows, days=30, events=1000).sweep().messages == 2
    with database.read() as session:
        assert set(session.scalars(select(MessageRow.id))) == {"over-new", "open-old", "open-new"}


def test_workflows_that_were_over_long_ago_are_forgotten(
    database: Database, workflows: Workflows, done: "Queue[str]"
) -> None:
    with database.write() as session:
        workflows.start(session, PLANNING, "note", "first", "one")
    assert done.get(timeout=30) == "one"
    assert Retention(database, workflows, days=1, events=1000).sweep().workflows == 0
    later = Retention(database, workflows, days=1, events=1000, now=lambda: time.time() + 2 * DAY_S)
    give_up = time.monotonic() + 30
    while later.sweep().workflows == 0:  # it is over a moment after it has done its work
        assert time.monotonic() < give_up
        time.sleep(0.05)
    assert later.sweep().workflows == 0
