"""What is kept how long: old events, robots' messages and workflows go; nothing that an open goal or mission needs."""

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from sqlalchemy import delete, func, or_, select

from app.database import Database, EventRow, MessageRow, MissionRow, ScriptRow
from app.durable import Workflows
from app.settings import Settings
from app.states import ENDED

SWEEP_S = 3600.0
BATCH = 5000
"""Rows deleted in one transaction: whoever waits to write waits no longer than that takes."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Swept:
    """How many of each were deleted."""

    events: int
    messages: int
    workflows: int


class Retention:
    """Sweeps the record now and then, in a thread of its own. Several processes may do so on one record.

    Events go oldest first and the newest stays: those that are left have no gaps, and numbers do not begin again.
    Of a mission that is not over every message stays: its id keeps it from being taken twice.
    """

    def __init__(
        self,
        database: Database,
        workflows: Workflows,
        *,
        days: float,
        events: int,
        now: Callable[[], float] = time.time,
    ) -> None:
        """
        :param events: so many events at most are kept.
        :param now: the wall clock, epoch seconds.
        """
        self._database, self._workflows = database, workflows
        self._span, self._events, self._now = timedelta(days=days), events, now
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="retention", daemon=True)

    @classmethod
    def of(cls, database: Database, workflows: Workflows, settings: Settings) -> "Retention":
        """As the settings say."""
        return cls(database, workflows, days=settings.keep_days, events=settings.keep_events)

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(timeout=5)

    def sweep(self) -> Swept:
        """Delete what is old."""
        before = datetime.fromtimestamp(self._now(), UTC) - self._span
        told = before.isoformat(timespec="milliseconds").replace("+00:00", "Z")
        return Swept(
            events=self._in_batches(lambda: self._drop_events(told)),
            messages=self._in_batches(lambda: self._drop_messages(told)),
            workflows=self._in_batches(lambda: self._workflows.forget(told, BATCH // 10)),
        )

    def _run(self) -> None:
        while not self._stop.wait(SWEEP_S):
            try:
                swept = self.sweep()
                logger.info("swept the record: %s", swept)
            except Exception:
                logger.exception("the record could not be swept")

    def _in_batches(self, drop: Callable[[], int]) -> int:
        total = 0
        while not self._stop.is_set() and (dropped := drop()):
            total += dropped
        return total

    def _drop_events(self, before: str) -> int:
        with self._database.write() as session:
            newest = session.scalar(select(func.max(EventRow.seq))) or 0
            old = or_(EventRow.time < before, EventRow.seq <= newest - self._events)
            oldest = select(EventRow.seq).order_by(EventRow.seq).limit(BATCH)
            last = session.scalar(
                select(func.max(EventRow.seq)).where(EventRow.seq.in_(oldest), old, EventRow.seq < newest)
            )
            if last is None:
                return 0
            return session.connection().execute(delete(EventRow).where(EventRow.seq <= last)).rowcount

    def _drop_messages(self, before: str) -> int:
        script = MessageRow.body["body"]["script_id"].as_string()
        open_scripts = (
            select(ScriptRow.id)
            .join(MissionRow, MissionRow.id == ScriptRow.mission_id)
            .where(MissionRow.state.not_in(ENDED))
        )
        with self._database.write() as session:
            old = session.scalars(
                select(MessageRow.id)
                .where(MessageRow.recorded_at < before, or_(script.is_(None), script.not_in(open_scripts)))
                .limit(BATCH)
            ).all()
            if not old:
                return 0
            return session.connection().execute(delete(MessageRow).where(MessageRow.id.in_(old))).rowcount
