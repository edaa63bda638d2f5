"""Requests are acted on once, reports are kept until their receipt, and no link is needed to go on."""

from collections.abc import Sequence

import pytest

from robots.contract.mailbox import KEPT_REPORTS, RESENT_A_TICK, Mailbox
from robots.link import InMemoryLink, Link, LinkClosed
from robots.physical.body import Pose
from robots.wire import (
    Acknowledgement,
    Clearance,
    Control,
    ControlVerb,
    FailureCategory,
    Message,
    NotUnderstood,
    PacketReport,
    PacketState,
    Performative,
    Refusal,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    StatusQuery,
    StatusReport,
    UnknownBody,
)
from tests.robots.fake_world import FakeWorld
from tests.robots.stories import EAST, SOUTH, Service, carry, packet, room, run, run_for, script

START = Pose(x_m=4.0, y_m=1.5, heading_rad=EAST)


def fred(world: FakeWorld, *, receipts: bool = True, pose: Pose = START) -> Service:
    return Service(world, world.add("fred", pose), "fred", receipts=receipts)


def answers(service: Service, request: Message) -> list[Message]:
    return [message for message in service.heard if message.in_reply_to == request.id]


def test_a_script_is_agreed_to_and_starts_within_a_tick() -> None:
    world = room()
    service = fred(world)
    request = service.order(script("fred", packet("NAVIGATE", ref2="door")))
    run_for(world, [service], 0.2)
    assert [m.performative for m in answers(service, request)] == [Performative.AGREE]
    assert service.packets[0] == ("NAVIGATE", PacketState.INITIALIZING)


def test_a_request_that_arrives_twice_gets_the_same_answer_and_runs_once() -> None:
    world = room()
    service = fred(world)
    request = service.order(script("fred", packet("NAVIGATE", ref2="door")))
    run_for(world, [service], 0.2)
    service.link.send(request)
    run(world, [service], lambda: service.report is not None)
    service.link.send(request)
    run_for(world, [service], 1)
    assert len({m.id for m in answers(service, request)}) == 1
    assert len(answers(service, request)) == 3
    assert service.packets.count(("NAVIGATE", PacketState.RUNNING)) == 1


def test_a_script_sent_again_in_another_message_runs_once() -> None:
    world = room()
    service = fred(world)
    order = script("fred", packet("NAVIGATE", ref2="door"))
    service.order(order)
    run(world, [service], lambda: service.report is not None)
    again = service.order(order)
    run_for(world, [service], 1)
    assert isinstance(answers(service, again)[0].body, Acknowledgement)
    assert service.packets.count(("NAVIGATE", PacketState.RUNNING)) == 1


