"""The planning process: engines run beside the service, warm, so that no request pays their import."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

from planner import PlanningEngine, PlanningProblem, PlanningResult, PlanningStatus

GRACE_S = 10.0
"""An engine keeps its own time limit; past this much more the process is given up."""
ATTEMPTS = 2
"""How often a problem is tried when the process dies under it."""

_engine: list[PlanningEngine] = []


def _warm_up(make_engine: Callable[[], PlanningEngine]) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to handle
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _engine.append(make_engine())


def _end_with_parent() -> None:
    """A pool's process would wait for work for ever if the service were killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _plan(problem: PlanningProblem, time_limit_s: float) -> PlanningResult:
    return _engine[0].plan(problem, time_limit_s=time_limit_s)


def _ready() -> bool:
    return bool(_engine)


class PlanningWorker:
    """One warm planning process, replaced when it dies or overruns. Problems take turns, in any thread."""

    def __init__(self, make_engine: Callable[[], PlanningEngine]) -> None:
        """:param make_engine: picklable; builds the warm engine inside the process."""
        self._make_engine = make_engine
        self._turn = threading.Lock()
        self._closed = False
        self._pool = self._new_pool()

    def warm_up(self) -> "Future[bool]":
        """Start the process; the future is done once the engine is ready."""
        return self._pool.submit(_ready)

    def plan(self, problem: PlanningProblem, *, time_limit_s: float) -> PlanningResult:
        """Plan in the process; that it died or hung is a result with a reason, not an exception.

        The time limit begins when it is the problem's turn.
        """
        with self._turn:
            for _ in range(ATTEMPTS):
                try:
                    return self._pool.submit(_plan, problem, time_limit_s).result(time_limit_s + GRACE_S)
                except TimeoutError:
                    self._replace()
                    return _failed(PlanningStatus.TIMED_OUT, f"no answer within {time_limit_s:.0f} s")
                except (BrokenProcessPool, CancelledError, OSError, RuntimeError):
                    if self._closed:
                        break
                    self._replace()
        return _failed(PlanningStatus.FAILED, "the planning process died")

    def close(self) -> None:
        self._closed = True
        self._end()

    def _replace(self) -> None:
        self._end()
        self._pool = self._new_pool()

    def _end(self) -> None:
        for process in list((self._pool._processes or {}).values()):
            process.terminate()
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _new_pool(self) -> ProcessPoolExecutor:
        context = multiprocessing.get_context("spawn")
        return ProcessPoolExecutor(1, context, initializer=_warm_up, initargs=(self._make_engine,))


def _failed(status: PlanningStatus, reason: str) -> PlanningResult:
    return PlanningResult(status=status, engine="planning process", planning_s=0.0, reason=reason)
