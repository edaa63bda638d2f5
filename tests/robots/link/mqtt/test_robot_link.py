"""Robots with software of their own beside a fleet: they follow its run and time, and take part in its world."""

import time
from dataclasses import replace
from pathlib import Path

import pytest

from robots.contract.memory_file import counter_file
from robots.link.mqtt import Broker, ConnectionState, FleetLink, FollowingClock, RobotLink, ServiceLink
from robots.link.mqtt.reactor import Reactor
from robots.link.mqtt.service import Guard
from robots.link.mqtt.session import Publication, Session
from robots.link.mqtt.signature import OrderSigner, SignatureCheck
from robots.link.mqtt.topics import Channel, robot_topic
from robots.wire import Message, PacketReport
from tests.mosquitto import Mosquitto, needs_mosquitto
from tests.robots.link.mqtt.ends import WORLD, Board, a_service, received, report, script_request, telemetry
from tests.waiting import until

ROBOT = "ginger"


def fleet_of(broker: Mosquitto, run: str) -> FleetLink:
    return FleetLink(WORLD, ["fred"], Broker.at(broker.url), run=run)


@needs_mosquitto
def test_a_robot_follows_the_world_and_exchanges_messages_of_its_run(broker: Mosquitto) -> None:
    board = Board()
    robot = RobotLink(WORLD, [ROBOT], Broker.at(broker.url))
    fleet = fleet_of(broker, "run-1")
    with a_service(Broker.at(broker.url), board) as service:
        robot.start()
        robot.send(report(ROBOT))  # without a run there is nobody to hear it
        fleet.start()
        until(lambda: robot.run == "run-1" and service.run == "run-1", "the run is known")
        until(lambda: robot.connected and board.states.get(ROBOT) is ConnectionState.ONLINE, "it is online")
        service.take_up("run-1")
        fleet.announce(20.0, 1.0)
        until(lambda: robot.clock.now_s() >= 20.0, "it follows the world's time")
        service.send(script_request(ROBOT))
        (order,) = messages(robot)
        assert order.receiver == ROBOT
        robot.send(report(ROBOT, "p7"))
        (told,) = received(service, 1)
        assert isinstance(told.body, PacketReport)
        assert told.body.packet_id == "p7"
        tells = telemetry(ROBOT, 21.0)  # it is not kept: one may be dropped
        until(lambda: robot.send(tells) or (ROBOT, 21.0) in board.telemetry, "its telemetry arrives")
        fleet.close()
        begins_anew(broker, service, robot)
        robot.close()
        until(lambda: board.states[ROBOT] is ConnectionState.OFFLINE, "it said that it goes")


class KeyGuard(Guard):
    """Admits what the robot has signed."""

    def __init__(self, key: str) -> None:
        self._key = key
        self._check = SignatureCheck()
        self.refused = 0

    def admits(self, robot: str, publication: Publication) -> bool:
        doubt = self._check.doubt(publication, self._key) if robot == ROBOT else ""
        self.refused += bool(doubt)
        return not doubt


@needs_mosquitto
def test_a_robot_with_a_key_signs_and_takes_only_signed_orders(
    broker: Mosquitto, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    at = Broker.at(broker.url)
    keys = {ROBOT: "a-key"}
    counters = {ROBOT: counter_file(tmp_path / "memory.json")}
    service, impostor = (ServiceLink(WORLD, [ROBOT], at) for _ in range(2))
    guard = KeyGuard("a-key")
    service.guard(guard)
    board = Board()
    service.listen(board)
    service.sign_orders(OrderSigner(lambda: keys))
    heard: list[Publication] = []
    topics = [(robot_topic(WORLD, ROBOT, channel), 1) for channel in (Channel.ORDER, Channel.INSTANT_ACTIONS)]
    listener = Session(at, "somebody", subscriptions=topics, on_arrival=heard.append)
    reactor = Reactor([listener], broker=broker.url)
    robot = RobotLink(WORLD, [ROBOT], at, keys=keys, counters=counters)
    fleet = fleet_of(broker, "run-1")
    for end in (service, impostor, fleet, robot, reactor):
        end.start()
    try:
        until(lambda: robot.run == service.run == impostor.run == "run-1" and robot.connected)
        until(lambda: listener.connected and board.states.get(ROBOT) is ConnectionState.ONLINE)
        service.take_up("run-1")
        impostor.take_up("run-1")
        robot.send(report(ROBOT, "p7"))
        assert len(received(service, 1)) == 1
        service.send(script_request(ROBOT))
        assert len(messages(robot)) == 1
        until(lambda: len(heard) == 1)
        recorded = heard[0]
        impostor.send(script_request(ROBOT))
        listener.publish(replace(recorded, payload=recorded.payload.replace(b"door", b"gate")))
        listener.publish(recorded)
        until(lambda: robot.doubted[ROBOT] == 3)
        assert caplog.text.count("was ignored") == 1
        robot.close()
        until(lambda: board.states[ROBOT] is ConnectionState.OFFLINE)
        robot = RobotLink(WORLD, [ROBOT], at, keys=keys, counters=counters)
        robot.start()
        until(lambda: robot.run == "run-1" and board.states[ROBOT] is ConnectionState.ONLINE)
        listener.publish(recorded)
        until(lambda: robot.doubted[ROBOT] == 1)
        assert not robot.receive()
        service.sign_orders(OrderSigner(lambda: keys, epoch_ns=lambda: time.time_ns() + 6 * 10**9))
        service.send(script_request(ROBOT))
        assert len(messages(robot)) == 1
        assert guard.refused == 0
    finally:
        for one in (robot, fleet, impostor, service, reactor):
            one.close()


def begins_anew(broker: Mosquitto, service: ServiceLink, robot: RobotLink) -> None:
    """The world is started again: orders of the earlier run no longer pass."""
    fleet = fleet_of(broker, "run-2")
    fleet.start()
    until(lambda: robot.run == "run-2", "the new run is known")
    service.send(script_request(ROBOT))  # of run-1
    until(lambda: service.run == "run-2", "the service knows it, too")
    service.take_up("run-2")
    service.send(script_request(ROBOT))
    assert len(messages(robot)) == 1
    fleet.close()


def messages(robot: RobotLink) -> list[Message]:
    came: list[Message] = []
    until(lambda: bool(came.extend(robot.receive(0.05)) or came), "a message comes")
    return came


def test_the_clock_of_a_robot_runs_on_in_radio_silence() -> None:
    wall = [0.0]
    clock = FollowingClock(lambda: wall[0], extrapolated_s=float("inf"))
    clock.set("run-1", 10.0, 2.0, running=True)
    wall[0] = 100.0
    assert clock.now_s() == 210.0


def test_a_link_for_no_robot_is_an_error() -> None:
    with pytest.raises(ValueError, match="at least one robot"):
        RobotLink(WORLD, [], Broker.at("mqtt://127.0.0.1:1"))
