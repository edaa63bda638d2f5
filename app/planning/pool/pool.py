"""The pool of planning processes: kept warm to avoid imports, several so that a long problem does not block short ones.

One is started with the service, the others when work finds none free.
"""

import logging
import threading
from concurrent.futures import Future
from functools import partial
from queue import Empty, Queue

from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.errors import Unavailable
from app.planning.pool.process import (
    CANCELLED,
    GRACE_S,
    MEMORY_MB,
    POLL_S,
    MakeEngine,
    PlanningProcess,
    ProcessDied,
    Tell,
    Watch,
)
from app.planning.pool.work import Answer, Work, WorkResult
from planner import PlanningStatus

logger = logging.getLogger(__name__)

ATTEMPTS = 2
"""Attempts at work whose process ends unexpectedly, and at starting a process that ends at its start."""


class WorkerClosed(Exception):
    """Raised when the worker is closed before work has a result."""


class PlanningWorker:
    """Does work in warm processes, each replaced when it ends or hangs. Thread-safe; work waits for a free process."""

    def __init__(
        self,
        make_engine: MakeEngine,
        *,
        processes: int = 1,
        memory_mb: float = MEMORY_MB,
        grace_s: float = GRACE_S,
        tell: Tell = logger.info,
        clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """
        :param make_engine: picklable; builds the warm engine inside a process.
        :param processes: the maximum; if 0, one is started with the first work, such as a plan to explain.
        :param memory_mb: limit of a process's memory beyond that after warm-up, native engines included.
        :param grace_s: a process is ended when its work exceeds its time limit by this.
        :param tell: called with messages about the start of processes, where it takes time.
        """
        self.doing = "loading"
        """The newest message about the start of a process."""
        self._tell = tell
        self._start_process = partial(
            PlanningProcess, make_engine, memory_mb=memory_mb, grace_s=grace_s, clock=clock
        )
        self._count = processes
        self._lock = threading.Lock()
        self._all: list[PlanningProcess] = []
        self._free: Queue[PlanningProcess] = Queue()
        self._ready: Future[bool] = Future()
        self._started = False
        self._closed = False
        self._failed_starts = 0
        self._starting = 0

    @property
    def pids(self) -> list[int]:
        """The processes' ids."""
        with self._lock:
            return [process.pid for process in self._all if process.pid is not None]

    @property
    def free_count(self) -> int:
        """The number of processes that are warm and without work."""
        return self._free.qsize()

    def warm_up(self) -> "Future[bool]":
        """Start the first process; the future is done once it can plan, and raises Unavailable if it does not start."""
        with self._lock:
            was_started = self._started
            self._started = True
        if not was_started:
            if self._count:
                self._add()
            else:
                self._report(None)
        return self._ready

    def do(self, work: Work[Answer], time_limit_s: float, watch: Watch | None = None) -> WorkResult[Answer]:
        """Do the work in a process; if the process ends unexpectedly or hangs, that is a result, too.

        The time limit begins when a process begins the work.

        :raises WorkerClosed: if the worker is closed before there is a result.
        """
        self.warm_up()
        with self._lock:
            needs_first = self._count == 0
            self._count = max(self._count, 1)
        if needs_first:
            self._add()
        watch = watch or Watch()
        cause = ""
        attempts = ATTEMPTS
        spare = self._count
        while attempts:
            process = self._next(watch)
            if process is None:
                return WorkResult(status=PlanningStatus.NOT_FOUND, reason=CANCELLED)
            try:
                return process.do(work, time_limit_s, watch)
            except ProcessDied as death:
                if self._closed:
                    raise WorkerClosed from death
                cause = str(death)
                if process.is_idle and spare:
                    spare -= 1
                else:
                    attempts -= 1
            finally:
                self._give_back(process)
        return WorkResult(
            status=PlanningStatus.FAILED, reason=f"the planning process ended unexpectedly ({cause})"
        )

    def close(self) -> None:
        """End the processes; callers of `do` that wait for a result get WorkerClosed."""
        with self._lock:
            self._closed = True
            processes = list(self._all)
            self._all.clear()
        for process in processes:
            process.end()

    def _next(self, watch: Watch) -> PlanningProcess | None:
        """The next free process; None if the work is cancelled first."""
        while not watch.is_cancelled():
            if self._closed:
                raise WorkerClosed
            try:
                return self._free.get(timeout=POLL_S)
            except Empty:
                self._add_if_all_are_busy()
        return None

    def _add_if_all_are_busy(self) -> None:
        with self._lock:
            may_add = not self._starting and len(self._all) < self._count
        if may_add:
            self._add()

    def _give_back(self, process: PlanningProcess) -> None:
        if process.is_alive:
            self._free.put(process)
            return
        with self._lock:
            if process in self._all:
                self._all.remove(process)
        self._add()

    def _add(self) -> None:
        """Start one more process, free once it is warm."""
        with self._lock:
            if self._closed:
                return
            process = self._start_process()
            self._all.append(process)
            self._starting += 1
        threading.Thread(target=self._await_ready, args=(process,), daemon=True).start()

    def _await_ready(self, process: PlanningProcess) -> None:
        try:
            self._take_in(process)
        finally:
            with self._lock:
                self._starting -= 1

    def _take_in(self, process: PlanningProcess) -> None:
        """Make the process available once it is warm."""
        try:
            process.wait_until_ready(self._is_told)
        except ProcessDied as death:
            if self._may_try_another():
                self._give_back(process)
                return
            # NOTE: made available nevertheless, so that a waiting caller gets the error and does not wait for ever.
            self._report(Unavailable(f"the planning process does not start ({death}); the log says why"))
        else:
            self._failed_starts = 0
            self._report(None)
        self._free.put(process)

    def _is_told(self, doing: str) -> None:
        self.doing = doing
        self._tell(doing)

    def _may_try_another(self) -> bool:
        """Count a failed start; True if another is to be tried: the cause may be temporary, e.g. a lack of memory."""
        with self._lock:
            self._failed_starts += 1
            return self._failed_starts < ATTEMPTS

    def _report(self, failure: Exception | None) -> None:
        with self._lock:
            if self._ready.done():
                return
            if failure is None:
                self._ready.set_result(True)
            else:
                self._ready.set_exception(failure)
