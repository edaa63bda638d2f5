"""One planning process: an engine that runs beside the service, warm, watched, and ended at any time.

What it is asked for is work: to plan, or anything else that takes an engine.
"""

import gc
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, TypeAlias

from app.planning.pool.process_tree import kill, tree_of
from planner import (
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    Progress,
)

GRACE_S = 10.0
"""An engine keeps its own time limit; past this much more its process is given up."""
POLL_S = 0.1
END_S = 0.5
"""An engine is given so long to end by itself, with its native engines; then all of it is killed."""
MEMORY_MB = 2048

GONE_S = 5.0
"""So long after its pipe a process that ends is waited for, and one whose service is gone may take to end."""

MakeEngine = Callable[[], PlanningEngine]
Work = Callable[[PlanningEngine, Observer], Any]
"""Done with the warm engine; picklable, as is what it answers."""
Pipe: TypeAlias = "Connection[Any, Any]"


class Watch(Observer):
    """Whoever watches a problem being planned may also want it no more."""

    def is_cancelled(self) -> bool:
        """True: nobody wants a plan any more; the process is ended at once."""
        return False


class ProcessDied(Exception):
    """Raised when the planning process is gone; the message says how it went."""


class WorkFailed(Exception):
    """Raised when there is no answer: it took too long, the engine has a defect, or nobody wants it any more."""

    def __init__(self, status: PlanningStatus, reason: str) -> None:
        super().__init__(status, reason)
        self.status, self.reason = status, reason

    @property
    def result(self) -> PlanningResult:
        """The same as the result of planning."""
        return PlanningResult(
            status=self.status, engine="planning process", planning_s=0.0, reason=self.reason
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Planned:
    """The work of planning."""

    problem: PlanningProblem
    request: PlanningRequest

    def __call__(self, engine: PlanningEngine, observer: Observer) -> PlanningResult:
        return engine.plan(self.problem, self.request, observer)


@dataclass(frozen=True, slots=True)
class _Order:
    work: Work


@dataclass(frozen=True, slots=True)
class _Stop:
    """To the process: end soon, with the best plan so far."""


@dataclass(frozen=True, slots=True)
class _Begun:
    """From the process: it has taken up the work it was given."""


@dataclass(frozen=True, slots=True)
class _Answer:
    """From the process: the work is done."""

    value: Any


@dataclass(frozen=True, slots=True)
class _Ready:
    """From the process: the engine is warm."""


class PlanningProcess:
    """The service's side. One problem at a time; `end` may come from any thread."""

    def __init__(self, make_engine: MakeEngine, *, memory_mb: float = MEMORY_MB) -> None:
        """Start the process.

        :param make_engine: picklable; builds the warm engine inside it.
        :param memory_mb: what it may hold beyond what it holds when warm, native engines included.
        """
        context = multiprocessing.get_context("spawn")
        self._pipe, far = context.Pipe()
        self._process = context.Process(target=_serve, args=(make_engine, far), name="planning", daemon=True)
        _start_deaf_to_interrupts(self._process.start)
        far.close()
        self._ending = threading.Lock()
        self._allowed_mb, self._most_mb = memory_mb, float("inf")
        self.is_idle = False
        """Warm, and at no work: if it dies so, that is no work's fault."""

    @property
    def pid(self) -> int | None:
        return self._process.pid

    def wait_until_ready(self) -> None:
        """:raises ProcessDied: if it does not come up."""
        self._receive()
        self._most_mb = self._memory_mb() + self._allowed_mb
        self.is_idle = True

    def do(self, work: Work, time_limit_s: float, watch: Watch) -> Any:
        """What the work answers. One that hangs, or is wanted no more, is ended with its process.

        :param time_limit_s: the work keeps it by itself; much past it, it is taken to hang.
        :raises WorkFailed: if it has no answer.
        :raises ProcessDied: if the process went meanwhile.
        """
        try:
            answer = self._do(work, time_limit_s, watch)
        except BaseException:
            self.end()  # whatever went wrong, its answer must not be taken for the next work's
            raise
        if isinstance(answer, WorkFailed):
            raise answer
        return answer

    def _do(self, work: Work, time_limit_s: float, watch: Watch) -> Any:
        self._send(_Order(work))
        give_up, stopped = time.monotonic() + time_limit_s + GRACE_S, False
        while time.monotonic() < give_up:
            if self._poll():
                message = self._receive()
                if isinstance(message, _Answer):
                    self.is_idle = True
                    return message.value
                if isinstance(message, _Begun):
                    self.is_idle = False
                else:
                    watch.progress(message)
            if watch.is_cancelled():
                raise cancelled()
            if self._memory_mb() > self._most_mb:
                reason = f"planning took more than {self._allowed_mb:.0f} MB (MACTA_PLANNING_MEMORY_MB)"
                raise WorkFailed(PlanningStatus.OUT_OF_MEMORY, reason)
            if not stopped and watch.should_stop():
                self._send(_Stop())
                give_up, stopped = min(give_up, time.monotonic() + GRACE_S), True
        raise WorkFailed(PlanningStatus.TIMED_OUT, f"no answer within {time_limit_s:.0f} s")

    @property
    def is_alive(self) -> bool:
        return self._process.is_alive()

    def end(self) -> None:
        """End the process, with the native engines it runs, whatever they are at."""
        with self._ending:
            running = [] if self.pid is None else tree_of(self.pid)
            self._process.terminate()
            self._process.join(END_S)
            if self._process.is_alive():
                self._process.kill()
                self._process.join()
            kill(running)

    def _memory_mb(self) -> float:
        return sum(one.memory_mb for one in tree_of(self.pid)) if self.pid is not None else 0.0

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
            self._process.join(GONE_S)
            raise ProcessDied(f"exit code {self._process.exitcode}") from error


def cancelled() -> WorkFailed:
    return WorkFailed(PlanningStatus.NOT_FOUND, "planning was cancelled")


class _Teller(Observer):
    """Inside the process: hands progress on, the newest at most every `POLL_S`, and hears of a stop."""

    def __init__(self, pipe: Pipe) -> None:
        self._pipe, self._lock = pipe, threading.Lock()
        self._newest: Progress | None = None
        self._told_at, self._stopped = 0.0, False

    def progress(self, progress: Progress) -> None:
        with self._lock:
            self._newest = progress
            self._tell()

    def should_stop(self) -> bool:
        with self._lock:
            self._tell()
            while not self._stopped and self._pipe.poll():
                self._stopped = isinstance(self._pipe.recv(), _Stop)
            return self._stopped

    def _tell(self) -> None:
        if self._newest is not None and time.monotonic() >= self._told_at + POLL_S:
            self._pipe.send(self._newest)
            self._newest, self._told_at = None, time.monotonic()


def _serve(make_engine: MakeEngine, pipe: Pipe) -> None:
    """The process: plan what comes, until the service ends it or is itself gone."""
    signal.signal(signal.SIGTERM, _leave)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        engine = make_engine()
        gc.freeze()  # the collector would look through the libraries again and again, a fifth of a second each time
        pipe.send(_Ready())
        while True:
            # NOTE: a stop may come after its problem was answered; it is not meant for the next one.
            if isinstance(order := pipe.recv(), _Order):
                pipe.send(_Begun())
                pipe.send(_answer(engine, order, _Teller(pipe)))
    except (EOFError, OSError):
        return


def _answer(engine: PlanningEngine, order: _Order, teller: _Teller) -> _Answer:
    try:
        return _Answer(order.work(engine, teller))
    except Exception as error:
        return _Answer(WorkFailed(PlanningStatus.FAILED, f"{engine.name} has a defect: {error!r}"))


def _leave(*_: object) -> None:
    """Unwinds what is under way, so that native engines are ended, too."""
    raise SystemExit(1)


def _end_with_parent() -> None:
    """The process would wait for work for ever if the service were killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(GONE_S)
        kill(tree_of(os.getpid())[1:])
        os._exit(1)


def _start_deaf_to_interrupts(start: Callable[[], None]) -> None:
    """A child inherits the signal mask: Ctrl-C is the parent's to handle, also while the child starts."""
    kept = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, kept)
