"""Missions in the record."""

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.database import GoalRow, MissionRow


def locked_after_goal(session: Session, mission_id: str) -> MissionRow:
    """The mission, locked, and its goal before it, as all do who may change both."""
    goal_id = session.scalars(select(MissionRow.goal_id).where(MissionRow.id == mission_id)).one()
    session.get_one(GoalRow, goal_id, with_for_update=True)
    return session.get_one(MissionRow, mission_id, with_for_update=True)
