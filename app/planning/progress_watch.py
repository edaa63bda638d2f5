"""A goal being planned: its progress goes to the record, operators' wishes to stop or cancel come from there."""

import time
from typing import Any

from app.domain.events import GoalProgress
from app.domain.states import GoalState
from app.planning.pool.process import Watch
from app.store import Database, GoalRow
from app.store.event_log import EventLog
from planner import Progress

TELL_S = 0.5
"""Progress is recorded at most this often."""
LOOK_S = 0.25
"""Operators' wishes are looked for at most this often."""


class GoalWatch(Watch):
    """Watches what is planned for one goal while the goal is in one state. For one thread."""

    def __init__(
        self, database: Database, events: EventLog, goal_id: str, during: GoalState = GoalState.PLANNING
    ) -> None:
        self._database, self._events, self._goal_id, self._during = database, events, goal_id, during
        self._newest: Progress | None = None
        self._told: dict[str, Any] = {}
        # A plan that is found at once needs no word of its progress.
        self._told_at, self._looked_at = time.monotonic(), float("-inf")
        self._stop = self._cancelled = False

    def progress(self, progress: Progress) -> None:
        self._newest = progress
        self._tell()

    def should_stop(self) -> bool:
        self._tell()
        self._look()
        return self._stop

    def is_cancelled(self) -> bool:
        self._look()
        return self._cancelled

    def _look(self) -> None:
        if time.monotonic() < self._looked_at + LOOK_S:
            return
        with self._database.read() as session:
            goal = session.get_one(GoalRow, self._goal_id)
            self._stop, self._cancelled = goal.stop_requested, goal.state != self._during
        self._looked_at = time.monotonic()

    def _tell(self) -> None:
        """Record the newest progress; an event only where more than the time has changed."""
        if self._newest is None or time.monotonic() < self._told_at + TELL_S:
            return
        newest, self._newest, self._told_at = self._newest, None, time.monotonic()
        news = {
            "engine": newest.engine,
            "makespan_s": newest.makespan_s,
            "lower_bound_s": newest.lower_bound_s,
        }
        planning = {**news, "elapsed_s": newest.elapsed_s}
        with self._database.write() as session:
            goal = session.get_one(GoalRow, self._goal_id, with_for_update=True)
            if goal.state != self._during:
                return
            goal.planning = planning
            if news != self._told:
                self._events.append(
                    session,
                    GoalProgress(
                        subject=goal.id,
                        state=self._during,
                        engine=newest.engine,
                        elapsed_s=newest.elapsed_s,
                        makespan_s=newest.makespan_s,
                        lower_bound_s=newest.lower_bound_s,
                    ),
                )
        self._told = news
