"""Independent runs side by side, each in a process of its own; what they give does not depend on how many there are."""

import signal
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import active_children, get_context
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
        initializer=_end_silently_when_interrupted,
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


def _end_silently_when_interrupted() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)
