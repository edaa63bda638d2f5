"""What is old goes, what is needed stays."""

from collections.abc import Iterator
from queue import Queue
from typing import Any

import pytest
from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.clock import SYSTEM_CLOCK, iso_utc
from app.store import (
    ConversationRow,
    Database,
    DialogueRow,
    DurationRow,
    EventRow,
    FactRow,
    GoalRow,
    HoldRow,
    MessageRow,
    MissionRow,
    PlanRow,
    ResultRow,
    ScriptRow,
    WorldRow,
)
from app.store.event_log import EventLog
from app.workflows import PLANNING, Workflows
from app.workflows.retention import DAY_S, GOALS, Retention, Swept
from tests.app.stepped_clock import SteppedClock
from tests.databases import ON_BOTH
from tests.waiting import until

pytestmark = ON_BOTH
WITH_A_GOAL = (GoalRow, PlanRow, MissionRow, ScriptRow, ResultRow)
LONG_AGO = "2020-01-01T00:00:00.000Z"


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


def sweeper(database: Database, workflows: Workflows, **changes: Any) -> Retention:
    kept: dict[str, Any] = {"days": 30, "goals_days": 365, "events": 1000, **changes}
    return Retention(database, workflows, **kept)


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
    retention = sweeper(database, workflows)
    assert retention.sweep() == Swept(events=2, messages=0, workflows=0, goals=0, holds=0, talks=0)
    assert kept(database) == [3, 4]
    assert [log.has_forgotten(seen) for seen in (0, 1, 2, 3, 4)] == [True, True, False, False, False]
    write_events(database, None)
    assert kept(database) == [3, 4, 5]


def test_holds_that_ended_long_ago_go_and_those_that_stand_stay(
    database: Database, workflows: Workflows
) -> None:
    usual = {"world": "lab", "places": ["bay"], "kept": ["bay"], "until": {}, "goal_id": "g", "text": "keep"}
    with database.write() as session:
        session.add(WorldRow(id="lab", title="Lab", layout={}))
        session.flush()
        for name, state, ended_at in (
            ("old", "ended", LONG_AGO),
            ("new", "ended", iso_utc(SYSTEM_CLOCK.epoch_s())),
            ("standing", "held", None),
        ):
            row = {**usual, "id": name, "state": state, "ended_at": ended_at, "created_by": "me"}
            session.add(HoldRow(**row, created_at=LONG_AGO))
    assert sweeper(database, workflows).sweep().holds == 1
    with database.read() as session:
        assert set(session.scalars(select(HoldRow.id))) == {"new", "standing"}


def test_what_was_said_long_ago_goes_and_what_is_open_stays(database: Database, workflows: Workflows) -> None:
    dialogue = {"world": "lab", "robot": "yard_2", "text": "halt", "said_by": "me", "created_at": LONG_AGO}
    talk = {
        "world": "lab",
        "protocol": "fipa-request",
        "is_ours": True,
        "state": "done",
        "opened_at": LONG_AGO,
    }
    with database.write() as session:
        for name, state in (("done", "done"), ("shown", "proposed")):
            session.add(DialogueRow(**dialogue, id=name, state=state))
        for name, robot, is_over in (
            ("call", "yard_1", True),
            ("call", "yard_2", False),
            ("old", "yard_2", True),
        ):
            session.add(ConversationRow(**talk, id=name, robot=robot, is_over=is_over))
    assert sweeper(database, workflows).sweep().talks == 3
    with database.read() as session:
        assert session.scalars(select(DialogueRow.id)).all() == ["shown"]
        assert session.execute(select(ConversationRow.id, ConversationRow.robot)).all() == [
            ("call", "yard_2")
        ]


def test_of_too_many_events_the_newest_are_kept(database: Database, workflows: Workflows) -> None:
    write_events(database, *[None] * 20)
    assert sweeper(database, workflows, events=8).sweep().events == 12
    assert kept(database) == list(range(13, 21))


def test_the_newest_event_stays_however_old_it_is(database: Database, workflows: Workflows) -> None:
    write_events(database, LONG_AGO, LONG_AGO, LONG_AGO)
    sweeper(database, workflows).sweep()
    assert kept(database) == [3]


def add_goal(session: Session, name: str, state: str, *, since: str | None = None) -> None:
    if session.get(WorldRow, "lab") is None:
        session.add(WorldRow(id="lab", title="", layout={}, version=1))
        session.flush()
    dated = {"updated_at": since} if since else {}
    row = GoalRow(
        id=f"goal-{name}",
        world="lab",
        text="",
        goal=[],
        priority=0,
        auto_approve=False,
        created_by="",
        **dated,
    )
    row.state = state
    session.add(row)
    session.flush()


