"""What is kept how long: old events, robots' messages, workflows and goals go, with all that was made for them; nothing
that an open goal or mission needs."""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from sqlalchemy import delete, func, or_, select

from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import ENDED
from app.settings import Settings
from app.store import Database, EventRow, GoalRow, MessageRow, MissionRow, PlanRow, ScriptRow
from app.store.mission_record import UNENDED
from app.workflows import Workflows
from app.workflows.background import Background

SWEEP_S = 3600.0
BATCH = 5000
"""Rows deleted in one transaction: whoever waits to write waits no longer than that takes."""
GOALS = 100
"""Goals deleted in one transaction, with their plans, missions and scripts."""
OVER = (GoalState.FINISHED, GoalState.WITHDRAWN, GoalState.UNSOLVABLE)

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Swept:
    """How many of each were deleted."""

    events: int
    messages: int
    workflows: int
    goals: int


class Retention:
    """Sweeps the record now and then, in a thread of its own. Several processes may do so on one record.

    Events go oldest first and the newest stays: those that are left have no gaps, and numbers do not begin again.
    Of a mission that is not over every message stays: its id keeps it from being taken twice. A goal goes with its
    plans, missions and scripts at once, but while a lost robot is still to be told to stop. What was learned of
    durations and what is believed of the world stay.
    """

    def __init__(
        self,
        database: Database,
        workflows: Workflows,
        *,
        days: float,
        goals_days: float,
        events: int,
        now: Callable[[], float] = time.time,
    ) -> None:
        """
        :param days: how long events, messages and workflows are kept; `goals_days`: goals that are over.
        :param events: so many events at most are kept.
        :param now: the wall clock, epoch seconds.
        """
        self._database, self._workflows = database, workflows
        self._days, self._goals_days, self._events, self._now = days, goals_days, events, now
        self._background = Background("retention", self._run)

    @classmethod
    def of(cls, database: Database, workflows: Workflows, settings: Settings) -> "Retention":
        """As the settings say."""
        return cls(
            database,
            workflows,
            days=settings.keep_days,
            goals_days=settings.keep_goals_days,
            events=settings.keep_events,
        )

    def start(self) -> None:
        self._background.start()

    def close(self) -> None:
        self._background.end()

    def sweep(self) -> Swept:
        """Delete what is old."""
        told, over = self._before(self._days), self._before(self._goals_days)
        return Swept(
            events=self._in_batches(lambda: self._drop_events(told)),
            messages=self._in_batches(lambda: self._drop_messages(told)),
            workflows=self._in_batches(lambda: self._workflows.forget(told, BATCH // 10)),
            goals=self._in_batches(lambda: self._drop_goals(over)),
        )

    def _before(self, days: float) -> str:
        """The instant so many days ago, as the record writes it."""
        instant = datetime.fromtimestamp(self._now(), UTC) - timedelta(days=days)
        return instant.isoformat(timespec="milliseconds").replace("+00:00", "Z")

    def _run(self) -> None:
        while not self._background.ending.wait(SWEEP_S):
            try:
                swept = self.sweep()
                logger.info("swept the record: %s", swept)
            except Exception:
                logger.exception("the record could not be swept")

    def _in_batches(self, drop: Callable[[], int]) -> int:
        total = 0
        while not self._background.ending.is_set() and (dropped := drop()):
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

    def _drop_goals(self, before: str) -> int:
        missions = select(MissionRow.id, MissionRow.goal_id, MissionRow.state).subquery()
        under_way = select(missions.c.goal_id).where(missions.c.state.not_in(ENDED))
        to_be_told = (
            select(missions.c.goal_id)
            .join(ScriptRow, ScriptRow.mission_id == missions.c.id)
            .where(ScriptRow.abandoned, *UNENDED)
        )
        old = (
            select(GoalRow.id)
            .where(
                GoalRow.state.in_(OVER),
                GoalRow.updated_at < before,
                GoalRow.id.not_in(under_way),
                GoalRow.id.not_in(to_be_told),
            )
            .order_by(GoalRow.updated_at)
            .limit(GOALS)
            .with_for_update(skip_locked=True)
        )
        with self._database.write() as session:
            goals = session.scalars(old).all()
            if goals:
                gone = select(MissionRow.id).where(MissionRow.goal_id.in_(goals))
                session.execute(delete(ScriptRow).where(ScriptRow.mission_id.in_(gone)))
                session.execute(delete(MissionRow).where(MissionRow.goal_id.in_(goals)))
                session.execute(delete(PlanRow).where(PlanRow.goal_id.in_(goals)))
                session.execute(delete(GoalRow).where(GoalRow.id.in_(goals)))
            return len(goals)
