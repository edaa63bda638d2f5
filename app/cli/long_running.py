"""Shared parts of the commands that run until they are signalled to end."""

import logging
import signal
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import TypeVar

from rich.console import Console
from rich.markup import escape

from app.agents.running_world import RunningWorld
from robots.link.mqtt import Broker, ServiceLink
from robots.world import WorldFile
from sim.snapshot import digest_of

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
def world_over_broker(broker: Broker, world: WorldFile) -> Iterator[RunningWorld]:
    """The world as its fleet drives it, reached over a broker; the fleet may come later."""
    warn_if_unencrypted(broker)
    fleet = ServiceLink(world.name, [robot.name for robot in world.robots], broker, digest=digest_of(world))
    try:
        yield RunningWorld(file=world, link=fleet, clock=fleet.clock, run=None, fleet=fleet)
    finally:
        fleet.close()


def warn_if_unencrypted(broker: Broker) -> None:
    """Warn that a password is sent in clear text."""
    if broker.password is not None and not broker.is_private:
        Console(stderr=True).print(
            f"[yellow]{escape(str(broker))} is not encrypted: the password can be read on its way; say mqtts://[/]"
        )


def report_new_run(world: str, why: str) -> None:
    """Say why a world starts again instead of going on from its snapshot."""
    Console(stderr=True).print(f"World {world} begins afresh: {escape(why)}.", soft_wrap=True)
