"""The planning processes: a few, warm, so that no request pays an import and a long problem blocks no short one."""

import threading
from concurrent.futures import Future
from queue import Empty, Queue
from typing import Any

from app.domain.errors import Unavailable
from app.planning.pool.process import (
    MEMORY_MB,
    POLL_S,
    MakeEngine,
    Planned,
    PlanningProcess,
    ProcessDied,
    Watch,
    Work,
    WorkFailed,
    cancelled,
)
from planner import PlanningProblem, PlanningRequest, PlanningResult, PlanningStatus

ATTEMPTS = 2
"""How often a problem is tried when the process dies under it, and a process begun when it dies as it begins."""


class WorkerClosed(Exception):
    """Raised when the worker is closed while a problem waits for its plan: nothing is known of the problem."""


class PlanningWorker:
    """Plans in warm processes, each replaced when it dies or hangs. Thread-safe; problems wait their turn."""

    def __init__(self, make_engine: MakeEngine, *, processes: int = 1, memory_mb: float = MEMORY_MB) -> None:
        """
        :param make_engine: picklable; builds the warm engine inside a process.
        :param processes: with none, one is started once there is work after all: a plan to explain, say.
        :param memory_mb: what a process may hold beyond what it holds when warm, native engines included.
        """
        self._make_engine, self._count, self._memory_mb = make_engine, processes, memory_mb
        self._lock = threading.Lock()
        self._all: list[PlanningProcess] = []
        self._free: Queue[PlanningProcess] = Queue()
        self._first: Future[bool] = Future()
        self._started = self._closed = False
        self._stillborn = 0

    @property
    def pids(self) -> list[int]:
        """The processes' ids."""
        with self._lock:
            return [process.pid for process in self._all if process.pid is not None]

    def warm_up(self) -> "Future[bool]":
        """Start the processes; the future is done once the first of them can plan.

        It raises Unavailable if that does not come up.
        """
        with self._lock:
            begun, self._started = self._started, True
        if not begun:
            for _ in range(self._count):
                self._add()
            if not self._count:
                self._report(None)
        return self._first

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, watch: Watch | None = None
    ) -> PlanningResult:
        """Plan in a process; that it died or hung is a result with a reason, not an exception.

        The time limit begins when it is the problem's turn.

        :raises WorkerClosed: if it is closed before there is a result.
        """
        work = Planned(problem=problem, request=request)
        try:
            result: PlanningResult = self.do(work, request.time_limit_s, watch)
        except WorkFailed as failure:
            return failure.result
        return result

    def do(self, work: Work, time_limit_s: float, watch: Watch | None = None) -> Any:
        """Have the work done in a process, and answer what it answers.

        The time limit begins when it is its turn.

        :raises WorkFailed: if it has no answer, with the reason.
        :raises WorkerClosed: if the worker is closed before there is one.
        """
        self.warm_up()
        with self._lock:
            none, self._count = self._count == 0, max(self._count, 1)
        if none:
            self._add()
        watch = watch or Watch()
        how, attempts, spare = "", ATTEMPTS, self._count
        while attempts:
            process = self._next(watch)
            try:
                return process.do(work, time_limit_s, watch)
            except ProcessDied as death:
                if self._closed:
                    raise WorkerClosed from death
                how = str(death)
                if process.is_idle and spare:
                    spare -= 1
                else:
                    attempts -= 1
            finally:
                self._give_back(process)
        raise WorkFailed(PlanningStatus.FAILED, f"the planning process died ({how})")

    def close(self) -> None:
        """End the processes; whoever waits for a result is told by WorkerClosed."""
        with self._lock:
            self._closed = True
            processes, self._all = self._all, []
        for process in processes:
            process.end()

    def _next(self, watch: Watch) -> PlanningProcess:
        """The next free process.

        :raises WorkFailed: if nobody wants it any more.
        """
        while not watch.is_cancelled():
            if self._closed:
                raise WorkerClosed
            try:
                return self._free.get(timeout=POLL_S)
            except Empty:
                continue
        raise cancelled()

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
            process = PlanningProcess(self._make_engine, memory_mb=self._memory_mb)
            self._all.append(process)
        threading.Thread(target=self._welcome, args=(process,), daemon=True).start()

    def _welcome(self, process: PlanningProcess) -> None:
        try:
            process.wait_until_ready()
        except ProcessDied as death:
            if self._may_try_another():
                self._give_back(process)
                return
            # NOTE: it is given out all the same, so that who waits learns of its death instead of waiting for ever.
            self._report(Unavailable(f"the planning process does not start ({death}); the log says why"))
        else:
            self._stillborn = 0
            self._report(None)
        self._free.put(process)

    def _may_try_another(self) -> bool:
        """True if a process that died as it began may have had bad luck, such as a machine short of memory."""
        with self._lock:
            self._stillborn += 1
            return self._stillborn < ATTEMPTS

    def _report(self, failure: Exception | None) -> None:
        with self._lock:
            if self._first.done():
                return
            if failure is None:
                self._first.set_result(True)
            else:
                self._first.set_exception(failure)
