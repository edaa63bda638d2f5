"""Records the progress of planning for a goal, and reads whether an operator has stopped or cancelled it."""

from collections.abc import Callable
from typing import Any

from sqlalchemy.orm import Session

from app.domain.clock import WallClock
from app.domain.events import GoalProgress
from app.domain.lifecycles.goal import GoalState
from app.planning.pool.process import Watch
from app.store import Database, GoalRow
from app.store.event_log import EventLog
from planner import Progress

RECORD_S = 0.5
"""Progress is recorded at most this often."""
READ_S = 0.25
"""Operators' orders are read at most this often."""


class ProgressWatch(Watch):
    """The watch of one planning attempt, for the goal itself or for its mission's repair. Not thread-safe."""

    def __init__(
        self,
        database: Database,
        events: EventLog,
        goal_id: str,
        *,
        is_wanted: Callable[[Session], bool],
        clock: WallClock,
    ) -> None:
        """:param is_wanted: True if the attempt's result is still wanted according to the database."""
        self._database = database
        self._events = events
        self._goal_id = goal_id
        self._is_wanted = is_wanted
        self._clock = clock
        self._newest: Progress | None = None
        self._recorded: dict[str, Any] = {}
        self._recorded_at_s = clock.monotonic_s()  # so a plan that is found at once has no recorded progress
        self._read_at_s = clock.monotonic_s()  # the attempt's transaction has just read what is wanted
        self._stop = False
        self._cancelled = False

    def progress(self, progress: Progress) -> None:
        self._newest = progress
        self._record()

    def waits_for(self, what: str) -> None:
        now_s = self._clock.monotonic_s()
        if self._recorded.get("waits_for") == what or now_s < self._recorded_at_s + RECORD_S:
            return
        self._recorded_at_s = now_s
        self._write(Progress(engine="", elapsed_s=0.0), waits_for=what)

    def should_stop(self) -> bool:
        self._record()
        self._read()
        return self._stop

    def is_cancelled(self) -> bool:
        self._read()
        return self._cancelled

    def _read(self) -> None:
        if self._clock.monotonic_s() < self._read_at_s + READ_S:
            return
        with self._database.read() as session:
            goal = session.get_one(GoalRow, self._goal_id)  # kept, so that the session does not read it again
            self._stop = goal.stop_requested
            self._cancelled = not self._is_wanted(session)
        self._read_at_s = self._clock.monotonic_s()

    def _record(self) -> None:
        """Record the newest progress; append an event only if more than the elapsed time has changed."""
        newest = self._newest
        if newest is None or self._clock.monotonic_s() < self._recorded_at_s + RECORD_S:
            return
        self._newest = None
        self._recorded_at_s = self._clock.monotonic_s()
        self._write(newest)

    def _write(self, newest: Progress, waits_for: str = "") -> None:
        reported = {
            "engine": newest.engine,
            "makespan_s": newest.makespan_s,
            "lower_bound_s": newest.lower_bound_s,
            "waits_for": waits_for,
        }
        with self._database.write() as session:
            goal = session.get_one(GoalRow, self._goal_id, with_for_update=True)
            if not self._is_wanted(session):
                return
            goal.planning = {**reported, "elapsed_s": newest.elapsed_s}
            if reported != self._recorded:
                self._events.append(
                    session,
                    GoalProgress(
                        subject=goal.id,
                        state=GoalState(goal.state),
                        engine=newest.engine,
                        elapsed_s=newest.elapsed_s,
                        makespan_s=newest.makespan_s,
                        lower_bound_s=newest.lower_bound_s,
                        waits_for=waits_for,
                    ),
                )
        self._recorded = reported
