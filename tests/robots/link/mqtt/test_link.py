"""Messages over a real broker: both ways, each to its own robot, with the broker killed, hung and restarted."""

import os
import threading
import time
from typing import Any

import pytest
from paho.mqtt.client import Client
from paho.mqtt.enums import CallbackAPIVersion

from robots.clock import ManualClock
from robots.link.mqtt import Broker, ConnectionState, FleetLink, ServiceLink, WorldAnnouncement
from robots.link.mqtt.session import MAX_PACKET_BYTES
from robots.link.mqtt.topics import Channel, robot_topic, world_topic
from robots.wire import (
    MAX_FACTSHEET_BYTES,
    MAX_IMAGE_BYTES,
    Factsheet,
    ImageResult,
    Message,
    PacketReport,
    PacketState,
    SetPoint,
)
from tests.mosquitto import Mosquitto, needs_mosquitto
from tests.robots.link.mqtt.ends import (
    ROBOTS,
    RUN,
    WORLD,
    Board,
    a_fleet,
    a_service,
    both,
    received,
    report,
    script_request,
    telemetry,
    to_robot,
)
from tests.waiting import until

pytestmark = needs_mosquitto
AHEAD = 4_000_000_000.0
"""The number of a fleet whose clock is set to the year 2096."""


def at(broker: Mosquitto) -> Broker:
    return Broker.at(broker.url)


def shout(broker: Mosquitto, topic: str, payload: bytes, *, retain: bool = False) -> None:
    """Anything at all, on any topic."""
    client = Client(CallbackAPIVersion.VERSION2)
    client.connect("127.0.0.1", broker.port)
    client.loop_start()
    client.publish(topic, payload, qos=1, retain=retain).wait_for_publish(10)
    client.disconnect()
    client.loop_stop()


class Watching:
    """A client that notes with what quality of service a topic's messages were published."""

    def __init__(self, broker: Mosquitto, topic: str) -> None:
        self.qos: list[int] = []
        self._hears = threading.Event()
        self._client = Client(CallbackAPIVersion.VERSION2)
        self._client.on_message = lambda client, data, message: self.qos.append(message.qos)
        self._client.on_subscribe = lambda *_: self._hears.set()
        self._port, self._topic = broker.port, topic

    def __enter__(self) -> "Watching":
        self._client.connect("127.0.0.1", self._port)
        self._client.loop_start()
        self._client.subscribe(self._topic, qos=2)
        assert self._hears.wait(10)
        return self

    def __exit__(self, *_: object) -> None:
        self._client.disconnect()
        self._client.loop_stop()


def test_messages_pass_both_ways_unchanged(broker: Mosquitto) -> None:
    with both(at(broker)) as (service, fleet):
        orders = [script_request("fred"), to_robot("ginger")]
        for order in orders:
            service.send(order)
        assert {m.id: m for m in received(fleet, 2)} == {m.id: m for m in orders}
        fleet.send(report("ginger"))
        (said,) = received(service, 1)
        assert (said.sender, said.body.kind) == ("ginger", "packet_report")


def set_point_is_taken(service: ServiceLink) -> bool:
    """Send a set-point; the link drops it while other messages, such as receipts, wait to be written."""
    before = service.dropped
    service.send(to_robot("fred", SetPoint(driver="ada", number=1, valid_s=0.5)))
    return service.dropped == before


def test_a_set_point_does_not_wait_for_a_robot_that_is_away(broker: Mosquitto) -> None:
    """What was published at least once waits at the broker for a client that keeps its session."""
    with both(at(broker)) as (service, _):
        with Watching(broker, robot_topic(WORLD, "fred", Channel.INSTANT_ACTIONS)) as watching:
            until(lambda: set_point_is_taken(service), "the link has nothing else to write")
            service.send(to_robot("fred"))
            until(lambda: len(watching.qos) == 2, "both orders pass")
        assert watching.qos == [0, 1]


