"""Shared parts of the commands that run until they are signalled to end."""

import logging
import signal
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, TypeVar

from rich.console import Console
from rich.markup import escape

from robots.link.mqtt import Broker, ServiceLink
from robots.link.transport import ServiceEnd, Transport
from robots.world import WorldFile, digest_of

if TYPE_CHECKING:
    from app.agents.running_world import RunningWorld

T = TypeVar("T")


def log_warnings() -> None:
    """Log warnings of all modules to standard error."""
    logging.basicConfig(level=logging.WARNING, format="%(asctime)s %(levelname)s %(name)s: %(message)s")


@contextmanager
def end_signal() -> Iterator[threading.Event]:
    """An event that SIGINT and SIGTERM set within the block."""
    ending = threading.Event()
    before = {
        number: signal.signal(number, lambda *_: ending.set()) for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield ending
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def enter_all(blocks: Iterable[AbstractContextManager[T]]) -> Iterator[Sequence[T]]:
    """Enter the context managers one after the other; leave all at the end of the block."""
    with ExitStack() as entered:
        yield [entered.enter_context(block) for block in blocks]


@contextmanager
def fleet_over_broker(broker: Broker | Transport, world: WorldFile) -> Iterator[ServiceEnd]:
    """The link to the world's fleet, which may start later."""
    fleet = _fleet_end(broker, world)
    try:
        yield fleet
    finally:
        fleet.close()


def _fleet_end(broker: Broker | Transport, world: WorldFile) -> ServiceEnd:
    robots = [robot.name for robot in world.robots]
    if isinstance(broker, Broker):
        return ServiceLink(world.name, robots, broker, digest=digest_of(world))
    return broker.service_end(world.name, robots, digest=digest_of(world))


@contextmanager
def world_over_broker(
    broker: Broker | Transport, world: WorldFile, *, start_new: bool = False
) -> "Iterator[RunningWorld]":
    """A world that its fleet drives, reached over a broker.

    :param start_new: start a new run if it has no fleet, and the service announces it.
    """
    from app.agents.running_world import RunningWorld

    with fleet_over_broker(broker, world) as fleet:
        yield RunningWorld(
            file=world, link=fleet, clock=fleet.clock, run=None, fleet=fleet, start_new=start_new
        )


@dataclass(frozen=True, slots=True)
class FleetHost:
    """Has worlds that are added driven by their fleets, over a broker; implements `WorldHost`."""

    broker: Broker | Transport
    simulates: ClassVar[bool] = False

    def open(self, file: WorldFile, *, rate: float | None) -> "RunningWorld":
        """:param rate: chosen by the fleet, so unused."""
        from app.agents.running_world import RunningWorld

        fleet = _fleet_end(self.broker, file)
        return RunningWorld(
            file=file, link=fleet, clock=fleet.clock, run=None, fleet=fleet, close=fleet.close
        )

    def forget(self, file: WorldFile) -> None:
        """Nothing is kept here: the fleet has its own snapshots."""


def warn_of_broker(broker: Broker | Transport | None) -> None:
    """Warn if others could impersonate robots or read the password; a package's link is its own affair."""
    if not isinstance(broker, Broker):
        return
    if broker.is_anonymous and not broker.is_on_loopback:
        _warn(
            f"{broker} accepts anonymous clients, which can impersonate any robot: give it passwords, and set"
            " MACTA_BROKER_USERNAME and MACTA_BROKER_PASSWORD (docs/production.md)"
        )
    if broker.password is not None and not broker.is_private:
        _warn(f"{broker} is not encrypted: the password can be read in transit; use mqtts://")


def _warn(text: str) -> None:
    Console(stderr=True).print(f"[yellow]{escape(text)}[/]", soft_wrap=True)


def report_new_run(world: str, why: str) -> None:
    """Print why a world starts a new run instead of resuming its snapshot."""
    Console(stderr=True).print(f"World {world} starts a new run: {escape(why)}.", soft_wrap=True)
