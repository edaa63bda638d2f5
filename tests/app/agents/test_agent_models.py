"""How agent models record the messages that arrive together."""

from collections.abc import Sequence

from app.agents.agent_models import AgentModels, Reception
from app.composition import Service
from robots.clock import ManualClock
from robots.link import InMemoryLink
from robots.wire import Message, Performative, StatusReport
from robots.world import LinkSpec
from tests.waiting import until

BAD = "cannot be recorded"


class Reports:
    """Records reports, but fails, with everything that is recorded together, on a bad one."""

    def __init__(self) -> None:
        self.recorded: list[str] = []

    def record_all(self, messages: Sequence[Message], world: str) -> Sequence[Reception]:
        if any(message.id == BAD for message in messages):
            raise ValueError(BAD)
        self.recorded += [message.id for message in messages]
        return [Reception.RECORDED] * len(messages)


def report(message_id: str) -> Message:
    return Message(
        id=message_id,
        performative=Performative.INFORM,
        sender="yard_1",
        receiver="service",
        sent_at_s=0.0,
        body=StatusReport(script_id="a script", state=None, at_s=0.0),
    )


def test_a_report_that_cannot_be_recorded_keeps_none_that_arrive_with_it_from_being_recorded(
    service: Service,
) -> None:
    near, far = InMemoryLink.pair()
    for message_id in ("first", "second", BAD, "third", "fourth"):
        far.send(report(message_id))
    reports = Reports()
    agents = AgentModels(
        robots=lambda: {"yard_1": LinkSpec()},
        link=near,
        clock=ManualClock(),
        database=service.database,
        reports=reports,
        board=service.board,
        questions=service.questions,
        teleoperation=service.teleoperation,
        tunings=service.tunings,
        readmit=lambda: None,
        world="sample_store",
    )
    agents.start()
    until(lambda: len(reports.recorded) == 4)
    agents.close()
    assert reports.recorded == ["first", "second", "third", "fourth"]
    assert {message.in_reply_to for message in far.receive()} == set(reports.recorded)
