"""What was said about a mission: by its robots to each other, as they have reported it, and with the service."""

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.events import SpeechHeard, SpeechSaid
from app.store import EventRow, MissionRow, PlanRow


def speech_of(session: Session, mission_id: str) -> Sequence[EventRow]:
    """The events of speech of a mission that the log still has, in the order in which the service heard of them."""
    (kind,) = SpeechHeard.types()
    query = select(EventRow).where(EventRow.subject == mission_id, EventRow.type == kind)
    return session.scalars(query.order_by(EventRow.seq)).all()


def conversation_of(session: Session, mission: MissionRow) -> Sequence[Mapping[str, Any]]:
    """What was said about the mission, its goal and the goal's plans, in the order in which it was said."""
    (said,) = SpeechSaid.types()
    plans = session.scalars(select(PlanRow.id).where(PlanRow.goal_id == mission.goal_id)).all()
    subjects = (mission.id, mission.goal_id, *plans)
    query = select(EventRow).where(EventRow.subject.in_(subjects), EventRow.type == said)
    with_service = [
        {**row.data, "robot": row.data["receiver"]} for row in session.scalars(query.order_by(EventRow.seq))
    ]
    return sorted(
        [*(row.data for row in speech_of(session, mission.id)), *with_service],
        key=lambda one: (one["sent_at_s"], one["at_s"]),
    )
