"""A world's clock from afar: it goes on at the world's rate, never back within a run, and stands without a fleet."""

from hypothesis import given
from hypothesis import strategies as st

from robots.link.mqtt.following_clock import EXTRAPOLATED_S, FollowingClock


class Wall:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def test_it_goes_on_at_the_worlds_rate() -> None:
    wall = Wall()
    clock = FollowingClock(wall)
    clock.set("r", 10.0, 4.0, running=True)
    wall.now_s += 0.5
    assert clock.is_running
    assert clock.now_s() == 12.0
    assert clock.rate == 4.0


def test_what_is_remembered_of_a_fleet_does_not_make_it_go() -> None:
    wall = Wall()
    clock = FollowingClock(wall)
    clock.set("r", 10.0, 1.0, running=False)
    assert not clock.is_running
    wall.now_s += 50
    assert clock.now_s() == 10.0


def test_without_a_message_it_stands_after_a_while() -> None:
    wall = Wall()
    clock = FollowingClock(wall)
    clock.set("r", 10.0, 2.0, running=True)
    wall.now_s += 3600
    assert not clock.is_running
    assert clock.now_s() == 10.0 + 2 * EXTRAPOLATED_S


def test_with_a_fleet_that_is_lost_it_stands_at_once() -> None:
    wall = Wall()
    clock = FollowingClock(wall)
    clock.set("r", 10.0, 1.0, running=True)
    wall.now_s += 1
    clock.stop()
    wall.now_s += 1
    assert clock.now_s() == 11.0


def test_another_run_begins_with_its_own_time() -> None:
    clock = FollowingClock(Wall())
    clock.set("r", 500.0, 1.0, running=True)
    assert clock.now_s() == 500.0
    clock.set("s", 3.0, 1.0, running=True)
    assert clock.now_s() == 3.0


WORDS = st.tuples(
    st.floats(0, 1000), st.sampled_from([None, 0.5, 1.0, 20.0]), st.booleans(), st.floats(0, 10)
)


@given(st.lists(WORDS))
def test_within_a_run_it_never_goes_back(words: list[tuple[float, float | None, bool, float]]) -> None:
    wall = Wall()
    clock = FollowingClock(wall)
    latest_s = 0.0
    for announced_s, rate, running, later_s in words:
        clock.set("r", announced_s, rate, running=running)
        for _ in range(2):
            now_s = clock.now_s()
            assert now_s >= latest_s
            latest_s = now_s
            wall.now_s += later_s