def add_mission(
    database: Database,
    name: str,
    state: str,
    /,
    *,
    goal: str = "committed",
    since: str | None = None,
    **script: Any,
) -> None:
    """A mission with one script, of which a robot said something long ago and something now.

    :param goal: the state that its goal is in, `since` an instant.
    """
    with database.write() as session:
        add_goal(session, name, goal, since=since)
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
                workflow=name,
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
        given = {"delivery": "acknowledged", "body": {}, "packets": {}, "perceived": [], **script}
        session.add(
            ScriptRow(id=f"{name}-fred", mission_id=name, plan_id=f"plan-{name}", robot="fred", **given)
        )
        session.flush()
        session.add(
            ResultRow(
                id=f"{name}-image",
                mission_id=name,
                script_id=f"{name}-fred",
                packet_id="LOOK",
                robot="fred",
                kind="image",
                name="camera",
                of="bay_4",
                at_s=1.0,
                content=b"taken",
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
    assert sweeper(database, workflows).sweep().messages == 2
    with database.read() as session:
        assert set(session.scalars(select(MessageRow.id))) == {"over-new", "open-old", "open-new"}


def rows(database: Database) -> dict[str, set[str]]:
    """The missions that are left, by what is left of each."""
    with database.read() as session:
        found = {table.__tablename__: set(session.scalars(select(table.id))) for table in WITH_A_GOAL}
    return found


def everything_of(*missions: str) -> dict[str, set[str]]:
    return {
        "goals": {f"goal-{name}" for name in missions},
        "plans": {f"plan-{name}" for name in missions},
        "missions": set(missions),
        "scripts": {f"{name}-fred" for name in missions},
        "results": {f"{name}-image" for name in missions},
    }


def test_goals_that_were_over_long_ago_go_with_all_that_was_made_for_them(
    database: Database, workflows: Workflows
) -> None:
    add_mission(database, "old", "completed", goal="finished", since=LONG_AGO)
    add_mission(database, "new", "failed", goal="finished")
    assert sweeper(database, workflows).sweep().goals == 1
    assert rows(database) == everything_of("new")
    assert sweeper(database, workflows).sweep().goals == 0


def test_goals_that_are_not_over_stay_however_old_they_are(database: Database, workflows: Workflows) -> None:
    add_mission(database, "unknown", "unknown", goal="committed", since=LONG_AGO)
    with database.write() as session:
        for state in ("submitted", "waiting", "planning", "planned"):
            add_goal(session, state, state, since=LONG_AGO)
        for state in ("withdrawn", "unsolvable"):
            add_goal(session, state, state, since=LONG_AGO)
    assert sweeper(database, workflows).sweep().goals == 2
    assert rows(database)["goals"] == {
        "goal-unknown",
        "goal-submitted",
        "goal-waiting",
        "goal-planning",
        "goal-planned",
    }


def test_a_goal_stays_while_a_lost_robot_of_it_is_still_to_be_stopped(
    database: Database, workflows: Workflows
) -> None:
    over: dict[str, Any] = {"goal": "finished", "since": LONG_AGO, "abandoned": True}
    add_mission(database, "owed", "failed", **over)
    add_mission(database, "told", "failed", **over, state="cancelled")
    assert sweeper(database, workflows).sweep().goals == 1
    assert rows(database) == everything_of("owed")


def test_what_was_learned_and_believed_outlasts_the_goals_it_came_of(
    database: Database, workflows: Workflows
) -> None:
    add_mission(database, "old", "completed", goal="finished", since=LONG_AGO)
    with database.write() as session:
        session.add(
            FactRow(world="lab", atom="in(a, b)", predicate="in", args=["a", "b"], source="fred", at_s=1.0)
        )
        session.add(DurationRow(world="lab", action="go", team=1, samples=3, mean=1.2, variance=0.1))
    assert sweeper(database, workflows).sweep().goals == 1
    with database.read() as session:
        assert [fact.source for fact in session.scalars(select(FactRow))] == ["fred"]
        assert [known.samples for known in session.scalars(select(DurationRow))] == [3]


def test_many_old_goals_go_in_batches(database: Database, workflows: Workflows) -> None:
    with database.write() as session:
        for number in range(2 * GOALS + 1):
            add_goal(session, str(number), "finished", since=LONG_AGO)
    assert sweeper(database, workflows).sweep().goals == 2 * GOALS + 1
    assert rows(database) == everything_of()


def test_workflows_that_were_over_long_ago_are_forgotten(
    database: Database, workflows: Workflows, done: "Queue[str]"
) -> None:
    with database.write() as session:
        workflows.start(session, PLANNING, "note", "first", "one")
    assert done.get(timeout=30) == "one"
    assert sweeper(database, workflows, days=1).sweep().workflows == 0
    later = sweeper(database, workflows, days=1, clock=SteppedClock(SYSTEM_CLOCK.epoch_s() + 2 * DAY_S))
    until(lambda: later.sweep().workflows > 0)  # it is over a moment after it has done its work
    assert later.sweep().workflows == 0
