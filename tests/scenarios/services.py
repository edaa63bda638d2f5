"""A whole service in the test's own process, for scenarios in which it lives on: its robots are in other processes."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from app.cli.long_running import world_over_broker
from app.composition import RunningWorld, Service
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from robots.link.mqtt import Broker
from robots.world import WorldFile, load_world
from sim import SimulationProcess

TOKEN = "a-token-for-the-scenario"
AUTHORISED = {"authorization": f"Bearer {TOKEN}"}


@contextmanager
def over_pipe(
    data: Path, worker: PlanningWorker, *, speed: float | None, world: str | WorldFile = "sample_store"
) -> Iterator[Service]:
    """The world is simulated by a child process.

    :param speed: world seconds per wall-clock second; None: as fast as possible.
    """
    file = load_world(world) if isinstance(world, str) else world
    with SimulationProcess.start(file, speed=speed, jitter_m=0.0) as simulation:
        running = RunningWorld(
            file=file, link=simulation.link, clock=simulation, rate=speed, run=simulation.run
        )
        with Service(settings(data), [running], worker=worker) as service:
            yield service


@contextmanager
def over_broker(
    data: Path, worker: PlanningWorker, broker_url: str, *, world: str = "sample_store"
) -> Iterator[Service]:
    """The world is a fleet's, which comes and goes by itself."""
    with (
        world_over_broker(Broker.at(broker_url), load_world(world)) as running,
        Service(settings(data), [running], worker=worker) as service,
    ):
        yield service


def settings(data: Path) -> Settings:
    return Settings(data=data, token=TOKEN, database_url=None)
