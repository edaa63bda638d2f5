"""What is not known: objects and robots of which no place is believed, kept with what was believed of them last."""

from collections.abc import Iterable, Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.world_model.beliefs import OBJECT_POSITION, ROBOT_POSITION
from app.store import FactRow, UnknownRow

PLACED = (OBJECT_POSITION, ROBOT_POSITION)


def unknowns(session: Session, world: str) -> Sequence[UnknownRow]:
    query = select(UnknownRow).where(UnknownRow.world == world).order_by(UnknownRow.name)
    return session.scalars(query).all()


def note_unknown(
    session: Session,
    world: str,
    *,
    gone: Iterable[FactRow],
    left: Iterable[FactRow],
    source: str,
    at_s: float,
) -> None:
    """Keep in mind what lost its place, and forget what has one again.

    :param gone: the facts that are not believed any more.
    :param left: all that are.
    """
    placed = {row.args[0] for row in left if row.predicate in PLACED}
    for known in unknowns(session, world):
        if known.name in placed:
            session.delete(known)
    for row in gone:
        if row.predicate not in PLACED or row.args[0] in placed:
            continue
        believed = {"predicate": row.predicate, "args": list(row.args)}
        doubt = session.get(UnknownRow, (world, row.args[0])) or UnknownRow(world=world, name=row.args[0])
        doubt.believed, doubt.believed_by, doubt.believed_at_s = believed, row.source, row.at_s
        doubt.source, doubt.since_s = source, at_s
        session.add(doubt)
