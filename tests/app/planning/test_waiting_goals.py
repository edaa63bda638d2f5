"""Which of the goals that wait is planned next."""

from collections.abc import Iterator
from contextlib import AbstractContextManager, closing
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import pytest
from dbos import DBOS
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.lifecycles.goal import GoalState
from app.planning.waiting_goals import GOALS_PER_WORKFLOW, WaitingGoals, most_urgent
from app.store import Database, GoalRow, WorldRow
from app.store.event_log import EventLog
from app.store.facts import FactStore
from app.store.migrate import migrate
from app.store.plan_nets import PlanNets
from app.store.reservations import Reservations
from app.workflows import PLAN_WAITING, WAITING, Workflows
from planner import load_knowledge_base
from tests.waiting import until


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Database]:
    """A record with one world."""
    with closing(Database(f"sqlite:///{tmp_path / 'lab.sqlite'}")) as database:
        migrate(database)
        with database.write() as session:
            session.add(WorldRow(id="lab", title="Lab", layout={}, releases=0))
        yield database


@pytest.fixture
def workflows(lab: Database) -> Iterator[Workflows]:
    """Not launched."""
    with closing(Workflows(lab.url)) as workflows:
        yield workflows


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    database = Database(f"sqlite:///{tmp_path / 'record.sqlite'}")
    migrate(database)
    with database.write() as session:
        session.add(WorldRow(id="lab", title="Lab", layout={}, releases=1))
        session.flush()
        yield session
    database.close()


def waiting(session: Session, name: str, **more: Any) -> None:
    usual = {
        "id": name,
        "world": "lab",
        "text": name,
        "goal": [],
        "priority": 0,
        "auto_approve": False,
        "state": GoalState.WAITING,
        "reason": "waits for mission m",
        "created_by": "me",
    }
    session.add(GoalRow(**{**usual, **more}))
    session.flush()


def order(session: Session) -> list[str]:
    """The goals in the order they are planned in; none gets a plan."""
    planned = []
    while (name := most_urgent(session, "lab")) is not None:
        planned.append(name)
        session.get_one(GoalRow, name).releases_seen = session.get_one(WorldRow, "lab").releases
        session.flush()
    return planned


def test_priority_comes_before_deadline_and_deadline_before_age(session: Session) -> None:
    waiting(session, "old", created_at="2026-01-01T00:00:00Z")
    waiting(session, "new", created_at="2026-01-02T00:00:00Z")
    waiting(session, "late", deadline_at_s=900.0)
    waiting(session, "soon", deadline_at_s=100.0)
    waiting(session, "urgent", priority=5)
    waiting(session, "more urgent, soon", priority=5, deadline_at_s=100.0)
    assert order(session) == ["more urgent, soon", "urgent", "soon", "late", "old", "new"]


def test_a_goal_is_planned_once_for_all_that_became_free_until_then(session: Session) -> None:
    waiting(session, "one")
    assert order(session) == ["one"]
    assert order(session) == []
    session.get_one(WorldRow, "lab").releases += 3
    session.flush()
    assert order(session) == ["one"]


def test_many_goals_are_planned_by_several_workflows_one_after_the_other(
    lab: Database, workflows: Workflows
) -> None:
    goals, planned = WaitingGoals(core_of(lab, workflows), clocks={}), SimpleQueue[str]()

    def plan(goal_id: str) -> None:
        with lab.write() as session:
            session.get_one(GoalRow, goal_id).releases_seen = 1
        planned.put(goal_id)

    workflows.register(PLAN_WAITING, partial(goals.run, plan=plan), makes_room_in=(WAITING,))
    workflows.launch()
    names = [f"goal {number:03}" for number in range(2 * GOALS_PER_WORKFLOW + 1)]
    with lab.write() as session:
        for name in names:
            waiting(session, name, created_at=name, releases_seen=0)
        goals.release(session, "lab")
    assert [planned.get(timeout=30) for _ in names] == names
    until(lambda: [one.status for one in DBOS.list_workflows(name=PLAN_WAITING)] == ["SUCCESS"] * 3)


def test_an_available_robot_is_not_forgotten_while_the_database_is_away_or_another_comes(
    lab: Database, workflows: Workflows, monkeypatch: pytest.MonkeyPatch
) -> None:
    goals = WaitingGoals(core_of(lab, workflows), clocks={})
    write = lab.write

    def away() -> AbstractContextManager[Session]:
        raise ConnectionError("away")

    def another_comes() -> AbstractContextManager[Session]:
        goals.robot_available("lab")
        return write()

    goals.robot_available("lab")
    monkeypatch.setattr(lab, "write", away)
    with pytest.raises(ConnectionError):
        goals.handle_availability("lab")
    monkeypatch.setattr(lab, "write", another_comes)
    goals.handle_availability("lab")
    monkeypatch.setattr(lab, "write", write)
    for _ in range(2):
        goals.handle_availability("lab")
    with lab.read() as session:
        assert session.get_one(WorldRow, "lab").releases == 2


def core_of(database: Database, workflows: Workflows) -> Core:
    events, knowledge_base = EventLog(database), load_knowledge_base()
    return Core(
        database=database,
        events=events,
        facts=FactStore(events, knowledge_base),
        workflows=workflows,
        knowledge_base=knowledge_base,
        plan_nets=PlanNets(knowledge_base),
        reservations=Reservations(PlanNets(knowledge_base)),
    )


@pytest.mark.parametrize("state", [GoalState.SUBMITTED, GoalState.PLANNING, GoalState.WITHDRAWN])
def test_goals_that_do_not_wait_are_left_alone(session: Session, state: GoalState) -> None:
    waiting(session, "one", state=state)
    assert order(session) == []
