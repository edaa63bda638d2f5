"""Whether a robot's silence is longer than its radio explains.

Only time in which it could have been heard counts: the windows of contact of its link, which are known beforehand.
Outages are not known, so they count as silence.
"""

from collections.abc import Mapping

from app.agents.robot_board import SILENT_AFTER_S, RobotBoard
from app.domain.clock import SYSTEM_CLOCK, WallClock
from robots.clock import Clock
from robots.world import LinkSpec, WorldFile
from robots.world.radio import QUIET_S

MIN_LEFT_S = 1.0
"""World seconds that a robot at least has left before it is silent, if it was heard recently by the wall clock."""


class ContactMonitor:
    """Measures the silence of the robots of all worlds. Thread-safe: it only reads the board."""

    def __init__(
        self,
        board: RobotBoard,
        *,
        clocks: Mapping[str, Clock],
        worlds: Mapping[str, WorldFile],
        wall: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """:param clocks: by world."""
        self._board = board
        self._clocks = clocks
        self._wall = wall
        self._worlds = worlds
        self._began = {world: self._now(world) for world in clocks}

    def forget(self, world: str) -> None:
        """The world no longer runs; if it is added again, its robots' silence counts from then on."""
        self._began.pop(world, None)

    def _now(self, world: str) -> tuple[float, float]:
        """The world's clock and the monotonic clock."""
        return self._clocks[world].now_s(), self._wall.monotonic_s()

    def silent_in_s(self, robot: str) -> float:
        """Least world seconds until its silence is longer than its radio explains; 0 once it is.

        NOTE: in a world that runs fast, messages are far apart by the world's clock, so the wall clock counts, too. If
        the link reports that the robot is gone, only the wall clock counts: the world's clock may stand still.
        """
        view = self._board.view(robot)
        link = self._link(robot)
        now_s, monotonic_s = self._now(view.world)
        began_s, began_monotonic_s = self._began.setdefault(view.world, (now_s, monotonic_s))
        heard_s = began_s if view.heard_s is None else view.heard_s
        heard_monotonic_s = began_monotonic_s if view.heard_monotonic_s is None else view.heard_monotonic_s
        unheard_s = monotonic_s - heard_monotonic_s
        if view.is_gone and unheard_s >= QUIET_S:
            return 0.0
        # The world's clock goes back when a new run begins.
        left_s = link.quiet_s - link.hearing_s(heard_s if heard_s <= now_s else 0.0, now_s)
        return max(left_s, MIN_LEFT_S if unheard_s < SILENT_AFTER_S else 0.0)

    def next_contact_s(self, robot: str) -> float:
        """World seconds until contact is expected, as far as is known beforehand; 0 while it is."""
        now_s = self._clocks[self._board.view(robot).world].now_s()
        return self._link(robot).next_contact_s(now_s) - now_s

    def _link(self, robot: str) -> LinkSpec:
        return self._worlds[self._board.view(robot).world].links[robot]
