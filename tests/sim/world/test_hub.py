from robots.clock import ManualClock
from robots.link import InMemoryLink
from robots.wire import Message, PacketReport, PacketState, Performative, Receipt, SpeechAct, Telemetry
from robots.world import LinkSpec
from sim.world.hub import MAX_WAITING, Hub
from sim.world.radio import PeerRadios, Radio


def telemetry(robot: str, at_s: float) -> Message:
    body = Telemetry(at_s=at_s, x_m=0, y_m=0, heading_rad=0)
    return Message(
        performative=Performative.INFORM, sender=robot, receiver="service", sent_at_s=at_s, body=body
    )


def report(robot: str, at_s: float) -> Message:
    body = PacketReport(script_id="s", packet_id=f"p{at_s}", state=PacketState.RUNNING, at_s=at_s)
    return Message(
        performative=Performative.INFORM, sender=robot, receiver="service", sent_at_s=at_s, body=body
    )


def receipt(robot: str) -> Message:
    return Message(
        performative=Performative.CONFIRM, sender="service", receiver=robot, sent_at_s=0, body=Receipt()
    )


class Channel:
    """A hub of two robots whose wall clock and room in the pipe are set by hand."""

    def __init__(self, *, gap_s: float = 0.05) -> None:
        self.clock = ManualClock()
        self.room = True
        self.service, robots_end = InMemoryLink.pair()
        self.hub = Hub(
            robots_end,
            ["fred", "ginger"],
            telemetry_gap_s=gap_s,
            wall_clock=self.clock,
            has_room=lambda: self.room,
        )

    def arrived(self) -> list[tuple[str, str, float]]:
        self.hub.flush(0.0)
        return [(m.body.kind, m.sender, m.sent_at_s) for m in self.service.receive()]


def test_a_message_reaches_its_receiver_alone() -> None:
    channel = Channel()
    channel.service.send(receipt("ginger"))
    channel.service.send(receipt("nobody"))
    channel.hub.receive(0.0)
    assert channel.hub.link_of("fred").receive() == ()
    assert [m.receiver for m in channel.hub.link_of("ginger").receive()] == ["ginger"]
    assert channel.hub.link_of("ginger").receive() == ()


def test_of_telemetry_the_newest_is_sent_once_in_the_gap() -> None:
    channel = Channel()
    fred = channel.hub.link_of("fred")
    fred.send(telemetry("fred", 1))
    assert channel.arrived() == [("telemetry", "fred", 1)]
    for at_s in (2, 3, 4):
        fred.send(telemetry("fred", at_s))
        assert channel.arrived() == []
    channel.clock.advance(0.06)
    assert channel.arrived() == [("telemetry", "fred", 4)]
    assert channel.arrived() == []


def test_one_robots_telemetry_does_not_hold_back_anothers() -> None:
    channel = Channel()
    channel.hub.link_of("fred").send(telemetry("fred", 1))
    channel.arrived()
    channel.hub.link_of("ginger").send(telemetry("ginger", 1))
    assert channel.arrived() == [("telemetry", "ginger", 1)]


def test_reports_are_never_thinned() -> None:
    channel = Channel()
    for at_s in range(5):
        channel.hub.link_of("fred").send(report("fred", at_s))
    assert [sent for _, _, sent in channel.arrived()] == [0, 1, 2, 3, 4]


def test_reports_wait_in_order_while_the_pipe_is_full_and_go_before_telemetry() -> None:
    channel = Channel()
    channel.room = False
    fred = channel.hub.link_of("fred")
    fred.send(report("fred", 1))
    fred.send(telemetry("fred", 2))
    fred.send(report("fred", 3))
    assert channel.arrived() == []
    channel.room = True
    assert [sent for _, _, sent in channel.arrived()] == [1, 3, 2]


def test_what_robots_say_waits_for_its_release_and_telemetry_does_not() -> None:
    service, robots_end = InMemoryLink.pair()
    hub = Hub(robots_end, ["fred"], holds=True)
    fred = hub.link_of("fred")
    fred.send(report("fred", 1))
    fred.send(telemetry("fred", 2))
    hub.flush(2.0)
    assert hub.is_holding
    assert [m.body.kind for m in service.receive()] == ["telemetry"]
    hub.release()
    fred.send(report("fred", 3))
    hub.flush(2.0)
    assert [m.sent_at_s for m in service.receive()] == [1]
    assert hub.is_holding


def test_a_limited_number_of_messages_waits_for_a_snapshot() -> None:
    service, robots_end = InMemoryLink.pair()
    hub = Hub(robots_end, ["fred"], holds=True)
    for number in range(MAX_WAITING + 5):
        hub.link_of("fred").send(report("fred", number))
    hub.release()
    hub.flush(0.0)
    waited = [message.sent_at_s for message in service.receive()]
    assert waited == list(range(MAX_WAITING))


def speech(sender: str, receiver: str) -> Message:
    act = SpeechAct(content="hello", conversation_id=f"{sender}-{receiver}")
    return Message(
        performative=Performative.INFORM, sender=sender, receiver=receiver, sent_at_s=0.0, body=act
    )


def speaking(link: LinkSpec | None) -> Channel:
    channel = Channel()
    cut = Radio(LinkSpec.model_validate({"outages": [{"start_s": 0, "end_s": 1e6}]}))
    peers = None if link is None else PeerRadios(link, seed=0)
    channel.hub.connect({"fred": cut, "ginger": cut}, peers)
    return channel


def heard(channel: Channel, robot: str, at_s: float) -> list[str]:
    channel.hub.receive(at_s)
    return [message.sender for message in channel.hub.link_of(robot).receive()]


def test_robots_hear_each_other_by_the_radio_between_them_while_the_uplink_is_cut() -> None:
    channel = speaking(LinkSpec(delay_s=2.0))
    fred = channel.hub.link_of("fred")
    fred.send(speech("fred", "ginger"))
    fred.send(report("fred", 0.0))
    assert heard(channel, "ginger", 0.0) == []
    assert heard(channel, "ginger", 2.0) == ["fred"]
    assert channel.arrived() == [], "the uplink is cut, and what is not for the service does not go there"
    assert channel.hub.peer_letters == 1


def test_robots_of_a_world_without_a_radio_between_them_do_not_hear_each_other() -> None:
    channel = speaking(None)
    channel.hub.link_of("fred").send(speech("fred", "ginger"))
    assert heard(channel, "ginger", 10.0) == []


def test_no_robot_speaks_in_the_name_of_another() -> None:
    channel = speaking(LinkSpec())
    channel.hub.link_of("fred").send(speech("ginger", "fred"))
    assert heard(channel, "fred", 0.0) == []


def test_what_is_said_to_a_robot_that_is_not_simulated_leaves_the_world() -> None:
    channel = speaking(LinkSpec())
    channel.hub.link_of("fred").send(speech("fred", "rover"))
    assert heard(channel, "ginger", 0.0) == []
    assert [kind for kind, _, _ in channel.arrived()] == ["speech_act"]
    channel.service.send(speech("rover", "ginger"))
    assert heard(channel, "ginger", 1.0) == ["rover"]
