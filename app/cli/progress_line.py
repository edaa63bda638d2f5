"""A progress line for planning in a terminal; Ctrl-C takes the best plan so far."""

import signal
from types import FrameType
from typing import Self

from rich.console import Console
from rich.markup import escape
from rich.status import Status

from app.domain.clock import SYSTEM_CLOCK, WallClock
from planner import Observer, Progress

REFRESH_S = 0.1
STOPPING = "stopping with the best plan so far; Ctrl-C again aborts"


class ProgressLine(Observer):
    """Within a `with` block, the first Ctrl-C asks the engine to stop; the second one interrupts."""

    def __init__(self, console: Console, *, is_shown: bool, wall: WallClock = SYSTEM_CLOCK) -> None:
        """:param is_shown: draw the line; for terminals only."""
        self._wall = wall
        self._status: Status | None = Status("planning …", console=console) if is_shown else None
        self._stopping = False
        self._shown_at_s = 0.0

    def __enter__(self) -> Self:
        self._before = signal.signal(signal.SIGINT, self._interrupted)
        if self._status is not None:
            self._status.start()
        return self

    def __exit__(self, *_: object) -> None:
        signal.signal(signal.SIGINT, self._before)
        if self._status is not None:
            self._status.stop()

    def progress(self, progress: Progress) -> None:
        now_s = self._wall.monotonic_s()
        if self._status is not None and now_s >= self._shown_at_s + REFRESH_S:
            self._status.update(escape(self.line(progress)))
            self._shown_at_s = now_s

    def should_stop(self) -> bool:
        return self._stopping

    def line(self, progress: Progress) -> str:
        """The line, such as `macta, 3.2 s: plan of 104 s, none is shorter than 98 s`."""
        found = "no plan yet" if progress.makespan_s is None else f"plan of {progress.makespan_s:.0f} s"
        bound = progress.lower_bound_s
        known = f", none is shorter than {bound:.0f} s" if bound is not None else ""
        words = f"{progress.engine}, {progress.elapsed_s:.1f} s: {found}{known}"
        return f"{words}; {STOPPING}" if self._stopping else words

    def _interrupted(self, number: int, frame: FrameType | None) -> None:
        if self._stopping:
            signal.default_int_handler(number, frame)
        self._stopping = True
        if self._status is not None:
            self._status.update(STOPPING)
