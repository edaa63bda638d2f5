"""A world whose fleet comes and goes by itself: each run it proclaims is met before its robots are spoken with."""

from collections.abc import Callable
from typing import Protocol

from app.core import Core
from app.missions.world_start import meet_world
from app.planning.waiting_goals import WaitingGoals
from app.store import WorldRow
from robots.world import WorldFile


class Fleet(Protocol):
    """What drives a world's robots, at the far end of their link."""

    @property
    def run(self) -> str | None:
        """The run of the world that it drives, None while it has not been heard of."""
        ...

    @property
    def taken_up(self) -> str | None:
        """The run whose robots are spoken with."""
        ...

    def take_up(self, run: str) -> None: ...


class FleetRun:
    """Brings the record in step with the run that a world's fleet drives, then lets its robots be spoken with."""

    def __init__(
        self,
        core: Core,
        world: WorldFile,
        fleet: Fleet,
        *,
        waiting: WaitingGoals,
        speaks: Callable[[], bool] = lambda: True,
    ) -> None:
        """
        :param speaks: True while this process, of those that share the record, is the one that keeps it for the world.
        """
        self._core, self._world, self._fleet = core, world, fleet
        self._waiting = waiting
        self._speaks = speaks

    def look(self) -> None:
        """Meet the fleet if it drives another run than was taken up. To be called again and again, cheap if not."""
        run = self._fleet.run
        if run is None or run == self._fleet.taken_up:
            return
        if self._speaks():
            self._meet(run)
        elif not self._is_recorded(run):
            return
        self._fleet.take_up(run)

    def _meet(self, run: str) -> None:
        with self._core.database.write() as session:
            if not meet_world(session, self._core, self._world, run):
                self._waiting.release(session, self._world.name)

    def _is_recorded(self, run: str) -> bool:
        with self._core.database.read() as session:
            row = session.get(WorldRow, self._world.name)
            return row is not None and row.run == run
