"""Both ends of a world's link over a broker, and what passes between them."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from robots.link.mqtt import Broker, ConnectionState, FleetLink, ServiceLink
from robots.wire import (
    BehaviourPacket,
    BehaviourScript,
    Body,
    Control,
    ControlVerb,
    Message,
    PacketReport,
    PacketState,
    Performative,
    ScriptRequest,
    Telemetry,
)
from tests.waiting import until

WORLD, ROBOTS, RUN = "hall", ("fred", "ginger"), "run-1"


@dataclass
class Board:
    """What the service's listener was told."""

    telemetry: list[tuple[str, float]] = field(default_factory=list)
    states: dict[str, ConnectionState] = field(default_factory=dict)
    remembered: set[str] = field(default_factory=set)

    def heard(self, robot: str, telemetry: Telemetry) -> None:
        self.telemetry.append((robot, telemetry.at_s))

    def connected(self, robot: str, state: ConnectionState, *, now: bool) -> None:
        self.states[robot] = state
        if not now:
            self.remembered.add(robot)

    def are_all(self, state: ConnectionState) -> bool:
        return self.states == dict.fromkeys(ROBOTS, state)


@contextmanager
def a_fleet(
    broker: Broker, *, run: str = RUN, digest: str = "", epoch_s: Callable[[], float] = time.time
) -> Iterator[FleetLink]:
    fleet = FleetLink(WORLD, ROBOTS, broker, run=run, digest=digest, epoch_s=epoch_s)
    fleet.start()
    try:
        yield fleet
    finally:
        fleet.close()


@contextmanager
def a_service(
    broker: Broker,
    board: Board | None = None,
    *,
    digest: str = "",
    wall_s: Callable[[], float] = time.monotonic,
) -> Iterator[ServiceLink]:
    service = ServiceLink(WORLD, ROBOTS, broker, digest=digest, wall_s=wall_s)
    service.listen(board or Board())
    service.start()
    try:
        yield service
    finally:
        service.close()


@contextmanager
def both(broker: Broker, board: Board | None = None) -> Iterator[tuple[ServiceLink, FleetLink]]:
    """The two ends, connected, with the fleet's run taken up."""
    board = board or Board()
    with a_service(broker, board) as service, a_fleet(broker) as fleet:
        until(lambda: service.run == RUN and fleet.connected, "fleet and service meet")
        # A robot has subscribed to its orders before it says that it is online.
        until(lambda: board.are_all(ConnectionState.ONLINE), "all robots are online")
        service.take_up(RUN)
        yield service, fleet


def to_robot(robot: str, body: Body | None = None) -> Message:
    return Message(
        performative=Performative.REQUEST,
        sender="service",
        receiver=robot,
        sent_at_s=0,
        body=body or Control(script_id="s", verb=ControlVerb.PAUSE, number=3),
    )


def report(robot: str, packet: str = "p") -> Message:
    return _from(robot, PacketReport(script_id="s", packet_id=packet, state=PacketState.RUNNING, at_s=1))


def telemetry(robot: str, at_s: float) -> Message:
    return _from(robot, Telemetry(at_s=at_s, x_m=1, y_m=2, heading_rad=0))


def _from(robot: str, body: Body) -> Message:
    return Message(performative=Performative.INFORM, sender=robot, receiver="service", sent_at_s=1, body=body)


def script_request(robot: str) -> Message:
    packet = BehaviourPacket(
        id="a1",
        tag="NAVIGATE",
        arguments={"ref2": "door"},
        expected_start_s=0,
        expected_duration_s=10,
        timeout_s=60,
        wait_timeout_s=60,
    )
    script = BehaviourScript(id=f"s-{robot}", mission_id="m", robot=robot, packets=(packet,))
    return to_robot(robot, ScriptRequest(script=script))


def received(end: ServiceLink | FleetLink, count: int) -> list[Message]:
    """The next messages, so many of them at least."""
    came: list[Message] = []

    def enough() -> bool:
        came.extend(end.receive(0.05))
        return len(came) >= count

    until(enough, f"{count} messages come")
    return came
