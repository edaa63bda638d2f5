"""Simulations that the service runs itself, one process a world: of those given at its start and those added later."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, ClassVar

from app.domain.errors import Unavailable
from app.settings import Settings
from app.store.recorded_run import recorded_edition, recorded_run
from robots.world import WorldFile
from sim import SnapshotSettings, SupervisedWorld
from sim.error import SimulationError

if TYPE_CHECKING:
    from app.agents.running_world import RunningWorld
    from app.packs.pack_set import Packs


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationHost:
    """Starts simulations from their snapshots in the data folder; implements `WorldHost`.

    :param speed: world seconds per wall-clock second, of worlds for which no other rate is chosen.
    :param start_new: do not resume worlds from their snapshots.
    """

    settings: Settings
    packs: "Packs"
    speed: float
    seed: int
    start_new: bool = False
    simulates: ClassVar[bool] = True

    def start(
        self,
        world: WorldFile,
        *,
        tell: Callable[[str], None],
        rate: float | None = None,
    ) -> SupervisedWorld:
        """The simulation of a world, in a child process, paused.

        :raises SimulationError: if it cannot be built.
        """
        simulation = SupervisedWorld.start(
            world,
            self._snapshots(run=self._recorded_run(world)),
            seed=self.seed,
            speed=self.speed if rate is None else rate,
            jitter_m=0.0,
            edition=recorded_edition(self.settings.resolved_database_url(), world),
            packet_files=self.packs.packets,
            tell=tell,
        )
        simulation.pause()
        return simulation

    def open(self, file: WorldFile, *, rate: float | None) -> "RunningWorld":
        """The world, whose simulation is started in the background."""
        from app.agents.late_simulation import LateSimulation
        from app.agents.running_world import RunningWorld

        shown_s = self._snapshots(run=self._recorded_run(file)).shown_s(file)
        late = LateSimulation(file.name, partial(self._start_late, file, rate), began_s=shown_s)
        return RunningWorld(
            file=file,
            link=late,
            clock=late,
            rate=self.speed if rate is None else rate,
            run=None,
            late=late,
            close=late.close,
        )

    def _start_late(
        self, file: WorldFile, rate: float | None, tell: Callable[[str], None]
    ) -> SupervisedWorld:
        """:raises Unavailable: if the world cannot be built."""
        try:
            return self.start(file, tell=tell, rate=rate)
        except SimulationError as error:
            raise Unavailable(str(error), code="world-not-built") from error

    def forget(self, file: WorldFile) -> None:
        """Delete the world's snapshot."""
        path = self._snapshots().path_of(file)
        for suffix in (".json", ".new", ".clock", ".lock"):
            with suppress(OSError):
                path.with_suffix(suffix).unlink(missing_ok=True)

    def _recorded_run(self, world: WorldFile) -> str | None:
        return recorded_run(self.settings.resolved_database_url(), world.name) or None

    def _snapshots(self, *, run: str | None = None) -> SnapshotSettings:
        return SnapshotSettings(folder=self.settings.data / "worlds", run=run, start_new=self.start_new)
