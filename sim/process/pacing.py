"""Keeps a world's clock at its speed: real time times N, as fast as it can, or standing still."""

from collections.abc import Callable

BACKLOG_S = 0.25
"""A world this far behind the wall clock lets the backlog go instead of racing after it (our choice)."""
FIGURE_S = 1.0
"""Wall time over which the real-time factor is measured."""


class Pacer:
    """Tells how long to wait before the next tick, and how fast the world really runs.

    :param speed: world seconds a wall second; None is as fast as it can.
    :param wall_s: the wall clock.
    :param from_s: the world's time now.
    """

    def __init__(self, wall_s: Callable[[], float], speed: float | None, from_s: float = 0.0) -> None:
        self._wall_s = wall_s
        self._speed = speed
        self._paused = False
        self._origin_wall_s = wall_s()
        self._origin_world_s = from_s
        self._measured = (self._origin_wall_s, from_s)
        self.real_time_factor = 0.0

    @property
    def paused(self) -> bool:
        return self._paused

    def set_speed(self, speed: float | None, world_s: float) -> None:
        """:raises ValueError: if the speed is not above zero; a world that stands still is paused."""
        if speed is not None and not speed > 0:
            raise ValueError(f"a world's speed is above 0, not {speed}; pause it to let it stand still")
        self._speed = speed
        self._start_from(world_s)

    def pause(self, paused: bool, world_s: float) -> None:
        self._paused = paused
        self._start_from(world_s)

    def wait_s(self, world_s: float) -> float | None:
        """Wall seconds until the tick after `world_s` is due, 0 if it is; None while paused."""
        self._measure(world_s)
        if self._paused:
            return None
        if self._speed is None:
            return 0.0
        ahead_s = (world_s - self._origin_world_s) / self._speed - (self._wall_s() - self._origin_wall_s)
        if ahead_s < -BACKLOG_S:
            self._start_from(world_s)
        return max(0.0, ahead_s)

    def _start_from(self, world_s: float) -> None:
        self._origin_wall_s, self._origin_world_s = self._wall_s(), world_s

    def _measure(self, world_s: float) -> None:
        since_s, from_s = self._measured
        now_s = self._wall_s()
        if now_s - since_s >= FIGURE_S:
            self.real_time_factor = (world_s - from_s) / (now_s - since_s)
            self._measured = (now_s, world_s)