def test_a_second_script_is_refused_while_one_runs() -> None:
    world = room()
    service = fred(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door"), name="first"))
    second = service.order(script("fred", packet("NAVIGATE", ref2="yard"), name="second"))
    run_for(world, [service], 0.2)
    (answer,) = answers(service, second)
    assert isinstance(answer.body, Refusal)
    assert answer.body.reason == "fred is busy with script first"


@pytest.mark.parametrize(
    ("order", "names"),
    [
        (script("fred", packet("FLY")), "FLY"),
        (script("fred", packet("NAVIGATE", ref2="moon")), "moon"),
        (script("ginger", packet("NAVIGATE", ref2="door")), "ginger"),
    ],
)
def test_a_script_that_does_not_fit_is_refused_with_the_reason(order: object, names: str) -> None:
    world = room()
    service = fred(world)
    request = service.send(ScriptRequest(script=order))  # type: ignore[arg-type]
    run_for(world, [service], 0.2)
    (answer,) = answers(service, request)
    assert isinstance(answer.body, Refusal)
    assert names in answer.body.reason


def test_a_report_is_sent_again_until_its_receipt() -> None:
    world = room()
    service = fred(world, receipts=False)
    service.order(script("fred", packet("NAVIGATE", ref2="door", timeout_s=1)))
    run_for(world, [service], 20)
    reports = [m for m in service.heard if isinstance(m.body, ScriptReport | PacketReport)]
    times_heard = [sum(m.id == one.id for m in reports) for one in {m.id: m for m in reports}.values()]
    assert times_heard[0] >= 3  # in silence the oldest alone asks whether there is contact
    assert set(times_heard[1:]) == {1}
    service.receipts = True
    run_for(world, [service], 10)
    assert len({m.id for m in service.heard if isinstance(m.body, ScriptReport)}) == 1
    before = len(service.heard)
    run_for(world, [service], 40)
    assert not [m for m in service.heard[before:] if isinstance(m.body, ScriptReport | PacketReport)]


def test_reports_kept_are_bounded_and_how_a_script_ended_stays_longest() -> None:
    ours, theirs = InMemoryLink.pair()
    box = Mailbox("fred", theirs)
    end = ScriptReport(script_id="s", state=ScriptState.FINISHED, at_s=0)
    box.report(Performative.INFORM, end, 0)
    for at_s in range(2 * KEPT_REPORTS):
        step = PacketReport(script_id="s", packet_id="p", state=PacketState.RUNNING, at_s=at_s)
        box.report(Performative.INFORM, step, 0)
    assert box.kept == KEPT_REPORTS
    ours.receive()
    box.resend(100)
    assert isinstance(ours.receive()[0].body, ScriptReport)


def _said(box_end: InMemoryLink) -> list[float]:
    return [m.body.at_s for m in box_end.receive() if isinstance(m.body, PacketReport)]


def test_once_the_service_is_heard_all_that_is_overdue_is_sent_again_a_few_a_tick() -> None:
    ours, theirs = InMemoryLink.pair()
    box = Mailbox("fred", theirs)
    for at_s in range(RESENT_A_TICK + 5):
        step = PacketReport(script_id="s", packet_id="p", state=PacketState.RUNNING, at_s=at_s)
        box.report(Performative.INFORM, step, 0.0)
    ours.receive()
    tries = []
    for second in range(1, 60):
        box.resend(float(second))
        tries += [(second, at_s) for at_s in _said(ours)]
    assert tries == [(when, 0) for when in (2, 6, 14, 22, 30, 38, 46, 54)]
    query = Message(
        performative=Performative.QUERY,
        sender="service",
        receiver="fred",
        sent_at_s=60.0,
        body=StatusQuery(script_id="s"),
    )
    ours.send(query)
    box.collect(60.0)
    box.resend(60.0)
    assert _said(ours) == list(range(RESENT_A_TICK))
    box.resend(60.05)
    assert _said(ours) == list(range(RESENT_A_TICK, RESENT_A_TICK + 5))
    box.resend(60.1)
    assert _said(ours) == []
    ours.send(query.model_copy(update={"id": "query-2"}))
    box.collect(61.0)
    box.resend(61.0)
    assert _said(ours) == [], "their receipts may be on their way"
    box.resend(62.5)
    assert _said(ours) == list(range(RESENT_A_TICK))


def test_a_far_robot_gives_a_receipt_the_time_it_takes() -> None:
    ours, theirs = InMemoryLink.pair()
    box = Mailbox("fred", theirs, round_trip_s=20.0)
    step = PacketReport(script_id="s", packet_id="p", state=PacketState.RUNNING, at_s=0)
    box.report(Performative.INFORM, step, 0.0)
    tries = []
    for second in range(60):
        box.resend(float(second))
        tries += [second] * len(_said(ours))
    assert tries == [0, 22, 44]


class InterruptedLink:
    """A link that is closed while `closed`."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self.closed = False

    def send(self, message: Message) -> None:
        if self.closed:
            raise LinkClosed("closed")
        self._link.send(message)

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        if self.closed:
            raise LinkClosed("closed")
        return self._link.receive(timeout_s)

    def close(self) -> None: ...


def test_loss_of_contact_changes_nothing_for_the_script() -> None:
    world = room({"sample": 1 + 0.4j})
    ours, theirs = InMemoryLink.pair()
    link = InterruptedLink(theirs)
    world.add("fred", Pose(x_m=1, y_m=1.2, heading_rad=SOUTH), link=link)
    service = Service(world, ours, "fred")
    service.order(carry("fred", "sample", "door", "yard"))
    run_for(world, [service], 1)
    link.closed = True
    run_for(world, [], 60)
    assert abs(world.samples["sample"] - (5.4 + 1.2j)) < 0.1
    link.closed = False
    run_for(world, [service], 35)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED


def test_a_robot_tells_how_a_script_stands() -> None:
    world = room()
    service = fred(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door"), name="mine"))
    run_for(world, [service], 1)
    asked = service.send(StatusQuery(script_id="mine"), Performative.QUERY)
    unknown = service.send(StatusQuery(script_id="other"), Performative.QUERY)
    run_for(world, [service], 0.2)
    status, nothing = answers(service, asked)[0].body, answers(service, unknown)[0].body
    assert isinstance(status, StatusReport)
    assert isinstance(nothing, StatusReport)
    assert (status.state, status.packet_state) == (ScriptState.RUNNING, PacketState.RUNNING)
    assert status.perceived
    assert nothing.state is None


def test_cancel_stops_at_once_and_leaves_the_gripper_as_it_is() -> None:
    world = room({"sample": 1 + 0.4j})
    service = fred(world, pose=Pose(x_m=1, y_m=1.2, heading_rad=SOUTH))
    service.order(carry("fred", "sample", "door", "yard"))
    assert run(world, [service], lambda: ("TRANSPORT", PacketState.RUNNING) in service.packets)
    service.send(Control(script_id="script-fred", verb=ControlVerb.CANCEL), Performative.CANCEL)
    run_for(world, [service], 0.1)
    assert world.bodies["fred"].velocity == (0, 0)
    assert world.bodies["fred"].held == "sample"
    assert service.report is not None
    assert (service.report.state, service.report.category) == (
        ScriptState.CANCELLED,
        FailureCategory.CANCELLED,
    )


def test_a_cancelled_robot_takes_the_next_script() -> None:
    world = room()
    service = fred(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door"), name="first"))
    service.send(Control(script_id="first", verb=ControlVerb.CANCEL), Performative.CANCEL)
    run_for(world, [service], 0.2)
    request = service.order(script("fred", packet("NAVIGATE", ref2="door"), name="second"))
    run_for(world, [service], 0.2)
    assert isinstance(answers(service, request)[0].body, Acknowledgement)


def test_a_paused_robot_stands_and_its_time_does_not_run() -> None:
    world = room()
    service = fred(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door", timeout_s=20)))
    run_for(world, [service], 1)
    service.send(Control(script_id="script-fred", verb=ControlVerb.PAUSE))
    run_for(world, [service], 0.2)
    there = world.bodies["fred"].at
    run_for(world, [service], 40)
    assert world.bodies["fred"].at == there
    assert service.packets[-1] == ("NAVIGATE", PacketState.PAUSED)
    assert service.telemetry[-1].script_state is ScriptState.PAUSED
    service.send(Control(script_id="script-fred", verb=ControlVerb.RESUME))
    assert run(world, [service], lambda: service.report is not None, limit_s=20)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED


def test_control_of_an_unknown_or_ended_script_is_refused() -> None:
    world = room()
    service = fred(world)
    request = service.send(Control(script_id="nothing", verb=ControlVerb.PAUSE))
    run_for(world, [service], 0.2)
    assert isinstance(answers(service, request)[0].body, Refusal)


def test_a_packet_waits_until_all_it_comes_after_is_cleared() -> None:
    world = room()
    service = fred(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door", after=["a7", "a9"]), name="mine"))
    service.send(Clearance(script_id="mine", ended=("a9",)))
    run_for(world, [service], 5)
    asked = service.send(StatusQuery(script_id="mine"), Performative.QUERY)
    run_for(world, [service], 0.2)
    assert abs(world.bodies["fred"].at - (4.0 + 1.5j)) < 0.1
    assert service.packets == [("NAVIGATE", PacketState.INITIALIZING)]
    status = answers(service, asked)[0].body
    assert isinstance(status, StatusReport)
    assert status.detail == "waits for clearance: a7"
    cleared = service.send(Clearance(script_id="mine", ended=("a9", "a7")))
    assert run(world, [service], lambda: service.report is not None)
    assert isinstance(answers(service, cleared)[0].body, Acknowledgement)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED


def test_the_report_of_a_packet_that_comes_up_says_which_clearance_it_waits_for() -> None:
    world = room()
    service = fred(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door", after=["a7"])))
    run_for(world, [service], 0.2)
    (report,) = [message.body for message in service.heard if isinstance(message.body, PacketReport)]
    assert (report.state, report.detail) == (PacketState.INITIALIZING, "waits for clearance: a7")


def test_clearance_that_comes_before_its_packet_is_kept() -> None:
    world = room()
    service = fred(world)
    packets = (packet("NAVIGATE", ref2="door"), packet("NAVIGATE", ref2="yard", after=["a7"]))
    service.order(script("fred", *packets, name="mine"))
    service.send(Clearance(script_id="mine", ended=("a7",)))
    assert run(world, [service], lambda: service.report is not None)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED


def test_clearance_given_while_paused_counts_once_the_robot_goes_on() -> None:
    world = room()
    service = fred(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door", after=["a7"]), name="mine"))
    service.send(Control(script_id="mine", verb=ControlVerb.PAUSE))
    service.send(Clearance(script_id="mine", ended=("a7",)))
    run_for(world, [service], 5)
    assert abs(world.bodies["fred"].at - (4.0 + 1.5j)) < 0.1
    service.send(Control(script_id="mine", verb=ControlVerb.RESUME))
    assert run(world, [service], lambda: service.report is not None)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED


def test_clearance_for_a_script_that_is_over_or_unknown_is_refused() -> None:
    world = room()
    service = fred(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door"), name="mine"))
    run(world, [service], lambda: service.report is not None)
    over = service.send(Clearance(script_id="mine", ended=("a7",)))
    unknown = service.send(Clearance(script_id="other", ended=("a7",)))
    run_for(world, [service], 0.2)
    for request, why in ((over, "script mine has ended: finished"), (unknown, "no script other here")):
        (answer,) = answers(service, request)
        assert isinstance(answer.body, Refusal)
        assert answer.body.reason == why


def test_a_robot_that_is_never_cleared_gives_up_in_time_and_says_why() -> None:
    world = room()
    service = fred(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door", after=["a7"], wait_timeout_s=10)))
    assert run(world, [service], lambda: service.report is not None, limit_s=15)
    assert service.report is not None
    assert (service.report.state, service.report.category) == (ScriptState.FAILED, FailureCategory.DEADLINE)
    assert "waits for clearance: a7" in service.report.detail


def test_telemetry_comes_ten_times_a_second_and_tells_what_the_robot_believes() -> None:
    world = room({"sample": 1 + 0.4j})
    service = fred(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door")))
    run_for(world, [service], 2)
    assert 19 <= len(service.telemetry) <= 21
    last, true = service.telemetry[-1], world.bodies["fred"].at
    assert abs(complex(last.x_m, last.y_m) - true) < 0.1
    assert abs(complex(*last.tags["sample"]) - (1 + 0.4j)) < 0.2
    assert last.packet_tag == "NAVIGATE"
    assert {"translate/advance", "rotate/steer"} <= set(last.patterns)


def test_a_message_of_an_unknown_kind_is_answered_with_not_understood_once() -> None:
    world = room()
    service = fred(world)
    dance = Message(
        performative=Performative.REQUEST,
        sender="service",
        receiver="fred",
        sent_at_s=0.0,
        body=UnknownBody(kind="dance"),
    )
    for _ in range(2):
        service.link.send(dance)
        run_for(world, [service], 1)
    (answer,) = answers(service, dance)
    assert (answer.performative, answer.body) == (
        Performative.NOT_UNDERSTOOD,
        NotUnderstood(reason="unknown kind dance"),
    )


def test_a_report_that_the_service_does_not_understand_is_forgotten() -> None:
    ours, theirs = InMemoryLink.pair()
    box = Mailbox("fred", theirs)
    step = PacketReport(script_id="s", packet_id="p", state=PacketState.RUNNING, at_s=0)
    box.report(Performative.INFORM, step, 0.0)
    (report,) = ours.receive()
    ours.send(
        Message(
            performative=Performative.NOT_UNDERSTOOD,
            sender="service",
            receiver="fred",
            sent_at_s=0.0,
            in_reply_to=report.id,
            body=NotUnderstood(reason="unknown kind packet_report"),
        )
    )
    assert box.collect(1.0) == []
    assert box.kept == 0
