"""One planning process: a warm engine in a child process that is supervised and can be ended at any time."""

import gc
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, TypeAlias

from app.domain.clock import SYSTEM_CLOCK, WallClock, pause
from app.planning.pool.process_tree import kill, tree_of
from app.planning.pool.work import Answer, Work, WorkResult
from planner import Observer, PlanningEngine, PlanningStatus, Progress
from robots.child_processes import end_with_parent, start_child
from robots.compilation import run_uncompiled

GRACE_S = 10.0
"""An engine keeps its time limit itself; its process is ended when it exceeds the limit by this."""
POLL_S = 0.1
"""Interval of checks of a process at work, and least interval of its progress messages."""
TERMINATE_S = 0.5
"""Time for an engine to end by itself after SIGTERM, with its native engines; then all are killed."""
MEMORY_MB = 2048
NICENESS = 3
"""Added to the niceness of a warm process: on a busy machine requests and robots' reports come before planning."""
EXIT_S = 5.0
"""Time for a process to end after its pipe was closed or its service has ended."""

PROCESS_NAME = "planning"
CANCELLED = "planning was cancelled"

Tell: TypeAlias = Callable[[str], None]
MakeEngine: TypeAlias = Callable[[Tell], PlanningEngine]
"""Builds the engine inside a process; calls its argument with messages about what takes time."""
Pipe: TypeAlias = "Connection[Any, Any]"


class Watch(Observer):
    """An observer of planning that may also cancel it."""

    def is_cancelled(self) -> bool:
        """True: the plan is no longer wanted; the process is ended at once."""
        return False

    def waits_for(self, what: str) -> None:
        """Called now and then while the work waits for a process; `what` says why."""


class Deadline(Watch):
    """Cancels work that has to wait too long for a process; a request waits for it."""

    def __init__(self, clock: WallClock, within_s: float) -> None:
        """:param within_s: wall-clock seconds from now."""
        self._clock = clock
        self._cancel_at_s = clock.monotonic_s() + within_s

    def is_cancelled(self) -> bool:
        return self._clock.monotonic_s() > self._cancel_at_s


class ProcessDied(Exception):
    """Raised when the planning process has ended; the message names its exit code."""


class _GivenUp(Exception):
    """Raised when the service stops waiting for work."""

    def __init__(self, status: PlanningStatus, reason: str) -> None:
        super().__init__(status, reason)
        self.result: WorkResult[Any] = WorkResult(status=status, reason=reason)


@dataclass(frozen=True, slots=True)
class _Order:
    work: Work[Any]


@dataclass(frozen=True, slots=True)
class _Stop:
    """To the process: end the work soon, with the best plan so far."""


@dataclass(frozen=True, slots=True)
class _Begun:
    """From the process: it has begun the work it was given."""


@dataclass(frozen=True, slots=True)
class _Starting:
    """From the process: what it is doing before the engine is warm."""

    doing: str


@dataclass(frozen=True, slots=True)
class _Ready:
    """From the process: the engine is warm."""


