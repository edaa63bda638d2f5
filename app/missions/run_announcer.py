"""Announces a world whose robots all have software of their own, so that there is no fleet to announce it."""

import logging
from collections.abc import Callable, Mapping

from app.agents.running_world import AnnouncesWorld
from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.ids import new_id
from app.missions.world_start import UNKNOWN_RUN
from app.store import WorldRow
from robots.clock import Clock
from robots.world import WorldFile

FLEETLESS_S = 3.0
"""Wall-clock seconds without a word of a fleet after which the service announces the world: three announcements."""

logger = logging.getLogger(__name__)


class RunAnnouncer:
    """Announces one world's run and time while it has no fleet and no robot that one would simulate.

    The run is that of the record, so that it outlives restarts and other processes; its time is the wall clock's since
    the run began, for the robots work on while the service is away. A fleet that comes is given way to at once.
    """

    def __init__(
        self,
        core: Core,
        worlds: Mapping[str, WorldFile],
        world: str,
        link: AnnouncesWorld,
        *,
        clock: Clock,
        holds_lease: Callable[[], bool] = lambda: True,
        start_new: bool,
        wall: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """
        :param worlds: the newest edition of each.
        :param clock: the world's, as it was last announced.
        :param holds_lease: True while this process, of those that share the database, is the one that announces.
        :param start_new: begin a new run instead of continuing the recorded one.
        """
        self._core = core
        self._worlds = worlds
        self._world = world
        self._link = link
        self._clock = clock
        self._holds_lease = holds_lease
        self._starts_new = start_new
        self._wall = wall
        self._run: tuple[str, float] | None = None

    @property
    def is_announcing(self) -> bool:
        """True while this process announces the world: nobody simulates it."""
        return self._run is not None

    def follow(self) -> None:
        """Announce the world if that is to be done; called often."""
        if not self._holds_lease() or self._link.fleetless_s < FLEETLESS_S or not self._is_of_robots_alone():
            self._run = None
            return
        if self._run is None:
            self._run = self._recorded_run()
            logger.info("the service announces %s, run %s", self._world, self._run[0])
        run, began_at = self._run
        self._link.announce(run, max(self._wall.epoch_s() - began_at, self._clock.now_s()))

    def _is_of_robots_alone(self) -> bool:
        """True if no robot is to be simulated; one that is added later waits for its fleet, and stops nobody."""
        return self.is_announcing or all(agent.external for agent in self._worlds[self._world].agents)

    def _recorded_run(self) -> tuple[str, float]:
        """The run to announce and the epoch seconds at which its time was 0, recorded."""
        now = self._wall.epoch_s()
        with self._core.database.write() as session:
            self._core.database.lock(session, f"world {self._world}")
            row = session.get_one(WorldRow, self._world)
            known = (row.announced_run if row.run == UNKNOWN_RUN else row.run) or None
            if known is None or self._starts_new:
                row.announced_run = new_id("run")
                row.announced_from = now
            else:
                # A fleet may have driven the run meanwhile, at a pace of its own: time does not go back.
                since = now - self._clock.now_s()
                is_ours = known == row.announced_run and row.announced_from is not None
                row.announced_run = known
                row.announced_from = min(since, row.announced_from or since) if is_ours else since
            self._starts_new = False
            return row.announced_run, row.announced_from
