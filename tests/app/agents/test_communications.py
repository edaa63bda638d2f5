"""When the service sends again what a robot has not answered."""

from collections.abc import Callable
from itertools import pairwise

import pytest

from app.agents.communications import MAX_SILENT_RESEND_S, MIN_RESEND_S, ResendSchedule, recordable
from robots.wire import Body, Message, Performative, Refusal, ScriptReport, ScriptState
from robots.world import LinkSpec
from tests.app.stepped_clock import SteppedClock


class Run:
    """A schedule whose two clocks are stepped together: the world's runs `rate` times as fast as the wall's."""

    def __init__(self, link: LinkSpec | None = None, *, rate: float = 1.0) -> None:
        self._now_s = 0.0
        self._rate = rate
        self._wall = SteppedClock()
        self._heard_s: float | None = None
        self.schedule = ResendSchedule(
            self, lambda _: link or LinkSpec(), heard_s=lambda _: self._heard_s, wall=self._wall
        )

    def now_s(self) -> float:
        return self._now_s

    def restart_world(self, now_s: float) -> None:
        """Its time begins again, the wall clock's goes on."""
        self._now_s = now_s
        self._wall.advance(1.0)

    def go(self, seconds: float, *, hears: Callable[[float], bool] = lambda _: False) -> list[float]:
        """Ask eight times a world second; returns when the message was sent."""
        sent = []
        for _ in range(round(8 * seconds)):
            if hears(self._now_s):
                self._heard_s = self._now_s
            if self.schedule.is_due("fred", "order"):
                sent.append(self._now_s)
            self._now_s += 0.125
            self._wall.advance(0.125 / self._rate)
        return sent


def test_to_a_robot_that_is_heard_it_goes_every_second() -> None:
    assert Run().go(4.0, hears=lambda _: True) == [0.0, 1.0, 2.0, 3.0]


def test_to_one_in_silence_it_goes_ever_more_seldom_but_does_not_cease() -> None:
    sent = Run().go(80.0)
    gaps = [later - one for one, later in pairwise(sent)]
    assert gaps == [1, 2, 4, 8, *[MAX_SILENT_RESEND_S] * 4]


def test_a_robots_first_message_after_a_silence_sends_it_at_once() -> None:
    run = Run()
    run.go(41.0)
    assert run.go(1.0, hears=lambda at_s: at_s > 41.45) == [41.5]


def test_a_far_robot_is_not_flooded_while_its_answer_is_under_way() -> None:
    far = LinkSpec(light_time_s=5.0)
    assert Run(far).go(30.0, hears=lambda _: True) == [0.0, 11.0, 22.0]


def test_however_fast_the_world_runs_an_answer_is_given_the_time_to_be_recorded() -> None:
    sent = Run(rate=100.0).go(60.0, hears=lambda _: True)
    assert sent[:3] == [0.0, 100 * MIN_RESEND_S, 200 * MIN_RESEND_S]


def test_in_a_world_started_again_it_is_sent_again() -> None:
    run = Run()
    run.go(100.0)
    run.restart_world(3.0)
    assert run.schedule.is_due("fred", "order")


def test_what_is_answered_is_forgotten() -> None:
    run = Run()
    run.go(1.0)
    assert run.schedule.has_unanswered
    run.schedule.keep(set())
    assert not run.schedule.has_unanswered
    assert run.schedule.is_due("fred", "order")


@pytest.mark.parametrize(
    "body",
    [
        ScriptReport(script_id="script-1", state=ScriptState.FAILED, at_s=1.0, detail="jaw\0stuck"),
        Refusal(script_id="script-1", reason="no\0"),
    ],
)
def test_what_no_database_records_is_replaced_in_robots_texts(body: Body) -> None:
    message = Message(
        performative=Performative.INFORM, sender="fred", receiver="service", sent_at_s=1.0, body=body
    )
    text = recordable(message).model_dump_json()
    assert "\\u0000" not in text
    assert "\ufffd" in text
    assert recordable(recordable(message)).body == recordable(message).body


def test_other_texts_of_robots_stay_as_they_are() -> None:
    report = ScriptReport(script_id="script-1", state=ScriptState.FAILED, at_s=1.0, detail="\\u0000 \t ü")
    message = Message(
        performative=Performative.INFORM, sender="fred", receiver="service", sent_at_s=1.0, body=report
    )
    assert recordable(message) == message
