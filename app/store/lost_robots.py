"""The robots that were declared lost, as the record says."""

from collections.abc import Mapping, Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.store import LostRobotRow


def lost_rows(session: Session, world: str) -> Sequence[LostRobotRow]:
    query = select(LostRobotRow).where(LostRobotRow.world == world).order_by(LostRobotRow.robot)
    return session.scalars(query).all()


def lost_in(session: Session, world: str) -> Mapping[str, str]:
    """The lost robots of a world, each with the reason why it is not recruited, in words."""
    return {row.robot: f"which {row.declared_by} declared lost" for row in lost_rows(session, world)}
