"""Goals in the record."""

from sqlalchemy.orm import Session

from app.domain.errors import unrecorded
from app.store import GoalRow


def goal_to_change(session: Session, goal_id: str) -> GoalRow:
    """The goal's row, locked.

    :raises NotFound: if there is none.
    """
    row = session.get(GoalRow, goal_id, with_for_update=True)
    if row is None:
        raise unrecorded("goal", goal_id)
    return row