def test_telemetry_and_connections_are_reported_at_once(broker: Mosquitto) -> None:
    board = Board()
    with both(at(broker), board) as (_, fleet):
        until(lambda: board.are_all(ConnectionState.ONLINE))
        fleet.send(telemetry("fred", 2.5))
        until(lambda: board.telemetry == [("fred", 2.5)])


def test_a_fleet_that_leaves_says_offline(broker: Mosquitto) -> None:
    board = Board()
    with a_fleet(at(broker)) as fleet:
        until(lambda: fleet.connected)
    with a_service(at(broker), board):
        until(lambda: board.remembered == set(ROBOTS))
    assert board.states == dict.fromkeys(ROBOTS, ConnectionState.OFFLINE)


def test_a_world_is_without_a_fleet_from_when_it_has_left(broker: Mosquitto) -> None:
    clock = ManualClock()
    with a_service(at(broker), wall_s=clock.now_s) as service:
        until(lambda: service.connected)
        clock.advance(60.0)
        with a_fleet(at(broker)):
            until(lambda: service.fleetless_s == 0.0)
        until(lambda: service.fleetless_s == 60.0)


def test_what_the_broker_remembers_is_not_taken_for_a_fleet_that_is_there(broker: Mosquitto) -> None:
    with a_fleet(at(broker)) as fleet:
        until(lambda: fleet.connected)
        fleet.announce(41.5, 1.0)
    with a_service(at(broker)) as service:
        until(lambda: service.run == RUN)
        stands_s = service.clock.now_s()
        time.sleep(0.2)
        assert service.clock.now_s() == stands_s == 41.5


def test_an_order_for_another_run_of_the_world_is_dropped_and_so_is_a_report_of_one(
    broker: Mosquitto,
) -> None:
    board = Board()
    with both(at(broker), board) as (service, fleet):
        service.take_up("another")
        service.send(to_robot("fred"))
        fleet.send(report("fred", "of the other run"))

        def has_come() -> bool:
            fleet.send(telemetry("fred", 1.0))  # after the report; lost if that is not written yet
            return bool(board.telemetry)

        until(has_come)
        service.take_up(RUN)
        service.send(script_request("fred"))
        fleet.send(report("fred", "of this run"))
        assert [m.body.kind for m in received(fleet, 1)] == ["script_request"]
        assert [getattr(m.body, "packet_id", "") for m in received(service, 1)] == ["of this run"]


def test_a_message_that_does_not_say_of_which_run_it_is_is_counted(broker: Mosquitto) -> None:
    with both(at(broker)) as (service, fleet):
        said = report("fred").model_dump_json().encode()
        shout(broker, robot_topic(WORLD, "fred", Channel.STATE), said)
        until(lambda: service.malformed == 1)
        fleet.send(report("ginger"))
        assert [one.sender for one in received(service, 1)] == ["ginger"]


def test_nothing_is_sent_before_a_run_is_taken_up(broker: Mosquitto) -> None:
    board = Board()
    with a_service(at(broker), board) as service, a_fleet(at(broker)) as fleet:
        until(lambda: service.run == RUN)
        until(lambda: board.are_all(ConnectionState.ONLINE))
        service.send(to_robot("fred"))
        service.take_up(RUN)
        service.send(script_request("fred"))
        assert [m.body.kind for m in received(fleet, 1)] == ["script_request"]


@pytest.mark.parametrize(
    "topic", ["fred/state", "fred/visualization", "fred/connection", "fred/order", "world"]
)
def test_what_cannot_be_understood_is_counted_and_harms_nothing(broker: Mosquitto, topic: str) -> None:
    with both(at(broker)) as (service, fleet):
        for payload in (b"", b"\xff\x00", b"[1, 2]", b'{"kind": "telemetry"}', b'{"state": "happy"}'):
            shout(broker, f"macta/v1/hall/{topic}", payload)
        hearers = 2 if topic == "world" else 1
        until(lambda: service.malformed + fleet.malformed == 5 * hearers)
        fleet.send(report("ginger"))
        assert received(service, 1)