class PlanningProcess:
    """The service's side of a planning process. One work at a time; `end` may be called from any thread."""

    def __init__(
        self,
        make_engine: MakeEngine,
        *,
        is_compiled: bool = True,
        memory_mb: float = MEMORY_MB,
        grace_s: float = GRACE_S,
        clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """Start the process.

        :param make_engine: picklable.
        :param is_compiled: run the planner compiled; else as Python.
        :param memory_mb: limit of its memory beyond that after warm-up, native engines included.
        :param grace_s: the process is ended when its work exceeds its time limit by this.
        """
        self._pipe, child_end = multiprocessing.Pipe()
        self._process = start_child(_serve, make_engine, child_end, is_compiled, name=PROCESS_NAME)
        child_end.close()
        self._ending = threading.Lock()
        self._allowed_mb = memory_mb
        self._max_mb = float("inf")
        self._grace_s = grace_s
        self._clock = clock
        self.is_idle = False
        """Warm and without work: if it ends then, the work did not cause it."""

    @property
    def pid(self) -> int | None:
        return self._process.pid

    def wait_until_ready(self, tell: Tell) -> None:
        """Wait until the process is warm, without a limit.

        :param tell: called with messages about what it is doing.
        :raises ProcessDied: if it ends before.
        """
        while isinstance(message := self._receive(), _Starting):
            tell(message.doing)
        self._max_mb = self.memory_mb() + self._allowed_mb
        self.is_idle = True

    def do(self, work: Work[Answer], time_limit_s: float, watch: Watch) -> WorkResult[Answer]:
        """The work's result. If the work hangs, needs too much memory or is cancelled, the process is ended.

        :param time_limit_s: the work keeps it itself; if it exceeds it by `grace_s`, it counts as hanging.
        :raises ProcessDied: if the process ends meanwhile.
        """
        try:
            return self._supervise(work, time_limit_s, watch)
        except _GivenUp as given_up:
            self.end()
            return given_up.result
        except BaseException:
            self.end()  # so that a late result is not taken for that of the next work
            raise

    def _supervise(self, work: Work[Answer], time_limit_s: float, watch: Watch) -> WorkResult[Answer]:
        self._send(_Order(work))
        give_up_at_s = self._clock.monotonic_s() + time_limit_s + self._grace_s
        stopped = False
        while self._clock.monotonic_s() < give_up_at_s:
            if self._poll():
                message = self._receive()
                if isinstance(message, WorkResult):
                    self.is_idle = True
                    return message
                if isinstance(message, _Begun):
                    self.is_idle = False
                else:
                    watch.progress(message)
            if watch.is_cancelled():
                raise _GivenUp(PlanningStatus.NOT_FOUND, CANCELLED)
            if self.memory_mb() > self._max_mb:
                reason = f"planning took more than {self._allowed_mb:.0f} MB (MACTA_PLANNING_MEMORY_MB)"
                raise _GivenUp(PlanningStatus.OUT_OF_MEMORY, reason)
            if not stopped and watch.should_stop():
                self._send(_Stop())
                give_up_at_s = min(give_up_at_s, self._clock.monotonic_s() + self._grace_s)
                stopped = True
        raise _GivenUp(PlanningStatus.TIMED_OUT, f"no answer within {time_limit_s:.0f} s")

    @property
    def is_alive(self) -> bool:
        return self._process.is_alive()

    def memory_mb(self) -> float:
        """Its memory with that of its native engines."""
        return sum(one.memory_mb for one in tree_of(self.pid)) if self.pid is not None else 0.0

    def end(self) -> None:
        """End the process and the native engines it runs."""
        with self._ending:
            running = [] if self.pid is None else tree_of(self.pid)
            self._process.terminate()
            self._process.join(TERMINATE_S)
            if self._process.is_alive():
                self._process.kill()
                self._process.join()
            kill(running)

    def _poll(self) -> bool:
        try:
            return self._pipe.poll(POLL_S)
        except OSError as error:
            raise ProcessDied(str(error)) from error

    def _send(self, message: object) -> None:
        try:
            self._pipe.send(message)
        except OSError as error:
            raise ProcessDied(str(error)) from error

    def _receive(self) -> Any:
        try:
            return self._pipe.recv()
        except (EOFError, OSError) as error:
            self._process.join(EXIT_S)
            raise ProcessDied(f"exit code {self._process.exitcode}") from error


class _ProgressSender(Observer):
    """Inside the process: sends the newest progress at most every `POLL_S`, and receives the order to stop."""

    def __init__(self, pipe: Pipe, clock: WallClock) -> None:
        self._pipe = pipe
        self._clock = clock
        self._lock = threading.Lock()
        self._newest: Progress | None = None
        self._sent_at_s = 0.0
        self._stopped = False

    def progress(self, progress: Progress) -> None:
        with self._lock:
            self._newest = progress
            self._send()

    def should_stop(self) -> bool:
        with self._lock:
            self._send()
            while not self._stopped and self._pipe.poll():
                self._stopped = isinstance(self._pipe.recv(), _Stop)
            return self._stopped

    def _send(self) -> None:
        now_s = self._clock.monotonic_s()
        if self._newest is not None and now_s >= self._sent_at_s + POLL_S:
            self._pipe.send(self._newest)
            self._newest = None
            self._sent_at_s = now_s


def _serve(make_engine: MakeEngine, pipe: Pipe, is_compiled: bool) -> None:
    """The process's main function: do the work received, until the service ends it or has ended itself."""
    if not is_compiled:
        run_uncompiled()
    # NOTE: while functions are compiled, an exception cannot unwind the stack: the compiler's callbacks drop it.
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    end_with_parent(_end)
    gc.disable()  # it would scan what is being imported
    try:
        engine = make_engine(lambda doing: pipe.send(_Starting(doing)))
        signal.signal(signal.SIGTERM, _exit)
        os.nice(NICENESS)
        gc.freeze()  # keeps the collector from scanning the libraries' objects, 0.2 s each time
        gc.enable()
        pipe.send(_Ready())
        while True:
            # NOTE: a stop order that arrives after its work has ended does not apply to the next work.
            if isinstance(order := pipe.recv(), _Order):
                pipe.send(_Begun())
                pipe.send(_result(engine, order, _ProgressSender(pipe, SYSTEM_CLOCK)))
    except (EOFError, OSError):
        return


def _result(engine: PlanningEngine, order: _Order, observer: Observer) -> WorkResult[Any]:
    try:
        return order.work(engine, observer)
    except Exception as error:
        return WorkResult(status=PlanningStatus.FAILED, reason=f"{engine.name} raised {error!r}")


def _exit(*_: object) -> None:
    """Unwind the stack, so that native engines are ended, too."""
    raise SystemExit(1)


def _end() -> None:
    """End this process with its native engines, those that do not end by themselves soon, too."""
    os.kill(os.getpid(), signal.SIGTERM)
    pause(SYSTEM_CLOCK, EXIT_S)
    kill(tree_of(os.getpid())[1:])
    os._exit(1)
