"""`macta fleet`: a world's simulation and its robots, reached over a broker. Ends in order when told to."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from app.cli.long_running import log_warnings, tell_why_afresh, told_to_end, warn_if_open
from app.cli.settings import settings_of
from app.domain.errors import Invalid, Unavailable
from robots.link.channel import LinkClosed
from robots.link.mqtt import Broker, FleetLink
from robots.world import WorldFile
from sim import Keep, LastingWorld
from sim.snapshot import digest_of

TURN_S = 0.02
"""How long a message to the robots may wait for one from them."""


def fleet(
    world: WorldFile, speed: float, seed: int, given: Mapping[str, Any], *, afresh: bool = False
) -> None:
    """Run until interrupted or terminated. The world goes on from where it is kept in the data folder.

    :param afresh: build the world anew, though it might go on.
    :raises Invalid: if no broker is named, or it does not let the fleet in.
    :raises Unavailable: if another fleet drives the world, or the world cannot go on.
    """
    settings = settings_of(given)
    broker = settings.broker()
    if broker is None:
        raise Invalid("--broker: say where the broker is, as mqtt://HOST[:PORT] or mqtts://HOST[:PORT]")
    log_warnings()
    warn_if_open(broker)
    keep = Keep(folder=settings.data / "worlds", any_run=True, afresh=afresh)
    with (
        told_to_end() as ending,
        LastingWorld.start(world, keep, seed=seed, speed=speed, jitter_m=0.0) as simulation,
        _at(broker, world, simulation.run) as link,
    ):
        if simulation.why_afresh:
            tell_why_afresh(world.name, simulation.why_afresh)
        relay = _Relay(world, simulation, link, broker, speed)
        while not ending.is_set():
            relay.turn()


class _Relay:
    """Between the simulation's process and the broker: the robots' words out, what is said to them in."""

    def __init__(
        self, world: WorldFile, simulation: LastingWorld, link: FleetLink, broker: Broker, speed: float
    ) -> None:
        self._world, self._simulation, self._link = world, simulation, link
        self._broker, self._speed = broker, speed
        self._is_ready = False

    def turn(self) -> None:
        """Pass on what there is, waiting a moment for the robots."""
        try:
            for message in self._simulation.receive(TURN_S):
                self._link.send(message)
            for message in self._link.receive():
                self._simulation.send(message)
        except LinkClosed as error:
            raise Unavailable(f"world {self._world.name} cannot go on: {error}") from error
        self._link.announce(self._simulation.now_s(), self._speed)
        if self._link.superseded:
            raise Unavailable(
                f"another fleet drives world {self._world.name} at {self._broker}; this one ends"
            )
        if not self._is_ready:
            self._get_ready()

    def _get_ready(self) -> None:
        if self._link.refused:
            # NOTE: only at the start: a broker that is about to be set up anew may refuse for a while.
            raise Invalid(
                f"broker {self._broker} {self._link.complaint}; see MACTA_BROKER_USERNAME, …_PASSWORD"
            )
        if self._link.connected:
            self._is_ready = True
            robots = len(self._world.robots)
            # NOTE: plain print: a terminal's width must not break the line.
            print(f"The fleet of {self._world.name} is ready: {robots} robots at {self._broker}", flush=True)


@contextmanager
def _at(broker: Broker, world: WorldFile, run: str) -> Iterator[FleetLink]:
    link = FleetLink(world.name, [r.name for r in world.robots], broker, run=run, digest=digest_of(world))
    link.start()
    try:
        yield link
    finally:
        link.close()