def test_a_robot_cannot_speak_for_another_nor_take_its_orders(broker: Mosquitto) -> None:
    with both(at(broker)) as (service, fleet):
        shout(broker, "macta/v1/hall/ginger/state", report("fred").model_dump_json().encode())
        shout(broker, "macta/v1/hall/ginger/order", script_request("fred").model_dump_json().encode())
        until(lambda: (service.malformed, fleet.malformed) == (1, 1))
        assert list(service.receive()) == list(fleet.receive()) == []


def is_dropped(fleet: FleetLink, message: Message) -> bool:
    """Send a message; True if its robot's client is known to be disconnected."""
    before = fleet.dropped
    fleet.send(message)
    return fleet.dropped > before


def test_after_the_broker_was_killed_both_ends_meet_again(broker: Mosquitto) -> None:
    board = Board()
    with both(at(broker), board) as (service, fleet):
        broker.kill()
        until(lambda: not service.connected)
        until(lambda: is_dropped(fleet, report("fred", "probe")))  # each robot's client finds out for itself
        for _ in range(50):
            service.send(to_robot("fred"))
            fleet.send(report("fred"))
            fleet.send(telemetry("fred", 1))
        board.states.clear()
        broker.start()
        until(lambda: service.connected and fleet.connected)
        until(lambda: board.are_all(ConnectionState.ONLINE))
        fleet.send(report("ginger", "afterwards"))
        service.send(script_request("ginger"))
        heard: list[str] = []

        def has_heard(packet: str) -> bool:
            heard.extend(getattr(message.body, "packet_id", "") for message in service.receive())
            return packet in heard

        until(lambda: has_heard("afterwards"))
        assert set(heard) <= {"probe", "afterwards"}
        assert [m.body.kind for m in received(fleet, 1)] == ["script_request"]


def test_a_broker_that_is_not_there_yet_is_waited_for(broker: Mosquitto) -> None:
    broker.kill()
    with a_service(at(broker)) as service, a_fleet(at(broker)) as fleet:
        until(lambda: "cannot be reached" in service.complaint and "cannot be reached" in fleet.complaint)
        broker.start()
        until(lambda: service.run == RUN and fleet.connected)
        assert (service.complaint, fleet.complaint) == ("", "")


def test_what_waits_for_a_broker_that_hangs_is_bounded(broker: Mosquitto) -> None:
    with both(at(broker)) as (service, fleet):
        broker.pause()
        try:
            said, shown, ordered = report("fred"), telemetry("fred", 1.0), to_robot("fred")
            for _ in range(5000):
                fleet.send(shown)
                fleet.send(said)
                service.send(ordered)
            assert fleet.dropped >= 4900, "a robot has at most 100 letters under way"
            assert service.dropped >= 4000, "the service at most 1000"
        finally:
            broker.pause(False)

        def is_heard() -> bool:
            fleet.send(report("ginger"))  # it may have to connect again
            return any(m.sender == "ginger" for m in service.receive(0.05))

        until(is_heard)


def test_a_robot_that_is_lost_is_reported_broken_by_its_last_will_and_comes_again(broker: Mosquitto) -> None:
    board = Board()
    with both(at(broker), board) as (_, fleet):
        until(lambda: len(board.states) == 2)
        states: list[tuple[str, ConnectionState]] = []
        board.connected = lambda robot, state, **_: states.append((robot, state))  # type: ignore[method-assign]
        sock = fleet._robots["fred"].client.socket()
        assert sock is not None
        sock.shutdown(2)  # what the kernel does for a process that is killed
        until(lambda: ("fred", ConnectionState.ONLINE) in states)
        assert list(dict.fromkeys(states)) == [  # what was said before may be said again
            ("fred", ConnectionState.CONNECTION_BROKEN),
            ("fred", ConnectionState.ONLINE),
        ]


