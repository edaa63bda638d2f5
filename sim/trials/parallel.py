"""Independent runs in parallel processes; the results do not depend on the number of processes."""

import signal
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import active_children, get_context
from typing import TypeVar

from robots.child_processes import end_with_parent

Job = TypeVar("Job")
Result = TypeVar("Result")


def run_parallel(work: Callable[[Job], Result], jobs: Sequence[Job], *, workers: int) -> Generator[Result]:
    """The results in the order of the jobs, each as soon as it and those before it are complete.

    :param work: picklable, as are jobs and results.
    """
    unrelated = set(active_children())
    pool = ProcessPoolExecutor(
        min(workers, len(jobs)) or 1,
        mp_context=get_context("spawn"),
        initializer=_start_worker,
    )
    try:
        yield from pool.map(work, jobs)
    except BaseException:
        # NOTE: without this, an interruption waits for the runs under way and the prefetched ones.
        for process in set(active_children()) - unrelated:
            process.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _start_worker() -> None:
    """In a new process: an interruption ends it silently, and it ends with its parent."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    end_with_parent()
