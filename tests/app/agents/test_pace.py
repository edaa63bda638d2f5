"""When the service sends again what a robot has not answered."""

from collections.abc import Callable
from itertools import pairwise

from app.agents.pace import LEAST_S, SILENT_AT_MOST_S, Pace
from robots.clock import ManualClock
from robots.world import LinkSpec


class Run:
    """A pace whose two clocks are moved by hand, and the world seconds at which a message was sent."""

    def __init__(self, link: LinkSpec = LinkSpec(), *, rate: float = 1.0) -> None:  # noqa: B008
        self.clock, self.rate = ManualClock(), rate
        self.heard_s: float | None = None
        self.pace = Pace(
            self.clock,
            {"fred": link},
            heard_s=lambda _: self.heard_s,
            wall=lambda: self.clock.now_s() / self.rate,
        )

    def go(self, seconds: float, *, hears: Callable[[float], bool] = lambda _: False) -> list[float]:
        """Look eight times a world second; answers when the message was sent meanwhile."""
        sent = []
        for _ in range(round(8 * seconds)):
            if hears(self.clock.now_s()):
                self.heard_s = self.clock.now_s()
            if self.pace.is_due("fred", "order"):
                sent.append(self.clock.now_s())
            self.clock.advance(0.125)
        return sent


def test_to_a_robot_that_is_heard_it_goes_every_second() -> None:
    assert Run().go(4.0, hears=lambda _: True) == [0.0, 1.0, 2.0, 3.0]


def test_to_one_in_silence_it_goes_ever_more_seldom_but_does_not_cease() -> None:
    sent = Run().go(80.0)
    gaps = [later - one for one, later in pairwise(sent)]
    assert gaps == [1, 2, 4, 8, *[SILENT_AT_MOST_S] * 4]


def test_a_robots_first_word_after_a_silence_brings_it_at_once() -> None:
    run = Run()
    run.go(41.0)
    assert run.go(1.0, hears=lambda at_s: at_s > 41.45) == [41.5]


def test_a_far_robot_is_not_flooded_while_its_answer_is_under_way() -> None:
    far = LinkSpec(light_time_s=5.0)
    assert Run(far).go(30.0, hears=lambda _: True) == [0.0, 11.0, 22.0]


def test_however_fast_the_world_runs_an_answer_is_given_the_time_to_be_recorded() -> None:
    sent = Run(rate=100.0).go(60.0, hears=lambda _: True)
    assert sent[:3] == [0.0, 100 * LEAST_S, 200 * LEAST_S]


def test_in_a_world_begun_anew_it_goes_again() -> None:
    run = Run()
    run.go(100.0)
    run.clock = ManualClock(3.0)
    run.pace._clock = run.clock
    assert run.pace._wall() < 100.0
    run.pace._wall = lambda: 1000.0
    assert run.pace.is_due("fred", "order")


def test_what_is_answered_is_forgotten() -> None:
    run = Run()
    run.go(1.0)
    assert run.pace.outstanding
    run.pace.keep(set())
    assert not run.pace.outstanding
    assert run.pace.is_due("fred", "order")
