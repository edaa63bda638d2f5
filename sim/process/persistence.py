"""Resumes a world from its snapshot, and commits its output: messages leave only after a snapshot contains them.

So whatever a receiver hears from a world is also true of the world resumed from its snapshot. Telemetry is exempt:
nothing is based on it.
"""

import logging
from dataclasses import dataclass
from math import inf

from robots.clock import Clock
from robots.world import Edition, WorldFile
from sim.error import NotResumable
from sim.process.snapshot_file import SnapshotFile, SnapshotSettings
from sim.world.agent import AgentFactory
from sim.world.hub import Hub
from sim.world.simulation import Simulation

MAX_INTERVAL_S = 1.0
"""Wall-clock time after which a snapshot is taken even if no message waits."""
RESTING_INTERVAL_S = 5.0
"""The same while no robot moves: little is lost then."""
MAX_SHARE = 0.1
"""Share of the wall-clock time that snapshots may take, by the quicker of the last two; messages sent meanwhile leave
with the next one."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class StartedWorld:
    """A world, whether it was resumed from its snapshot, and if one was expected, why not."""

    simulation: Simulation
    is_resumed: bool
    not_resumed_because: str = ""


def resume_or_start(
    world: WorldFile,
    settings: SnapshotSettings,
    file: SnapshotFile,
    hub: Hub,
    *,
    make_agent: AgentFactory,
    seed: int,
    jitter_m: float,
    edition: Edition | None = None,
    processes: int = 1,
) -> StartedWorld:
    """The world from its snapshot; else a new one by the seed.

    :param edition: as of which it is to go on, or to begin.
    :param processes: how many the agents are spread over.
    :raises NotResumable: if it cannot be resumed and must not be started new.
    """
    try:
        return StartedWorld(_resumed(world, settings, file, hub, make_agent, edition, processes), True)
    except NotResumable as reason:
        if settings.resume_only:
            raise
        expected = settings.run is not None or settings.path_of(world).exists()
        simulation = Simulation(
            world,
            make_agent=make_agent,
            seed=seed,
            jitter_m=jitter_m,
            hub=hub,
            edition=edition,
            processes=processes,
        )
        file.write_clock(0.0)
        return StartedWorld(simulation, False, str(reason) if expected else "")


def _resumed(
    world: WorldFile,
    settings: SnapshotSettings,
    file: SnapshotFile,
    hub: Hub,
    make_agent: AgentFactory,
    edition: Edition | None,
    processes: int,
) -> Simulation:
    if settings.start_new:
        raise NotResumable("an operator wished it so")
    snapshot = file.read(world)
    if snapshot.run != settings.run and not settings.any_run:
        raise NotResumable("its snapshot is of a run that the record does not tell of")
    try:
        return Simulation(
            world, make_agent=make_agent, hub=hub, snapshot=snapshot, edition=edition, processes=processes
        )
    except Exception as error:  # a snapshot of other software may fail anywhere
        raise NotResumable(f"its snapshot does not fit: {type(error).__name__}: {error}") from error


class OutputCommit:
    """Takes the snapshots of a world whose hub holds messages until they are committed."""

    def __init__(self, simulation: Simulation, file: SnapshotFile, wall_clock: Clock) -> None:
        self._simulation = simulation
        self._file = file
        self._wall_clock = wall_clock
        self._earliest_s = wall_clock.now_s()
        self._started_s = -inf
        self._last_took_s = 0.0
        self._failed = False

    def take_if_due(self, *, at_rest: bool = False) -> None:
        """Between two ticks: take a snapshot if a message waits for it, or the last one is old.

        :param at_rest: nothing but telemetry is sent or received, and no robot moves.
        """
        now_s = self._wall_clock.now_s()
        interval_s = RESTING_INTERVAL_S if at_rest else MAX_INTERVAL_S
        is_old = now_s >= self._started_s + interval_s
        if now_s >= self._earliest_s and (is_old or self._simulation.hub.is_holding):
            self.take()

    def take(self) -> None:
        """Take a snapshot, then release the messages so far. If it cannot be written, they wait."""
        started_s = self._wall_clock.now_s()
        self._started_s = started_s
        try:
            self._file.write(self._simulation.snapshot())
        except OSError as error:
            if not self._failed:
                world = self._simulation.world.name
                logger.error(
                    "cannot store the snapshot of world %s: %s; its robots' messages wait", world, error
                )
            self._failed = True
            self._earliest_s = started_s + MAX_INTERVAL_S
            return
        self._failed = False
        self._simulation.hub.release()
        self._simulation.hub.flush(self._simulation.clock.now_s())
        done_s = self._wall_clock.now_s()
        took_s = done_s - started_s
        # A single one that took long, for the disk or the processor stood still, holds up no messages.
        self._earliest_s = done_s + min(took_s, self._last_took_s) * (1 / MAX_SHARE - 1)
        self._last_took_s = took_s
