"""Keeps a world's clock at its speed: real time times N, as fast as possible, or paused."""

from robots.clock import Clock
from sim.error import SimulationError

MAX_BACKLOG_S = 0.5
"""A world this far behind the wall clock drops the backlog instead of catching up (our choice)."""


class Pacer:
    """Computes how long to wait before the next tick.

    :param speed: world seconds per wall second; None is as fast as possible.
    :param from_s: the world's time now.
    :raises SimulationError: if the speed is not above 0; to stop a world, pause it.
    """

    def __init__(self, wall_clock: Clock, speed: float | None, from_s: float = 0.0) -> None:
        if speed is not None and not speed > 0:
            raise SimulationError(f"a world's speed must be above 0, not {speed}")
        self._wall_clock = wall_clock
        self._speed = speed
        self._paused = False
        self._restart_from(from_s)

    def pause(self, paused: bool, world_s: float) -> None:
        self._paused = paused
        self._restart_from(world_s)

    def wait_s(self, world_s: float) -> float | None:
        """Wall seconds until the tick after `world_s` is due, 0 if it is; None while paused."""
        if self._paused:
            return None
        if self._speed is None:
            return 0.0
        elapsed_s = self._wall_clock.now_s() - self._origin_wall_s
        ahead_s = (world_s - self._origin_world_s) / self._speed - elapsed_s
        if ahead_s < -MAX_BACKLOG_S:
            self._restart_from(world_s)
        return max(0.0, ahead_s)

    def _restart_from(self, world_s: float) -> None:
        self._origin_wall_s = self._wall_clock.now_s()
        self._origin_world_s = world_s
