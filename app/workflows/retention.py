"""Retention: deletes old events, robots' messages, workflows, ended holds, and goals with all that is theirs.

Nothing that an open goal or mission needs is deleted.
"""

import logging
from collections.abc import Callable
from dataclasses import dataclass

from sqlalchemy import delete, func, or_, select, tuple_

from app.domain.clock import SYSTEM_CLOCK, WallClock, iso_utc
from app.domain.lifecycles.dialogue import OPEN as OPEN_DIALOGUES
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.hold import HoldState
from app.domain.lifecycles.mission import OPEN
from app.settings import Settings
from app.store import (
    ConversationRow,
    Database,
    DialogueRow,
    EventRow,
    GoalRow,
    HoldRow,
    MessageRow,
    MissionRow,
    PlanRow,
    ResultRow,
    ScriptRow,
)
from app.store.records import UNENDED_SCRIPT
from app.workflows import Workflows
from app.workflows.background import Background

SWEEP_S = 3600.0
BATCH = 5000
"""Rows deleted in one transaction; other writers wait no longer than that takes."""
GOALS = 100
"""Goals deleted in one transaction, with their plans, missions and scripts."""
OVER = (GoalState.FINISHED, GoalState.WITHDRAWN, GoalState.UNSOLVABLE)
DAY_S = 86400.0

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Swept:
    """How many of each were deleted."""

    events: int
    messages: int
    workflows: int
    goals: int
    holds: int
    talks: int
    """Dialogues of persons with robots, and conversations of the service with robots."""


class Retention:
    """Deletes what exceeds its retention once an hour, in a thread of its own. Several processes may share a database.

    Events are deleted oldest first and the newest is kept: the remaining ones have no gaps, and numbers never start
    again. All messages of a running mission are kept: their ids prevent them from being recorded twice. A goal is
    deleted together with its plans, missions, scripts and results, but not while an order to stop is to be delivered to
    a lost robot. Holds, dialogues and conversations that have ended are kept as long as goals. Learned durations and
    facts are kept.
    """

    def __init__(
        self,
        database: Database,
        workflows: Workflows,
        *,
        days: float,
        goals_days: float,
        events: int,
        clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """
        :param days: how long events, messages and finished workflows are kept.
        :param goals_days: how long goals that are over are kept.
        :param events: the most events that are kept.
        """
        self._database = database
        self._workflows = workflows
        self._days = days
        self._goals_days = goals_days
        self._events = events
        self._clock = clock
        self._background = Background("retention", self._run)

    @classmethod
    def of(cls, database: Database, workflows: Workflows, settings: Settings) -> "Retention":
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
        """Delete what exceeds its retention; returns the counts."""
        reported_before = self._days_ago(self._days)
        over_before = self._days_ago(self._goals_days)
        return Swept(
            events=self._in_batches(lambda: self._drop_events(reported_before)),
            messages=self._in_batches(lambda: self._drop_messages(reported_before)),
            workflows=self._in_batches(lambda: self._workflows.delete_finished(reported_before, BATCH // 10)),
            goals=self._in_batches(lambda: self._drop_goals(over_before)),
            holds=self._in_batches(lambda: self._drop_holds(over_before)),
            talks=self._in_batches(lambda: self._drop_talks(over_before)),
        )

    def _days_ago(self, days: float) -> str:
        return iso_utc(self._clock.epoch_s() - days * DAY_S)

    def _run(self) -> None:
        while not self._clock.wait(self._background.ending, SWEEP_S):
            try:
                swept = self.sweep()
                logger.info("retention sweep deleted: %s", swept)
            except Exception:
                logger.exception("retention sweep failed")

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
            .where(MissionRow.state.in_(OPEN))
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

    def _drop_holds(self, before: str) -> int:
        ended = (HoldRow.state == HoldState.ENDED, HoldRow.ended_at < before)
        with self._database.write() as session:
            old = session.scalars(select(HoldRow.id).where(*ended).limit(BATCH)).all()
            session.execute(delete(HoldRow).where(HoldRow.id.in_(old)))
            return len(old)

    def _drop_talks(self, before: str) -> int:
        said = (DialogueRow.state.not_in(OPEN_DIALOGUES), DialogueRow.created_at < before)
        over = (ConversationRow.is_over, ConversationRow.opened_at < before)
        key = tuple_(ConversationRow.id, ConversationRow.robot)
        with self._database.write() as session:
            dialogues = session.scalars(select(DialogueRow.id).where(*said).limit(BATCH)).all()
            session.execute(delete(DialogueRow).where(DialogueRow.id.in_(dialogues)))
            talks = session.execute(
                select(ConversationRow.id, ConversationRow.robot).where(*over).limit(GOALS)
            ).all()
            session.execute(delete(ConversationRow).where(key.in_([tuple(one) for one in talks])))
            return len(dialogues) + len(talks)

    def _drop_goals(self, before: str) -> int:
        missions = select(MissionRow.id, MissionRow.goal_id, MissionRow.state).subquery()
        under_way = select(missions.c.goal_id).where(missions.c.state.in_(OPEN))
        to_be_told = (
            select(missions.c.goal_id)
            .join(ScriptRow, ScriptRow.mission_id == missions.c.id)
            .where(ScriptRow.abandoned, *UNENDED_SCRIPT)
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
                session.execute(delete(ResultRow).where(ResultRow.mission_id.in_(gone)))
                session.execute(delete(ScriptRow).where(ScriptRow.mission_id.in_(gone)))
                session.execute(delete(MissionRow).where(MissionRow.goal_id.in_(goals)))
                session.execute(delete(PlanRow).where(PlanRow.goal_id.in_(goals)))
                session.execute(delete(GoalRow).where(GoalRow.id.in_(goals)))
            return len(goals)
