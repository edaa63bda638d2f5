"""A world as it is now: its feed, made smooth, and where its robots have been of late."""

import time
from collections.abc import Callable, Mapping
from math import hypot, inf, remainder, tau

from web.api_types import Layout, Point, RobotTelemetry, Telemetry
from web.scene import Frame
from web.world_feed import WorldFeed

STEP_M = 0.1
"""A point of a trail is so far from the last."""
LONGEST = 150
MOST_POINTS = 4000
"""Of all trails of a world together: they are sent whole whenever they grow."""
TRAILS_EVERY_S = 0.5
LONGEST_GLIDE_S = 0.3
FARTHEST_GLIDE_M = 2.0
"""What is farther off was set there, it did not drive."""

Robots = Mapping[str, RobotTelemetry]


class LiveWorld:
    """Follows a world until `stop`; hands out its newest instant.

    Telemetry comes ten times a second and is drawn twice as often: robots glide from what they told last to what
    they tell now, as long as it took them, and so are drawn that much late.
    """

    def __init__(self, feed: WorldFeed, clock: Callable[[], float] = time.monotonic) -> None:
        self._feed, self._clock = feed, clock
        self._ways: dict[str, list[Point]] = {}
        self._trails: dict[str, list[Point]] = {}
        self._trailed_s = -inf
        self._version = -1
        self._from: Robots = {}
        self._to: Robots = {}
        self._heard_at, self._glide_s = clock(), 0.0
        self._still = True
        self.layout: Layout | None = None
        self.frame = Frame()
        feed.start()

    def stop(self) -> None:
        self._feed.stop()

    def look(self) -> None:
        """Take in what is new; `frame` stays the same object as long as nothing is."""
        known = self._feed.latest()
        news = known.version != self._version
        if known.layout is None or not (news or not self._still):
            return
        if known.telemetry.time_s < self.frame.time_s or known.layout != self.layout:
            self._ways, self._trails, self._trailed_s = {}, {}, -inf  # the world was begun afresh
        self._version, self.layout = known.version, known.layout
        if known.telemetry.robots is not self._to:
            self._begin_glide(known.telemetry)
        now = self._clock()
        share = min(1.0, (now - self._heard_at) / self._glide_s) if self._glide_s else 1.0
        self._still = share == 1.0
        self.frame = Frame(
            time_s=known.telemetry.time_s,
            names=tuple(robot.name for robot in known.layout.robots),
            robots=_between(self._from, self._to, share),
            facts=known.facts,
            trails=self._trails,
        )

    def _begin_glide(self, telemetry: Telemetry) -> None:
        now = self._clock()
        self._glide_s = min(now - self._heard_at, LONGEST_GLIDE_S)
        self._from, self._to, self._heard_at = self.frame.robots, telemetry.robots, now
        self._go_on(telemetry)

    def _go_on(self, telemetry: Telemetry) -> None:
        longest = max(2, min(LONGEST, MOST_POINTS // max(1, len(telemetry.robots))))
        for name, told in telemetry.robots.items():
            way = self._ways.setdefault(name, [])
            if not way or hypot(way[-1][0] - told.x_m, way[-1][1] - told.y_m) > STEP_M:
                self._ways[name] = [*way[1 - longest :], (told.x_m, told.y_m)]
        if telemetry.time_s - self._trailed_s >= TRAILS_EVERY_S:
            self._trailed_s = telemetry.time_s
            if self._trails != self._ways:
                self._trails = dict(self._ways)


def _between(begin: Robots, end: Robots, share: float) -> Robots:
    """The robots on their way from one place to the next; those that did not move as they are."""
    if share == 1.0:
        return end
    return {name: _glided(begin.get(name, told), told, share) for name, told in end.items()}


def _glided(begin: RobotTelemetry, end: RobotTelemetry, share: float) -> RobotTelemetry:
    far_m = hypot(end.x_m - begin.x_m, end.y_m - begin.y_m)
    turn = remainder(end.heading_rad - begin.heading_rad, tau)
    if (far_m == 0 and turn == 0) or far_m > FARTHEST_GLIDE_M:
        return end
    return end.model_copy(
        update={
            "x_m": begin.x_m + share * (end.x_m - begin.x_m),
            "y_m": begin.y_m + share * (end.y_m - begin.y_m),
            "heading_rad": begin.heading_rad + share * turn,
        }
    )
