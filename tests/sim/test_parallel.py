"""Runs side by side come in order, and whoever breaks off does not wait for those under way."""

from multiprocessing import active_children
from threading import Event

from sim.parallel import side_by_side


def doubled(number: int) -> int:
    return 2 * number


def ends_if_even(number: int) -> int:
    """An odd number's run never ends."""
    return number if number % 2 == 0 else int(Event().wait())


def test_results_come_in_the_jobs_order_however_many_processes() -> None:
    assert list(side_by_side(doubled, range(5), workers=2)) == [0, 2, 4, 6, 8]


def test_without_jobs_there_are_no_results() -> None:
    assert list(side_by_side(doubled, [], workers=2)) == []


def test_breaking_off_ends_the_runs_under_way() -> None:
    before = set(active_children())
    runs = side_by_side(ends_if_even, [0, 1, 3, 5], workers=2)
    assert next(runs) == 0
    runs.close()
    assert set(active_children()) <= before
