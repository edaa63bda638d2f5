"""How agent models record the messages that arrive together, and answer those that they do not understand."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import pytest

from app.agents.agent_models import AgentModels, DueOrder, EmbodimentKeeper, Reception
from app.composition import Service
from robots.clock import ManualClock
from robots.link import InMemoryLink
from robots.wire import (
    Message,
    MindOrderReport,
    MindTransferReport,
    MindVerb,
    NotUnderstood,
    Performative,
    Receipt,
    Refusal,
    StatusReport,
    UnknownBody,
)
from robots.world import LinkSpec
from tests.waiting import until

BAD = "cannot be recorded"


class Reports:
    """Records reports, but fails, with everything that is recorded together, on a bad one."""

    def __init__(self) -> None:
        self.recorded: list[str] = []
        self.messages: list[Message] = []

    def record_all(self, messages: Sequence[Message], world: str) -> Sequence[Reception]:
        if any(message.id == BAD for message in messages):
            raise ValueError(BAD)
        self.recorded += [message.id for message in messages]
        self.messages += messages
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


@contextmanager
def agent_models(
    service: Service, link: InMemoryLink, reports: Reports, embodiments: EmbodimentKeeper | None = None
) -> Iterator[None]:
    """Of one robot, as long as the block."""
    agents = AgentModels(
        robots=lambda: {"yard_1": LinkSpec()},
        link=link,
        clock=ManualClock(),
        database=service.database,
        reports=reports,
        board=service.board,
        questions=service.questions,
        teleoperation=service.teleoperation,
        tunings=service.tunings,
        rules=service.rules,
        embodiments=embodiments,
        readmit=lambda: None,
        world="sample_store",
    )
    agents.start()
    yield
    agents.close()


def test_a_report_that_cannot_be_recorded_keeps_none_that_arrive_with_it_from_being_recorded(
    service: Service,
) -> None:
    near, far = InMemoryLink.pair()
    for message_id in ("first", "second", BAD, "third", "fourth"):
        far.send(report(message_id))
    reports = Reports()
    with agent_models(service, near, reports):
        until(lambda: len(reports.recorded) == 4)
    assert reports.recorded == ["first", "second", "third", "fourth"]
    assert {message.in_reply_to for message in far.receive()} == set(reports.recorded)


def test_a_message_of_an_unknown_kind_is_answered_with_not_understood_and_not_recorded(
    service: Service,
) -> None:
    near, far = InMemoryLink.pair()
    dance = report("a dance").model_copy(update={"body": UnknownBody(kind="dance")})
    answer = report("an answer").model_copy(update={"body": NotUnderstood(reason="unknown kind receipt")})
    for message in (dance, answer, dance, report("a report")):
        far.send(message)
    reports = Reports()
    with agent_models(service, near, reports):
        until(lambda: reports.recorded == ["a report"])
    replies = [(one.in_reply_to, one.performative, one.body) for one in far.receive()]
    assert replies == [
        ("a dance", Performative.NOT_UNDERSTOOD, NotUnderstood(reason="unknown kind dance")),
        ("a report", Performative.CONFIRM, Receipt()),
    ]


def test_of_many_messages_of_unknown_kinds_the_first_and_the_tenth_are_logged(
    service: Service, caplog: pytest.LogCaptureFixture
) -> None:
    near, far = InMemoryLink.pair()
    for number in range(10):
        far.send(report(f"dance {number}").model_copy(update={"body": UnknownBody(kind="dance")}))
    far.send(report("a report"))
    reports = Reports()
    with agent_models(service, near, reports):
        until(lambda: reports.recorded == ["a report"])
    assert [line for line in caplog.messages if "unknown kind" in line] == [
        "yard_1 sent a message of an unknown kind dance (1 so far)",
        "yard_1 sent a message of an unknown kind dance (10 so far)",
    ]


def test_a_robot_that_does_not_understand_a_request_on_a_script_refuses_it(service: Service) -> None:
    near, far = InMemoryLink.pair()
    not_understood = report("m1").model_copy(
        update={"body": NotUnderstood(reason="unknown kind clearance"), "in_reply_to": "script-1:cleared:1"}
    )
    far.send(not_understood)
    reports = Reports()
    with agent_models(service, near, reports):
        until(lambda: bool(reports.messages))
    assert reports.messages[0].performative is Performative.REFUSE
    assert reports.messages[0].body == Refusal(
        script_id="script-1", reason="not understood: unknown kind clearance"
    )


class Minds:
    """Takes what robots answer to orders to their minds, and orders nothing. Implements `EmbodimentKeeper`."""

    def __init__(self) -> None:
        self.answers: list[tuple[Performative, MindOrderReport]] = []
        self.transfers: list[tuple[Performative, MindTransferReport]] = []

    def due(self, world: str) -> Sequence[DueOrder]:
        return ()

    def has_leases(self, world: str) -> bool:
        return False

    def record_answer(
        self, world: str, robot: str, performative: Performative, report: MindOrderReport
    ) -> None:
        self.answers.append((performative, report))

    def record_transfer(
        self, world: str, robot: str, performative: Performative, report: MindTransferReport
    ) -> None:
        self.transfers.append((performative, report))


@pytest.mark.parametrize(
    ("request_id", "verb"), [("4:rest", "rest"), ("4:go_on", "go_on"), ("4:go_on:12.5", "go_on")]
)
def test_a_robot_that_does_not_understand_an_order_to_its_mind_refuses_it(
    service: Service, request_id: str, verb: str
) -> None:
    near, far = InMemoryLink.pair()
    body = NotUnderstood(reason="unknown kind mind_order")
    far.send(report("m1").model_copy(update={"body": body, "in_reply_to": f"yard_1:mind:{request_id}"}))
    minds = Minds()
    with agent_models(service, near, Reports(), minds):
        until(lambda: minds.answers)
    reason = "not understood: unknown kind mind_order"
    refusal = MindOrderReport(verb=MindVerb(verb), fence=4, reason=reason)
    assert minds.answers == [(Performative.REFUSE, refusal)]


def test_a_robot_that_does_not_understand_that_it_is_to_take_a_mind_refuses_it(service: Service) -> None:
    near, far = InMemoryLink.pair()
    body = NotUnderstood(reason="unknown kind mind_transfer")
    asked = "yard_1:mind:4:transfer:9f86d081:0"
    far.send(report("m1").model_copy(update={"body": body, "in_reply_to": asked}))
    minds = Minds()
    with agent_models(service, near, Reports(), minds):
        until(lambda: minds.transfers)
    (refused,) = minds.transfers
    assert refused[0] is Performative.REFUSE
    assert (refused[1].fence, refused[1].reason) == (4, "not understood: unknown kind mind_transfer")