def test_a_second_fleet_of_a_world_supersedes_the_first_which_does_not_come_again(broker: Mosquitto) -> None:
    with a_fleet(at(broker)) as first:
        until(lambda: first.connected)
        with a_fleet(at(broker), run="run-2") as second:
            until(lambda: first.superseded)
            first.close()
            until(lambda: second.connected)
            board = Board()
            with a_service(at(broker), board) as service:
                until(lambda: service.run == "run-2")
                until(lambda: board.are_all(ConnectionState.ONLINE))
            assert second.connected
            assert not second.superseded


def announced(state: ConnectionState, number: float) -> bytes:
    told = WorldAnnouncement(state=state, run="run-0", time_s=7.0, began_at=number)
    return told.model_dump_json().encode()


def settled(broker: Mosquitto, fleet: FleetLink, run: str) -> bool:
    """True if the fleet drives the world and the broker remembers its announcement."""
    with a_service(at(broker)) as service:
        until(lambda: service.run is not None)
        return fleet.connected and not fleet.superseded and service.run == run


@pytest.mark.parametrize("state", ConnectionState)
def test_a_fleet_whose_clock_was_ahead_does_not_bar_a_later_one(
    broker: Mosquitto, state: ConnectionState
) -> None:
    shout(broker, world_topic(WORLD), announced(state, AHEAD), retain=True)
    with a_fleet(at(broker)) as fleet:
        until(lambda: fleet.connected and settled(broker, fleet, RUN))


@pytest.mark.parametrize("clock_s", [0.0, AHEAD])
def test_of_two_fleets_the_one_that_began_later_drives_whatever_their_clocks_say(
    broker: Mosquitto, clock_s: float
) -> None:
    with a_fleet(at(broker), epoch_s=lambda: AHEAD) as first:
        until(lambda: first.connected)
        with a_fleet(at(broker), run="run-2", epoch_s=lambda: clock_s) as second:
            until(lambda: first.superseded)
            first.close()
            until(lambda: settled(broker, second, "run-2"))


def test_a_fleet_goes_on_after_one_that_came_in_between_and_left(broker: Mosquitto) -> None:
    with a_fleet(at(broker)) as fleet:
        until(lambda: fleet.connected)
        shout(broker, world_topic(WORLD), announced(ConnectionState.OFFLINE, AHEAD), retain=True)
        until(lambda: settled(broker, fleet, RUN))
        shout(broker, world_topic(WORLD), announced(ConnectionState.ONLINE, 2 * AHEAD), retain=True)
        until(lambda: fleet.superseded)


def test_a_fleet_of_another_world_file_is_not_listened_to(broker: Mosquitto) -> None:
    with a_service(at(broker), digest="ours") as service, a_fleet(at(broker), digest="theirs"):
        until(lambda: "another world file" in service.complaint)
        assert service.run is None


def test_a_fleet_that_does_not_say_by_which_world_file_is_listened_to(broker: Mosquitto) -> None:
    with a_service(at(broker), digest="ours") as service, a_fleet(at(broker)):
        until(lambda: service.run == RUN)
        assert service.complaint == ""


def test_messages_of_many_threads_all_arrive(broker: Mosquitto) -> None:
    with both(at(broker)) as (service, fleet):

        def tell(robot: str) -> None:
            for number in range(40):
                fleet.send(report(robot, str(number)))

        threads = [threading.Thread(target=tell, args=(robot,)) for robot in ROBOTS]
        for thread in threads:
            thread.start()
        came: list[Message] = received(service, 80)
        for thread in threads:
            thread.join()
        assert len({message.id for message in came}) == 80


def test_sixty_four_robots_take_one_thread(broker: Mosquitto) -> None:
    before = set(threading.enumerate())
    names = [f"robot_{number}" for number in range(64)]
    fleet = FleetLink(WORLD, names, at(broker), run=RUN)
    fleet.start()
    try:
        until(lambda: fleet.connected)
        assert len(set(threading.enumerate()) - before) == 1
    finally:
        fleet.close()
    assert not set(threading.enumerate()) - before


