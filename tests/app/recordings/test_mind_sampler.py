"""Recorded robots are asked for their minds, one question at a time, as long as they have any."""

from app.agents.questions import MAX_OPEN, Questions
from app.recordings import MindSampler
from app.recordings.mind_sampler import EVERY_S, PATIENCE_S
from robots.wire import Body, Message, MindReport, Performative, ToldAgent, TraceReport
from tests.app.stepped_clock import SteppedClock

GUARD = MindReport(at_s=1.0, agents=(ToldAgent(name="guard"),))


class Asked:
    """A sampler, and the robots that it asks."""

    def __init__(self, *, cheap: bool = True) -> None:
        self.questions = Questions(patience_s=1.0)
        self.wall = SteppedClock()
        self.sampler = MindSampler(self.questions, is_cheap=lambda name: cheap, wall=self.wall)

    def reports(self, *robots: str) -> dict[str, MindReport]:
        return dict(self.sampler.reports(robots))

    def sent(self) -> list[str]:
        """Takes what is asked."""
        self._sent = self.questions.to_send(["yard_1"])
        return [one.robot for one in self._sent]

    def answer(self, body: Body) -> None:
        (question,) = self._sent
        message = Message(
            performative=Performative.INFORM,
            sender="yard_1",
            receiver="service",
            sent_at_s=1.0,
            in_reply_to=question.id,
            body=body,
        )
        self.questions.answered(message)


def test_a_robot_is_asked_again_after_its_answer_and_a_pause() -> None:
    asked = Asked()
    assert asked.reports("yard_1") == {}
    assert asked.sent() == ["yard_1"]
    asked.answer(GUARD)
    assert asked.reports("yard_1") == {"yard_1": GUARD}
    assert asked.sent() == []
    asked.wall.advance(EVERY_S)
    assert asked.reports("yard_1") == {}
    assert asked.sent() == ["yard_1"]


def test_a_robot_without_rules_is_asked_again_once_it_gets_some() -> None:
    asked = Asked()
    asked.reports("yard_1")
    asked.sent()
    asked.answer(MindReport(at_s=1.0))
    asked.wall.advance(EVERY_S)
    assert asked.reports("yard_1") == {}
    assert asked.sent() == []
    asked.sampler.rules_changed("yard_1")
    asked.reports("yard_1")
    assert asked.sent() == ["yard_1"]


def test_an_answer_that_does_not_come_is_given_up_and_asked_for_again() -> None:
    asked = Asked()
    for _ in range(MAX_OPEN + 1):
        asked.reports("yard_1")
        assert asked.sent() == ["yard_1"]
        asked.wall.advance(PATIENCE_S)


def test_a_robot_that_answers_something_else_is_not_asked_again() -> None:
    asked = Asked()
    asked.reports("yard_1")
    asked.sent()
    asked.answer(TraceReport(at_s=1.0))
    asked.wall.advance(EVERY_S)
    assert asked.reports("yard_1") == {}
    assert asked.sent() == []


def test_nobody_is_asked_over_a_radio_that_has_no_room_for_it() -> None:
    asked = Asked(cheap=False)
    asked.reports("yard_1")
    assert asked.sent() == []


def test_a_robot_that_is_recorded_no_longer_is_not_asked() -> None:
    asked = Asked()
    asked.reports("yard_1")
    asked.reports()
    assert asked.sent() == []
