"""A world that a fleet drives, as the commands that reach it over a broker see it."""

from collections.abc import Iterator
from contextlib import contextmanager

from app.cli.long_running import warn_if_open
from app.running import RunningWorld
from robots.link.mqtt import Broker, ServiceLink
from robots.world import WorldFile
from sim.snapshot import digest_of


@contextmanager
def over(broker: Broker, world: WorldFile) -> Iterator[RunningWorld]:
    """The world as a fleet drives it that is reached over a broker, there already or not."""
    warn_if_open(broker)
    fleet = ServiceLink(world.name, [robot.name for robot in world.robots], broker, digest=digest_of(world))
    try:
        yield RunningWorld(file=world, link=fleet, clock=fleet.clock, run=None, fleet=fleet)
    finally:
        fleet.close()
