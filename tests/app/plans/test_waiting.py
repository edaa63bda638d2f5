"""Which of the goals that wait is planned next."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy.orm import Session

from app.database import Database, GoalRow, WorldRow
from app.database.migrate import migrate
from app.plans.waiting import most_urgent
from app.states import GoalState


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
        "state": GoalState.SUBMITTED,
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


@pytest.mark.parametrize(
    "more", [{"state": GoalState.PLANNING}, {"reason": ""}, {"state": GoalState.WITHDRAWN}]
)
def test_goals_that_do_not_wait_are_left_alone(session: Session, more: dict[str, Any]) -> None:
    waiting(session, "one", **more)
    assert order(session) == []
