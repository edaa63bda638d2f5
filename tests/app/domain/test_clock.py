import threading

from app.domain.clock import SystemClock, iso_utc
from tests.app.stepped_clock import SteppedClock


def test_an_instant_is_written_in_utc_with_milliseconds() -> None:
    assert iso_utc(1_769_860_800.1234) == "2026-01-31T12:00:00.123Z"


def test_the_system_clock_does_not_wait_for_an_event_that_is_set() -> None:
    event = threading.Event()
    event.set()
    assert SystemClock().wait(event, 60.0)
    assert not SystemClock().wait(threading.Event(), 0.0)


def test_a_stepped_wait_takes_its_whole_timeout_at_once() -> None:
    clock = SteppedClock(epoch_s=100.0, monotonic_s=5.0)
    assert not clock.wait(threading.Event(), 2.0)
    assert (clock.epoch_s(), clock.monotonic_s()) == (102.0, 7.0)
    clock.set_back(50.0)
    assert (clock.epoch_s(), clock.monotonic_s()) == (52.0, 7.0)
