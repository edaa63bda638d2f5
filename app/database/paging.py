"""Pages of a list, newest first, with a continuation token."""

from collections.abc import Sequence
from typing import Any, TypeVar

from sqlalchemy import Select, and_, or_
from sqlalchemy.orm import Session

from app.errors import Invalid

Row = TypeVar("Row")


def page(
    session: Session, query: Select[Row], table: Any, *, limit: int, after: str | None
) -> tuple[Sequence[Row], str | None]:
    """The first `limit` rows of `query` after the token, and the token of the next page, None at the end.

    :raises Invalid: if the token is none of ours.
    """
    if after is not None:
        created_at, _, row_id = after.partition("~")
        if not row_id:
            raise Invalid(f"no such continuation token: {after!r}", code="unknown-token")
        same = and_(table.created_at == created_at, table.id < row_id)
        query = query.where(or_(table.created_at < created_at, same))
    rows = session.scalars(query.order_by(table.created_at.desc(), table.id.desc()).limit(limit + 1)).all()
    if len(rows) <= limit:
        return rows, None
    last: Any = rows[limit - 1]
    return rows[:limit], f"{last.created_at}~{last.id}"
