"""Independent runs side by side, each in a process of its own; what they give does not depend on how many there are."""

import os
import signal
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import active_children, get_context, parent_process
from threading import Thread
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")


def side_by_side(work: Callable[[Job], Result], jobs: Sequence[Job], *, workers: int) -> Generator[Result]:
    """The results in the jobs' order, each as soon as it and those before it are there.

    :param work: picklable, as are jobs and results.
    """
    others = set(active_children())
    pool = ProcessPoolExecutor(
        min(workers, len(jobs)) or 1,
        mp_context=get_context("spawn"),
        initializer=_begin,
    )
    try:
        yield from pool.map(work, jobs)
    except BaseException:
        # NOTE: an interruption would wait for the runs under way, and for those that are queued to be next.
        for process in set(active_children()) - others:
            process.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _begin() -> None:
    """In a new process: an interruption ends it without words, and it does not outlive who asked for its work."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    # NOTE: a pool's process waits for its next job for ever when the pool's owner was killed.
    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
