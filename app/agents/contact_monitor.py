"""Whether a robot's silence is longer than its radio explains.

What counts is the time in which it could have been heard: of a link with windows of contact those alone, for they are
known beforehand; outages are not.
"""

import time
from collections.abc import Callable, Mapping

from app.agents.robot_board import SILENT_AFTER_S, RobotBoard
from robots.clock import Clock
from robots.world import WorldFile
from robots.world.radio import QUIET_S

LEAST_S = 1.0
"""World seconds that are left to a robot that was heard not long ago by the wall clock."""


class ContactMonitor:
    """Of the robots of all worlds. Thread-safe, for it only reads the board."""

    def __init__(
        self,
        board: RobotBoard,
        *,
        clocks: Mapping[str, Clock],
        worlds: Mapping[str, WorldFile],
        wall: Callable[[], float] = time.time,
    ) -> None:
        """:param clocks: by world."""
        self._board, self._clocks, self._wall = board, clocks, wall
        self._links = {r.name: world.link_of(r) for world in worlds.values() for r in world.robots}
        self._began_s, self._began_at = {world: clock.now_s() for world, clock in clocks.items()}, wall()

    def silent_in_s(self, robot: str) -> float:
        """World seconds at least until its silence is longer than its radio explains; 0 once it is.

        NOTE: a world that runs fast says little in its own time, so the wall clock has a say, too; and where the link
        says that the robot is not there, it alone has, for the world's clock may stand.
        """
        view, link = self._board.view(robot), self._links[robot]
        now_s = self._clocks[view.world].now_s()
        heard_s = self._began_s[view.world] if view.heard_s is None else view.heard_s
        heard_at = self._began_at if view.heard_at is None else view.heard_at
        unheard = self._wall() - heard_at
        if view.is_gone and unheard >= QUIET_S:
            return 0.0
        # A clock that went back is another run's.
        left_s = link.quiet_s - link.hearing_s(heard_s if heard_s <= now_s else 0.0, now_s)
        return max(left_s, LEAST_S if unheard < SILENT_AFTER_S else 0.0)

    def next_contact_s(self, robot: str) -> float:
        """World seconds until contact is expected, as far as is known beforehand; 0 while it is."""
        now_s = self._clocks[self._board.view(robot).world].now_s()
        return self._links[robot].next_contact_s(now_s) - now_s