def test_a_report_with_the_most_and_largest_images_comes_through(broker: Mosquitto) -> None:
    data = b"\xff\xd8\xff".ljust(MAX_IMAGE_BYTES, b"x")
    image = ImageResult(name="n" * 64, of="o" * 64, media_type="image/jpeg", data=data)
    body = PacketReport(
        script_id="s", packet_id="p", state=PacketState.FINISHED, at_s=1.0, results=(image,) * 4
    )
    with both(at(broker)) as (service, fleet):
        fleet.send(report("fred").model_copy(update={"body": body}))
        assert received(service, 1)[0].body == body


def test_what_is_too_large_to_be_a_message_does_not_come_through_and_the_link_goes_on(
    broker: Mosquitto,
) -> None:
    with both(at(broker)) as (service, fleet):
        shout(broker, robot_topic(WORLD, "fred", Channel.STATE), b"x" * (MAX_PACKET_BYTES + 1))
        fleet.send(report("ginger"))
        (said,) = received(service, 1)
        assert said.sender == "ginger"
        assert (service.malformed, service.connected) == (0, True)


def factsheet(robot: str, **values: Any) -> Message:
    sheet = Factsheet(repertoire=("NAVIGATE",), speed_m_s=0.4, turn_rad_s=1.0, **values)
    return report(robot).model_copy(update={"body": sheet})


def test_a_factsheet_is_kept_by_the_broker_until_its_robot_is_removed(broker: Mosquitto) -> None:
    with a_fleet(at(broker)) as fleet:
        until(lambda: fleet.connected, "the fleet is connected")
        fleet.send(factsheet("fred", number=3))
        with a_service(at(broker)) as service:
            until(lambda: service.run == RUN, "the run is known")
            shout(broker, robot_topic(WORLD, "fred", Channel.STATE), b"no message")
            until(lambda: service.malformed == 1, "all that the broker has kept has come")
            assert service.receive() == ()
            service.take_up(RUN)
            (said,) = received(service, 1)
            assert (said.sender, said.body) == ("fred", factsheet("fred", number=3).body)
        with Watching(broker, robot_topic(WORLD, "fred", Channel.FACTSHEET)) as watching:
            until(lambda: len(watching.qos) == 1, "the broker has kept the factsheet")
            fleet.serve(["ginger"])
            until(lambda: len(watching.qos) == 2, "it is taken back")
        with a_service(at(broker)) as service:
            until(lambda: service.run == RUN, "the run is known")
            service.take_up(RUN)
            fleet.send(report("ginger"))
            (said,) = received(service, 1)
            assert (said.sender, service.malformed) == ("ginger", 0)


@pytest.mark.parametrize(
    ("robot", "payload"),
    [
        ("fred", b"{" + b" " * (MAX_FACTSHEET_BYTES + 2000)),
        ("fred", b"no factsheet"),
        ("Fred", b"{}"),
        ("x" * 65, b"{}"),
        ("fred", factsheet("ginger").model_dump_json().encode()),
        (
            "fred",
            factsheet("fred").model_dump_json().replace('"velocity"', '{"kind": NaN}').encode(),
        ),
    ],
)
def test_a_factsheet_that_is_too_large_or_malformed_is_counted_and_harms_nothing(
    broker: Mosquitto, robot: str, payload: bytes
) -> None:
    with both(at(broker)) as (service, fleet):
        shout(broker, robot_topic(WORLD, robot, Channel.FACTSHEET), payload)
        until(lambda: service.malformed == 1, "it is counted")
        fleet.send(factsheet("ginger"))
        (said,) = received(service, 1)
        assert said.sender == "ginger"


def test_a_link_that_was_never_started_leaves_nothing_open() -> None:
    opened = set(os.listdir("/proc/self/fd"))
    link = ServiceLink("lab", ["yard_1"], Broker.at("mqtt://127.0.0.1:1"))
    link.close()
    link.close()
    assert set(os.listdir("/proc/self/fd")) == opened
