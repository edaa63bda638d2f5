import pytest

from robots.clock import ManualClock
from sim import SimulationError
from sim.process.pacing import MAX_BACKLOG_S, Pacer


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(100.0)


def test_a_world_ahead_of_its_speed_waits(clock: ManualClock) -> None:
    pacer = Pacer(clock, 2.0)
    assert pacer.wait_s(0.0) == 0.0
    assert pacer.wait_s(1.0) == pytest.approx(0.5)
    clock.advance(0.5)
    assert pacer.wait_s(1.0) == 0.0


def test_a_world_without_a_speed_never_waits(clock: ManualClock) -> None:
    assert Pacer(clock, None).wait_s(1e6) == 0.0


def test_a_paused_world_waits_for_a_command_and_does_not_catch_up_afterwards(clock: ManualClock) -> None:
    pacer = Pacer(clock, 1.0)
    pacer.pause(True, 0.0)
    assert pacer.wait_s(0.0) is None
    clock.advance(60)
    pacer.pause(False, 0.0)
    assert pacer.wait_s(1.0) == pytest.approx(1.0)


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan")])
def test_a_speed_must_be_above_zero(clock: ManualClock, speed: float) -> None:
    with pytest.raises(SimulationError, match="speed must be above 0"):
        Pacer(clock, speed)


def test_a_world_that_cannot_keep_up_drops_the_backlog(clock: ManualClock) -> None:
    pacer = Pacer(clock, 4.0)
    world_s = 0.0
    for _ in range(100):  # each tick of 0.02 world seconds takes as many wall seconds
        world_s += 0.02
        clock.advance(0.02)
        assert pacer.wait_s(world_s) == 0.0
    assert pacer.wait_s(world_s + 4 * MAX_BACKLOG_S + 4) > 0
