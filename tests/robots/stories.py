"""A rectangle with a hatch, scripts for it, and a service that listens: what the tests of the agent share."""

from collections.abc import Callable, Iterable
from math import pi

from robots.link import InMemoryLink
from robots.physical.profile import BeaconSpec
from robots.wire import (
    BehaviourPacket,
    BehaviourScript,
    Message,
    PacketReport,
    PacketState,
    Performative,
    Receipt,
    ScriptReport,
    ScriptRequest,
    SymbolicFact,
    Telemetry,
    UpkeepReport,
)
from robots.wire import Body as Content
from tests.robots.fake_world import FakeWorld, Segment

EAST, NORTH, WEST, SOUTH = 0.0, pi / 2, pi, -pi / 2


def room(samples: dict[str, complex] | None = None, *, seed: int = 0, noise: float = 1.0) -> FakeWorld:
    """Two halls, 6 m by 3 m each, with a hatch at (3, 3); a door in the south, a bay in the north."""
    corners = [0j, 6 + 0j, 6 + 6j, 6j]
    walls: list[Segment] = [
        *zip(corners, corners[1:] + corners[:1], strict=True),
        (3j, 2.8 + 3j),
        (3.2 + 3j, 6 + 3j),
    ]
    beacons = {
        "door": BeaconSpec(x_m=1, y_m=0.4, approach_rad=(NORTH,)),
        "hatch": BeaconSpec(x_m=3, y_m=3, approach_rad=(NORTH, SOUTH)),
        "bay": BeaconSpec(x_m=5.5, y_m=4.6, approach_rad=(WEST,)),
        "yard": BeaconSpec(x_m=5.4, y_m=1.2, approach_rad=(WEST,)),
    }
    return FakeWorld(walls=walls, beacons=beacons, samples=samples or {}, seed=seed, noise=noise)


def fact(text: str) -> SymbolicFact:
    """`in(o, l)` as a fact."""
    predicate, _, rest = text.partition("(")
    return SymbolicFact(predicate=predicate, args=tuple(rest.rstrip(")").split(", ")))


def packet(
    tag: str,
    *,
    awaits: Iterable[str] = (),
    after: Iterable[str] = (),
    timeout_s: float = 60,
    wait_timeout_s: float = 120,
    **arguments: str,
) -> BehaviourPacket:
    return BehaviourPacket(
        id=f"{tag}-{'-'.join(arguments.values())}",
        tag=tag,
        arguments=arguments,
        awaits=tuple(map(fact, awaits)),
        after=tuple(after),
        expected_start_s=0,
        expected_duration_s=10,
        timeout_s=timeout_s,
        wait_timeout_s=wait_timeout_s,
    )


def script(robot: str, *packets: BehaviourPacket, name: str = "") -> BehaviourScript:
    return BehaviourScript(id=name or f"script-{robot}", mission_id="mission", robot=robot, packets=packets)


def carry(robot: str, item: str, start: str, goal: str, awaits: Iterable[str] = ()) -> BehaviourScript:
    """Fetch an item and bring it somewhere."""
    return script(
        robot,
        packet("NAVIGATE", ref1="nowhere", ref2=start),
        packet("DOCK", object=item, ref1=start, awaits=awaits),
        packet("TRANSPORT", object=item, ref1=start, ref2=goal),
        packet("RELEASE2", object=item, ref1=start, ref2=goal),
    )


class Service:
    """The other end of a robot's link. It sends receipts unless told not to."""

    def __init__(self, world: FakeWorld, link: InMemoryLink, robot: str, *, receipts: bool = True) -> None:
        self.world, self.link, self.robot, self.receipts = world, link, robot, receipts
        self.heard: list[Message] = []

    def send(self, body: Content, performative: Performative = Performative.REQUEST, **slots: str) -> Message:
        message = Message(
            performative=performative,
            sender="service",
            receiver=self.robot,
            sent_at_s=self.world.clock.now_s(),
            body=body,
            **slots,
        )
        self.link.send(message)
        return message

    def order(self, script: BehaviourScript) -> Message:
        return self.send(ScriptRequest(script=script))

    def listen(self) -> None:
        for message in self.link.receive():
            self.heard.append(message)
            if self.receipts and isinstance(message.body, PacketReport | ScriptReport | UpkeepReport):
                self.send(Receipt(), Performative.CONFIRM, in_reply_to=message.id)

    @property
    def report(self) -> ScriptReport | None:
        """How the script ended, once it has."""
        return next((m.body for m in self.heard if isinstance(m.body, ScriptReport)), None)

    @property
    def packets(self) -> list[tuple[str, PacketState]]:
        """Tag and state of every packet report, each once."""
        reports = {m.id: m.body for m in self.heard if isinstance(m.body, PacketReport)}
        return [(body.packet_id.partition("-")[0], body.state) for body in reports.values()]

    @property
    def upkeep(self) -> list[UpkeepReport]:
        """What it did for its own sake, each report once."""
        return list({m.id: m.body for m in self.heard if isinstance(m.body, UpkeepReport)}.values())

    @property
    def telemetry(self) -> list[Telemetry]:
        return [m.body for m in self.heard if isinstance(m.body, Telemetry)]


def run(
    world: FakeWorld, services: Iterable[Service], until: Callable[[], bool], *, limit_s: float = 150
) -> bool:
    """Tick until something is true; False if it did not become true in time."""
    services = list(services)
    end_s = world.clock.now_s() + limit_s
    while not until():
        if world.clock.now_s() >= end_s:
            return False
        world.tick()
        for service in services:
            service.listen()
    return True


def run_for(world: FakeWorld, services: Iterable[Service], time_s: float) -> None:
    run(world, services, lambda: False, limit_s=time_s)
