"""Pages of a list, newest first, with a continuation token."""

from collections.abc import Sequence
from typing import TypeVar

from sqlalchemy import and_, or_, select
from sqlalchemy.orm import Session

from app.domain.errors import Invalid
from app.store.tables import GoalRow, MissionRow, PlanRow

Row = TypeVar("Row", GoalRow, PlanRow, MissionRow)


def page(
    session: Session, table: type[Row], *, limit: int, after: str | None, **equal: str | None
) -> tuple[Sequence[Row], str | None]:
    """The first `limit` rows after the token, and the token of the next page, None at the end.

    :param equal: columns and the values they must have; None leaves a column open.
    :raises Invalid: if the token is none of ours.
    """
    query = select(table).where(*(getattr(table, name) == v for name, v in equal.items() if v is not None))
    if after is not None:
        created_at, _, row_id = after.partition("~")
        if not row_id:
            raise Invalid(f"no such continuation token: {after!r}", code="unknown-token")
        same = and_(table.created_at == created_at, table.id < row_id)
        query = query.where(or_(table.created_at < created_at, same))
    rows = session.scalars(query.order_by(table.created_at.desc(), table.id.desc()).limit(limit + 1)).all()
    if len(rows) <= limit:
        return rows, None
    last = rows[limit - 1]
    return rows[:limit], f"{last.created_at}~{last.id}"
