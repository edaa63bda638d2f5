"""What the robots of a mission have said to each other, as far as they have reported it."""

from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.events import SpeechHeard
from app.store import EventRow


def speech_of(session: Session, mission_id: str) -> Sequence[EventRow]:
    """The events of speech of a mission that the log still has, in the order in which the service heard of them."""
    (kind,) = SpeechHeard.types()
    query = select(EventRow).where(EventRow.subject == mission_id, EventRow.type == kind)
    return session.scalars(query.order_by(EventRow.seq)).all()
