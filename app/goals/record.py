"""Goals in the record."""

from sqlalchemy.orm import Session

from app.database import GoalRow
from app.errors import unrecorded


def goal_to_change(session: Session, goal_id: str) -> GoalRow:
    """The goal's row, locked.

    :raises NotFound: if there is none.
    """
    row = session.get(GoalRow, goal_id, with_for_update=True)
    if row is None:
        raise unrecorded("goal", goal_id)
    return row
