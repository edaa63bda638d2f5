"""Time measured by a clock that the test steps."""

from math import inf

from planner.problem.timer import Timer
from tests.planner.stepped_clock import SteppedClock


def test_a_timer_is_over_when_its_limit_is_reached() -> None:
    clock = SteppedClock()
    timer = Timer(2.0, clock)
    clock.now_s += 1.5
    assert (timer.elapsed_s, timer.left_s, timer.is_over) == (1.5, 0.5, False)
    clock.now_s += 0.5
    assert timer.is_over


def test_without_a_limit_a_timer_is_never_over() -> None:
    clock = SteppedClock()
    timer = Timer(clock=clock)
    clock.now_s += 1e9
    assert timer.left_s == inf
    assert not timer.is_over
