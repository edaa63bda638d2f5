"""How often a queue is polled for workflows that were not announced."""

import pytest

from app.workflows.queue_listener import BUSY_POLLING_S, IDLE_POLLING_S, LOOK_S, PollPause
from tests.app.stepped_clock import SteppedClock


def test_a_queue_is_polled_less_often_once_nothing_has_happened_for_a_while() -> None:
    clock = SteppedClock()
    busy = False
    pause = PollPause(lambda: True, is_busy=lambda: busy, clock=clock)

    def pause_s() -> float:
        began_s = clock.monotonic_s()
        assert not pause.wait(0.1)
        return clock.monotonic_s() - began_s

    pauses_s = [pause_s() for _ in range(8)]
    assert pauses_s == pytest.approx([0.1, 0.2, 0.4, 0.8, 1.6, 3.2, IDLE_POLLING_S, IDLE_POLLING_S])
    busy = True
    assert pause_s() == pytest.approx(BUSY_POLLING_S)
    pause.cut_short()
    assert pause_s() == 0.0
    assert pause_s() == pytest.approx(0.1)


def test_a_pause_lasts_until_something_may_be_dequeued() -> None:
    clock = SteppedClock()
    allowed_s = clock.monotonic_s() + 3.0
    pause = PollPause(lambda: clock.monotonic_s() >= allowed_s, clock=clock)
    pause.cut_short()
    assert not pause.wait(0.5)
    assert allowed_s <= clock.monotonic_s() <= allowed_s + IDLE_POLLING_S


def test_a_pause_lasts_until_the_end_of_a_workflow_is_recorded() -> None:
    clock = SteppedClock()
    recorded_s = {"first": clock.monotonic_s() + 0.1, "second": clock.monotonic_s() + 0.3}

    def is_executing(workflow_id: str) -> bool:
        return recorded_s[workflow_id] > clock.monotonic_s()

    pause = PollPause(lambda: True, is_executing=is_executing, clock=clock)
    pause.cut_short("first")
    pause.cut_short("second")
    for at_s in recorded_s.values():
        assert not pause.wait(3600.0)
        assert at_s <= clock.monotonic_s() <= at_s + 2 * LOOK_S

    # A workflow that is announced meanwhile may have a place.
    recorded_s["third"] = clock.monotonic_s() + 0.5
    began_s = clock.monotonic_s()
    pause.cut_short("third")
    pause.cut_short()
    assert not pause.wait(3600.0)
    assert clock.monotonic_s() == began_s
    assert not pause.wait(3600.0)
    assert recorded_s["third"] <= clock.monotonic_s() <= recorded_s["third"] + 2 * LOOK_S


def test_an_end_that_cannot_be_recorded_is_not_waited_for_for_long() -> None:
    clock = SteppedClock()
    pause = PollPause(lambda: True, is_executing=lambda _: True, clock=clock)
    began_s = clock.monotonic_s()
    pause.cut_short("never")
    assert not pause.wait(3600.0)
    assert clock.monotonic_s() - began_s == pytest.approx(BUSY_POLLING_S, abs=2 * LOOK_S)
    assert not pause.wait(10.0)
    assert clock.monotonic_s() - began_s >= 10.0


def test_a_pause_ends_for_good_when_it_is_set() -> None:
    pause = PollPause(lambda: False, clock=SteppedClock())
    pause.set()
    assert pause.wait(3600.0)
    assert pause.is_set()
