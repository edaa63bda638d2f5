"""`macta fleet`: simulates a world and its robots behind a broker."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from app.cli.background import background_compilation
from app.cli.long_running import end_signal, log_warnings, report_new_run, warn_of_broker
from app.cli.settings import settings_of
from app.domain.errors import Invalid, Unavailable
from app.packs.find import load_packs
from robots.link.channel import LinkClosed
from robots.link.mqtt import Broker, FleetLink
from robots.link.transport import FleetEnd, ServesRobots, Transport
from robots.wire import Message, Performative, WorldChange, WorldEdition
from robots.world import WorldFile, digest_of
from sim import SnapshotSettings, SupervisedWorld
from sim.process.first_calls import SIMULATION

TURN_S = 0.02
"""How long each turn waits for messages from the robots; messages to them may be delayed by it."""


def fleet(
    world: WorldFile, speed: float, seed: int, given: Mapping[str, Any], *, start_new: bool = False
) -> None:
    """Simulate the world until SIGINT or SIGTERM, starting from its snapshot in the data folder.

    :param start_new: start the world again instead of from its snapshot.
    :raises Invalid: if no broker is set, or it refuses the fleet.
    :raises Unavailable: if another fleet drives the world, or the simulation has ended.
    """
    settings = settings_of(given)
    packs = load_packs(settings.packs)
    broker = settings.broker()
    if broker is None:
        raise Invalid("--broker: set the broker's address, mqtt://HOST[:PORT] or mqtts://HOST[:PORT]")
    log_warnings()
    warn_of_broker(broker)
    snapshots = SnapshotSettings(folder=settings.data / "worlds", any_run=True, start_new=start_new)
    with (
        end_signal() as ending,
        background_compilation((SIMULATION,)) as compilation,
        SupervisedWorld.start(
            world, snapshots, seed=seed, speed=speed, jitter_m=0.0, packet_files=packs.packets
        ) as simulation,
        _at(broker, world, simulation, packs.digests()) as link,
    ):
        if simulation.not_resumed_because:
            report_new_run(world.name, simulation.not_resumed_because)
        compilation.start()
        relay = _Relay(world, simulation, link, broker, speed)
        while not ending.is_set():
            relay.turn()


class _Relay:
    """Passes messages between the simulation's process and the broker."""

    def __init__(
        self,
        world: WorldFile,
        simulation: SupervisedWorld,
        link: FleetEnd,
        broker: Broker | Transport,
        speed: float,
    ) -> None:
        self._world = world
        self._simulation = simulation
        self._link = link
        self._broker = broker
        self._speed = speed
        self._is_ready = False
        self._asked: dict[str, list[str]] = {}
        """By request to change the world, the robots that it has then."""

    def turn(self) -> None:
        """Pass on the messages of one turn."""
        try:
            for message in self._simulation.receive(TURN_S):
                self._note_answer(message)
                self._link.send(message)
            for message in self._link.receive():
                if isinstance(message.body, WorldChange):
                    self._asked[message.id] = [
                        robot["name"]
                        for robot in message.body.world["robots"]
                        if not robot.get("external", False)
                    ]
                self._simulation.send(message)
        except LinkClosed as error:
            raise Unavailable(f"world {self._world.name} cannot continue: {error}") from error
        self._link.announce(self._simulation.now_s(), self._speed)
        if self._link.superseded:
            raise Unavailable(
                f"another fleet took over world {self._world.name} on broker {self._broker}; this one ends"
            )
        if not self._is_ready:
            self._get_ready()

    def _note_answer(self, message: Message) -> None:
        """Speak for the robots of a changed world once the simulation has taken it up."""
        if not isinstance(message.body, WorldEdition):
            return
        robots = self._asked.pop(message.in_reply_to or "", None)
        is_taken_up = message.performative is Performative.AGREE
        if robots is not None and is_taken_up and isinstance(self._link, ServesRobots):
            self._link.serve(robots)

    def _get_ready(self) -> None:
        if self._link.refused:
            # NOTE: only at the start: a broker that restarts later may refuse for a while.
            raise Invalid(
                f"broker {self._broker} {self._link.complaint}; see MACTA_BROKER_USERNAME, …_PASSWORD"
            )
        if self._link.connected:
            self._is_ready = True
            robots = len(self._simulation.robots)
            # NOTE: plain print: rich would break the line at the terminal's width.
            print(f"The fleet of {self._world.name} is ready: {robots} robots at {self._broker}", flush=True)


@contextmanager
def _at(
    broker: Broker | Transport, world: WorldFile, simulation: SupervisedWorld, packs: Mapping[str, str]
) -> Iterator[FleetEnd]:
    robots = simulation.robots
    run = simulation.run
    link: FleetEnd
    if isinstance(broker, Broker):
        link = FleetLink(world.name, robots, broker, run=run, digest=digest_of(world), packs=packs)
    else:
        link = broker.fleet_end(world.name, robots, run=run, digest=digest_of(world))
    link.start()
    try:
        yield link
    finally:
        link.close()
