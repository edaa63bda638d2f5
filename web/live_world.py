"""A world's present state, with interpolated poses and the robots' trails."""

import time
from collections.abc import Callable, Mapping
from math import hypot, inf, remainder, tau

from web.api_types import Layout, Point, RobotTelemetry, Telemetry
from web.scene import Frame
from web.world_feed import WorldFeed, WorldSnapshot

TRAIL_STEP_M = 0.1
MAX_TRAIL_POINTS = 150
MAX_TOTAL_POINTS = 4000
"""Of all trails of a world together: the whole trail is sent whenever it grows."""
TRAILS_EVERY_S = 0.5
MAX_INTERPOLATION_S = 0.3
MAX_INTERPOLATION_M = 2.0
"""A robot that moved farther between two messages is drawn at its new pose at once."""

Robots = Mapping[str, RobotTelemetry]


class LiveWorld:
    """Follows a world until `stop`.

    Telemetry arrives ten times a second and is drawn twice as often: poses are interpolated between the last two
    messages, so they are drawn late by the interval between the two.
    """

    def __init__(self, feed: WorldFeed, clock: Callable[[], float] = time.monotonic) -> None:
        self.layout: Layout | None = None
        self.frame = Frame()
        self._feed = feed
        self._clock = clock
        self._points: dict[str, list[Point]] = {}
        self._trails: dict[str, list[Point]] = {}
        self._trails_time_s = -inf
        self._known: WorldSnapshot | None = None
        self._from: Robots = {}
        self._to: Robots = {}
        self._heard_at_s = clock()
        self._interpolation_s = 0.0
        self._is_still = True
        feed.start()

    def stop(self) -> None:
        self._feed.stop()

    def update(self) -> None:
        """Read the feed; `frame` stays the same object as long as nothing changes."""
        known = self._feed.latest
        if known.layout is None or (known is self._known and self._is_still):
            return
        if (
            known.telemetry.time_s < self.frame.time_s or known.layout != self.layout
        ):  # the world was restarted
            self._points = {}
            self._trails = {}
            self._trails_time_s = -inf
        self._known = known
        self.layout = known.layout
        if known.telemetry.robots is not self._to:
            self._take(known.telemetry)
        age_s = self._clock() - self._heard_at_s
        share = min(1.0, age_s / self._interpolation_s) if self._interpolation_s else 1.0
        self._is_still = share == 1.0
        self.frame = Frame(
            time_s=known.telemetry.time_s,
            names=tuple(robot.name for robot in known.layout.robots),
            robots=_between(self._from, self._to, share),
            facts=known.facts,
            trails=self._trails,
        )

    def _take(self, telemetry: Telemetry) -> None:
        now_s = self._clock()
        self._interpolation_s = min(now_s - self._heard_at_s, MAX_INTERPOLATION_S)
        self._heard_at_s = now_s
        self._from = self.frame.robots
        self._to = telemetry.robots
        self._extend_trails(telemetry)

    def _extend_trails(self, telemetry: Telemetry) -> None:
        limit = max(2, min(MAX_TRAIL_POINTS, MAX_TOTAL_POINTS // max(1, len(telemetry.robots))))
        for name, robot in telemetry.robots.items():
            points = self._points.setdefault(name, [])
            if not points or hypot(points[-1][0] - robot.x_m, points[-1][1] - robot.y_m) > TRAIL_STEP_M:
                self._points[name] = [*points[1 - limit :], (robot.x_m, robot.y_m)]
        if telemetry.time_s - self._trails_time_s >= TRAILS_EVERY_S:
            self._trails_time_s = telemetry.time_s
            if self._trails != self._points:
                self._trails = dict(self._points)


def _between(begin: Robots, end: Robots, share: float) -> Robots:
    if share == 1.0:
        return end
    return {name: _interpolated(begin.get(name, robot), robot, share) for name, robot in end.items()}


def _interpolated(begin: RobotTelemetry, end: RobotTelemetry, share: float) -> RobotTelemetry:
    distance_m = hypot(end.x_m - begin.x_m, end.y_m - begin.y_m)
    turn_rad = remainder(end.heading_rad - begin.heading_rad, tau)
    if (distance_m == 0 and turn_rad == 0) or distance_m > MAX_INTERPOLATION_M:
        return end
    return end.model_copy(
        update={
            "x_m": begin.x_m + share * (end.x_m - begin.x_m),
            "y_m": begin.y_m + share * (end.y_m - begin.y_m),
            "heading_rad": begin.heading_rad + share * turn_rad,
        }
    )
