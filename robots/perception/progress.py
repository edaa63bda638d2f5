"""A packet's progress since its patterns started to act, by odometry (SRA, MaxDistance)."""

from collections import deque
from dataclasses import dataclass

from robots.data import Memory
from robots.physical.body import Pose
from robots.physical.geometry import to_robot, wrap

WINDOW = 5
"""Ticks over which speed and turn rate are measured: one tick is too coarse."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """Time, distance and turn since the start of the packet, and the present speed.

    `travelled_m` counts driving back as positive, `advanced_m` as negative; `turned_rad` is not wrapped,
    counter-clockwise positive. `raised`: the events raised so far. `retries`: retry manoeuvres begun so far; during
    one, the rest counts from its begin.
    """

    elapsed_s: float = 0.0
    travelled_m: float = 0.0
    advanced_m: float = 0.0
    turned_rad: float = 0.0
    speed_m_s: float = 0.0
    turn_rad_s: float = 0.0
    raised: frozenset[str] = frozenset()
    retries: int = 0


NO_PROGRESS = Progress()


class WayMemory(Memory):
    """The sums of an odometer."""

    elapsed_s: float = 0.0
    travelled_m: float = 0.0
    advanced_m: float = 0.0
    turned_rad: float = 0.0


class Odometer:
    """Adds up the steps of odometry in `way`, from its first update on."""

    def __init__(self) -> None:
        self.way = WayMemory()
        self._last: Pose | None = None
        self._window: deque[tuple[float, float, float]] = deque(maxlen=WINDOW)

    def leave_out(self) -> None:
        """Add nothing for what was driven since the last update."""
        self._last = None
        self._window.clear()

    def update(self, odometry: Pose, step_s: float, raised: frozenset[str] = frozenset()) -> Progress:
        """Account for one tick; the first one adds nothing."""
        last = self._last
        way = self.way
        self._last = odometry
        if last is not None:
            ahead_m = to_robot(last, complex(odometry.x_m, odometry.y_m)).real
            way.elapsed_s += step_s
            way.travelled_m += abs(ahead_m)
            way.advanced_m += ahead_m
            way.turned_rad += wrap(odometry.heading_rad - last.heading_rad)
        self._window.append((way.elapsed_s, way.advanced_m, way.turned_rad))
        since_s, since_m, since_rad = self._window[0]
        span_s = way.elapsed_s - since_s
        return Progress(
            elapsed_s=way.elapsed_s,
            travelled_m=way.travelled_m,
            advanced_m=way.advanced_m,
            turned_rad=way.turned_rad,
            speed_m_s=(way.advanced_m - since_m) / span_s if span_s > 0 else 0.0,
            turn_rad_s=(way.turned_rad - since_rad) / span_s if span_s > 0 else 0.0,
            raised=raised,
        )
