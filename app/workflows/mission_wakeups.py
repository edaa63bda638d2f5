"""Wakes the workflows of missions when something they rely on may have changed."""

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.lifecycles.mission import OPEN
from app.store import MissionRow
from app.workflows import Workflows


def wake_missions(session: Session, workflows: Workflows, world: str, *, but: str = "") -> None:
    """Wake the running missions of a world if the caller's transaction commits.

    :param but: a mission that the caller wakes itself.
    """
    query = select(MissionRow.workflow).where(
        MissionRow.world == world, MissionRow.state.in_(OPEN), MissionRow.id != but
    )
    for workflow in session.scalars(query):
        workflows.wake(session, workflow)
