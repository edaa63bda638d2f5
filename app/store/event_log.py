"""The event log: what happened, in order, for streams and for the audit record."""

import threading
from collections.abc import Sequence
from typing import Any

from pydantic_core import to_jsonable_python
from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.events import Event
from app.store import Database, EventRow, write_last


def envelope(row: EventRow) -> dict[str, Any]:
    """The event as the stream and recordings have it."""
    return {"seq": row.seq, "time": row.time, "type": row.type, "subject": row.subject, "data": row.data}


class EventLog:
    """Appends events inside the caller's transaction, and wakes waiting streams once it has committed."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._changed = threading.Condition()
        self._generation = 0
        database.watch(self._notify, EventRow)

    def append(self, session: Session, event: Event) -> None:
        """Record the event."""
        data = to_jsonable_python(event)
        write_last(session, EventRow, type=event.type, subject=data.pop("subject"), data=data)

    def since(self, seq: int, limit: int = 500) -> Sequence[EventRow]:
        """The events after `seq`, oldest first."""
        with self._database.read() as session:
            query = select(EventRow).where(EventRow.seq > seq).order_by(EventRow.seq).limit(limit)
            return session.scalars(query).all()

    def last(self) -> int:
        """The newest event's sequence number; 0 before the first."""
        with self._database.read() as session:
            query = select(EventRow.seq).order_by(EventRow.seq.desc()).limit(1)
            return session.scalar(query) or 0

    def has_forgotten(self, seq: int) -> bool:
        """True if an event after `seq` is no longer kept."""
        with self._database.read() as session:
            oldest = session.scalar(select(EventRow.seq).order_by(EventRow.seq).limit(1))
        return oldest is not None and seq + 1 < oldest

    @property
    def generation(self) -> int:
        return self._generation

    def wait(self, generation: int, timeout_s: float) -> int:
        """Block until events have been committed since `generation`; returns the new generation."""
        with self._changed:
            self._changed.wait_for(lambda: self._generation != generation, timeout_s)
            return self._generation

    def _notify(self) -> None:
        with self._changed:
            self._generation += 1
            self._changed.notify_all()
