"""Records the run of a world whose fleet starts by itself, before messages are exchanged with its robots."""

from collections.abc import Callable, Mapping
from typing import Protocol, runtime_checkable

from app.core import Core
from app.missions.world_start import start_world_run
from app.planning.waiting_goals import WaitingGoals
from app.store import WorldRow
from robots.world import WorldFile


class Fleet(Protocol):
    """The process that drives a world's robots, at the other end of their link."""

    @property
    def run(self) -> str | None:
        """The run of the world that it drives, None before it was announced."""
        ...

    @property
    def taken_up(self) -> str | None:
        """The run that messages are exchanged with."""
        ...

    def take_up(self, run: str) -> None: ...


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
        fleet: Fleet,
        *,
        waiting: WaitingGoals,
        holds_lease: Callable[[], bool] = lambda: True,
    ) -> None:
        """
        :param worlds: the newest edition of each. :param world: the fleet's.
        :param holds_lease: True while this process, of those that share the database, is the one that drives the world.
        """
        self._core = core
        self._worlds = worlds
        self._world = world
        self._fleet = fleet
        self._waiting = waiting
        self._holds_lease = holds_lease

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
            if not start_world_run(session, self._core, self._worlds[self._world], run):
                self._waiting.release(session, self._world)

    def _is_recorded(self, run: str) -> bool:
        with self._core.database.read() as session:
            row = session.get(WorldRow, self._world)
            return row is not None and row.run == run
