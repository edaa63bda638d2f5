"""Records the run of a world whose fleet or simulation starts by itself, before messages are exchanged with it."""

from collections.abc import Callable, Mapping
from typing import Protocol, runtime_checkable

from app.agents.running_world import Driver
from app.core import Core
from app.missions.world_start import start_world_run
from app.planning.waiting_goals import WaitingGoals
from app.store import WorldRow
from robots.world import WorldFile


@runtime_checkable
class DeclaresPacks(Protocol):
    """A fleet that tells its domain packs; those of packages' links need not."""

    @property
    def packs(self) -> Mapping[str, str]:
        """Their digests by name; empty before it has told them."""
        ...


class FleetRun:
    """Records each run that a world's fleet drives, then lets messages to and from its robots pass."""

    def __init__(
        self,
        core: Core,
        worlds: Mapping[str, WorldFile],
        world: str,
        fleet: Driver,
        *,
        waiting: WaitingGoals,
        holds_lease: Callable[[], bool] = lambda: True,
        new_run_reason: Callable[[], str] = lambda: "",
    ) -> None:
        """
        :param worlds: the newest edition of each. :param world: the fleet's.
        :param new_run_reason: why it drives a new run, if an earlier one might have been resumed.
        :param holds_lease: True while this process, of those that share the database, is the one that drives the world.
        """
        self._core = core
        self._worlds = worlds
        self._world = world
        self._fleet = fleet
        self._waiting = waiting
        self._holds_lease = holds_lease
        self._new_run_reason = new_run_reason

    def follow(self) -> None:
        """Record the fleet's run if it has changed, and exchange messages with it. Called often; cheap if unchanged."""
        run = self._fleet.run
        if run is None or run == self._fleet.taken_up:
            return
        if self._holds_lease():
            self._start(run)
        elif not self._is_recorded(run):
            return
        self._fleet.take_up(run)

    def _start(self, run: str) -> None:
        with self._core.database.write() as session:
            world = self._worlds[self._world]
            why_new = self._new_run_reason()
            if not start_world_run(session, self._core, world, run, new_run_reason=why_new):
                self._waiting.release(session, self._world)

    def _is_recorded(self, run: str) -> bool:
        with self._core.database.read() as session:
            row = session.get(WorldRow, self._world)
            return row is not None and row.run == run
