"""What is not known: objects and robots of which no place is believed, kept with what was believed of them last."""

from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.world_model.beliefs import OBJECT_POSITION, ROBOT_POSITION
from app.store import UnknownRow

PLACED = (OBJECT_POSITION, ROBOT_POSITION)
"""The predicates of facts that place a thing."""


def unknowns(session: Session, world: str) -> Sequence[UnknownRow]:
    query = select(UnknownRow).where(UnknownRow.world == world).order_by(UnknownRow.name)
    return session.scalars(query).all()
