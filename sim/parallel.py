"""Independent runs side by side, each in a process of its own; what they give does not depend on how many there are."""

import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")


def side_by_side(work: Callable[[Job], Result], jobs: Sequence[Job], *, workers: int) -> Iterator[Result]:
    """The results in the jobs' order, each as soon as it and those before it are there.

    :param work: picklable, as are jobs and results.
    """
    pool = ProcessPoolExecutor(
        min(workers, len(jobs)) or 1,
        mp_context=get_context("spawn"),
        initializer=_end_silently_when_interrupted,
    )
    try:
        yield from pool.map(work, jobs)
    finally:
        pool.shutdown(cancel_futures=True)


def _end_silently_when_interrupted() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)
