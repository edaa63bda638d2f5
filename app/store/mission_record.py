"""Missions in the record."""

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.lifecycles.script import DELIVERABLE, TERMINAL_SCRIPTS
from app.store import GoalRow, MissionRow, ScriptRow

UNENDED = (
    ScriptRow.delivery.in_(DELIVERABLE),
    ScriptRow.state.is_(None) | ScriptRow.state.not_in(TERMINAL_SCRIPTS),
)
"""Of scripts: given to a robot, which has not said that it has ended."""


def locked_after_goal(session: Session, mission_id: str) -> MissionRow:
    """The mission, locked, and its goal before it, as all do who may change both."""
    goal_id = session.scalars(select(MissionRow.goal_id).where(MissionRow.id == mission_id)).one()
    session.get_one(GoalRow, goal_id, with_for_update=True)
    return session.get_one(MissionRow, mission_id, with_for_update=True)
