import pytest

from sim.process.pacing import BACKLOG_S, Pacer


class Wall:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def wall() -> Wall:
    return Wall()


def test_a_world_ahead_of_its_speed_waits(wall: Wall) -> None:
    pacer = Pacer(wall, 2.0)
    assert pacer.wait_s(0.0) == 0.0
    assert pacer.wait_s(1.0) == pytest.approx(0.5)
    wall.now_s += 0.5
    assert pacer.wait_s(1.0) == 0.0


def test_flat_out_never_waits(wall: Wall) -> None:
    assert Pacer(wall, None).wait_s(1e6) == 0.0


def test_a_paused_world_waits_for_a_command_and_does_not_catch_up_afterwards(wall: Wall) -> None:
    pacer = Pacer(wall, 1.0)
    pacer.pause(True, 0.0)
    assert pacer.wait_s(0.0) is None
    wall.now_s += 60
    pacer.pause(False, 0.0)
    assert pacer.wait_s(1.0) == pytest.approx(1.0)


def test_a_new_speed_counts_from_now(wall: Wall) -> None:
    pacer = Pacer(wall, 1.0)
    wall.now_s += 10
    pacer.set_speed(10.0, 10.0)
    assert pacer.wait_s(15.0) == pytest.approx(0.5)


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan")])
def test_a_speed_must_be_above_zero(wall: Wall, speed: float) -> None:
    with pytest.raises(ValueError, match="speed is above 0"):
        Pacer(wall, 1.0).set_speed(speed, 0.0)


def test_a_world_that_cannot_keep_up_lets_the_backlog_go_and_says_how_fast_it_is(wall: Wall) -> None:
    pacer = Pacer(wall, 4.0)
    world_s = 0.0
    for _ in range(100):  # each tick of 0.02 world seconds takes as many wall seconds
        world_s += 0.02
        wall.now_s += 0.02
        assert pacer.wait_s(world_s) == 0.0
    assert pacer.real_time_factor == pytest.approx(1.0, abs=0.05)
    assert pacer.wait_s(world_s + 4 * BACKLOG_S + 4) > 0
