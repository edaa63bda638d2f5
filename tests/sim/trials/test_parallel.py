"""Runs side by side come in order, and whoever breaks off does not wait for those under way."""

import os
import select
from multiprocessing import active_children, get_context
from multiprocessing.connection import Connection
from threading import Event
from typing import Any

from sim.trials.parallel import run_parallel


def doubled(number: int) -> int:
    return 2 * number


def ends_if_even(number: int) -> int:
    """An odd number's run never ends."""
    return number if number % 2 == 0 else int(Event().wait())


def test_results_come_in_the_jobs_order_however_many_processes() -> None:
    assert list(run_parallel(doubled, range(5), workers=2)) == [0, 2, 4, 6, 8]


def test_without_jobs_there_are_no_results() -> None:
    assert list(run_parallel(doubled, [], workers=2)) == []


def test_breaking_off_ends_the_runs_under_way() -> None:
    before = set(active_children())
    runs = run_parallel(ends_if_even, [0, 1, 3, 5], workers=2)
    assert next(runs) == 0
    runs.close()
    assert set(active_children()) <= before


def own_pid(_: int) -> int:
    return os.getpid()


def tell_and_stay(pipe: "Connection[Any, Any]") -> None:
    """Owns a process that has done its work, tells its number, and goes on for ever."""
    runs = run_parallel(own_pid, [0], workers=1)
    pipe.send(next(runs))
    Event().wait()


def test_the_processes_do_not_outlive_an_owner_that_is_killed() -> None:
    near, far = get_context("spawn").Pipe()
    owner = get_context("spawn").Process(target=tell_and_stay, args=(far,))
    owner.start()
    worker = os.pidfd_open(near.recv())
    owner.kill()
    owner.join()
    assert select.select([worker], [], [], 60.0)[0], "it still runs"
    os.close(worker)
