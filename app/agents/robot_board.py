"""The newest telemetry and contact of each robot. Kept in memory: telemetry is not stored in the database."""

import threading
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Self

from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.contact import Connection
from robots.clock import Clock
from robots.link.mqtt.topics import ConnectionState
from robots.wire import OWN, Telemetry
from robots.world import WorldFile

SILENT_AFTER_S = 5.0
"""Seconds (wall clock) without a message after which a robot counts as offline."""
LOW_BATTERY = 0.2
BATTERY_HYSTERESIS = 0.05
"""How far above `low_battery` a battery must be before its robot is recruited again (our choice)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotView:
    """A robot as last heard.

    :param holding_since_s: world's clock of the first telemetry that shows what it holds now; None if it holds nothing.
    :param heard_s: by the world's clock; None before anything was heard.
    :param heard_monotonic_s: likewise by the monotonic clock of this process.
    :param broken: its link is closed for good.
    :param gone: the last reported state of its connection; None if online.
    :param unavailable: why the robot is not recruited now, in words; empty if it may be.
    """

    name: str
    world: str
    telemetry: Telemetry | None = None
    holding_since_s: float | None = None
    heard_s: float | None = None
    heard_monotonic_s: float | None = None
    broken: bool = False
    gone: Connection | None = None
    unavailable: str = ""

    @property
    def is_gone(self) -> bool:
        """True if it is known not to be connected."""
        return self.broken or self.gone is not None

    def connection(self, monotonic_s: float) -> Connection:
        """:param monotonic_s: the monotonic time now."""
        if self.broken:
            return Connection.CONNECTION_BROKEN
        if self.gone is not None:
            return self.gone
        if self.heard_monotonic_s is None or monotonic_s - self.heard_monotonic_s > SILENT_AFTER_S:
            return Connection.OFFLINE
        return Connection.ONLINE


class RobotBoard:
    """The newest view of every robot; readers wait for changes."""

    def __init__(
        self,
        robots: Iterable[tuple[str, str]],
        *,
        clocks: Mapping[str, Clock],
        low_battery: float = LOW_BATTERY,
        wall: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """
        :param robots: each with its world.
        :param clocks: by world.
        :param low_battery: a robot whose battery holds less, 0 to 1, is not recruited.
        """
        self.became_available: list[Callable[[str], None]] = []
        """Called with the world, in the receiving thread, when one of its robots may be recruited again."""
        self.unavailability_changed: list[Callable[[str, str, str], None]] = []
        """Called with world, robot and reason, in the same thread, when the reason why it is not recruited changes."""
        self._clocks = clocks
        self._low_battery = low_battery
        self._wall = wall
        self._changed = threading.Condition()
        self._views = {name: RobotView(name=name, world=world) for name, world in robots}
        self._generation = 0

    @classmethod
    def of(
        cls,
        worlds: Mapping[str, WorldFile],
        *,
        clocks: Mapping[str, Clock],
        low_battery: float,
        wall: WallClock = SYSTEM_CLOCK,
    ) -> Self:
        """Of all robots and peripherals of the worlds."""
        robots = ((robot.name, name) for name, world in worlds.items() for robot in world.agents)
        return cls(robots, clocks=clocks, low_battery=low_battery, wall=wall)

    def renew(self, world: WorldFile) -> None:
        """Know the robots and peripherals that the world has now, and no others of it."""
        here = {robot.name for robot in world.agents}
        with self._changed:
            kept = {
                name: view for name, view in self._views.items() if view.world != world.name or name in here
            }
            new = {name: RobotView(name=name, world=world.name) for name in sorted(here - kept.keys())}
            self._views = kept | new
            self._generation += 1
            self._changed.notify_all()

    def forget(self, world: str) -> None:
        """Know no robots of the world any longer."""
        with self._changed:
            self._views = {name: view for name, view in self._views.items() if view.world != world}
            self._generation += 1
            self._changed.notify_all()

    def views(self, world: str | None = None) -> Mapping[str, RobotView]:
        with self._changed:
            return {n: v for n, v in self._views.items() if world is None or v.world == world}

    def view(self, robot: str) -> RobotView:
        with self._changed:
            return self._views[robot]

    def is_connected(self, robot: str) -> bool:
        """Whether somebody speaks for the robot now."""
        with self._changed:
            view = self._views.get(robot)
        return view is not None and view.connection(self._wall.monotonic_s()) is Connection.ONLINE

    def points(self, world: str) -> Mapping[str, tuple[float, float]]:
        """The last reported positions of the world's robots, (x, y) in metres."""
        heard = {name: view.telemetry for name, view in self.views(world).items()}
        return {name: (said.x_m, said.y_m) for name, said in heard.items() if said is not None}

    def unavailable(self, world: str) -> Mapping[str, str]:
        """The robots of the world that are not recruited now, each with the reason in words."""
        return {name: view.unavailable for name, view in self.views(world).items() if view.unavailable}

    def heard(self, robot: str, telemetry: Telemetry | None = None) -> None:
        """A message of the robot was received."""
        with self._changed:
            view = self._views.get(robot)
            if view is None:
                return
            since_s = view.holding_since_s
            if telemetry is not None and (
                view.telemetry is None or telemetry.holding != view.telemetry.holding
            ):
                since_s = telemetry.at_s if telemetry.holding else None
            telemetry = telemetry or view.telemetry
            unavailable = "" if telemetry is None else self._why_unavailable(telemetry, was=view.unavailable)
            self._views[robot] = replace(
                view,
                telemetry=telemetry,
                holding_since_s=since_s,
                heard_monotonic_s=self._wall.monotonic_s(),
                heard_s=self._clocks[view.world].now_s(),
                broken=False,
                gone=None,
                unavailable=unavailable,
            )
            self._generation += 1
            self._changed.notify_all()
        if view.unavailable and not unavailable:
            for notify in self.became_available:
                notify(view.world)
        elif unavailable != view.unavailable:
            for notify_reason in self.unavailability_changed:
                notify_reason(view.world, robot, unavailable)

    def _why_unavailable(self, telemetry: Telemetry, *, was: str) -> str:
        # NOTE: without hysteresis a battery at the limit changes the answer ten times a second.
        enough = self._low_battery + (BATTERY_HYSTERESIS if was else 0.0)
        if telemetry.driven_by is not None:
            return f"which {telemetry.driven_by} drives"
        level = f"its battery at {telemetry.battery:.0%}"
        is_low = telemetry.battery < min(enough, 1.0)
        # One that only stands at its charger is recruited: plans know how far its battery lasts.
        is_own = telemetry.script_id is not None and telemetry.script_id.startswith(OWN)
        if telemetry.charging and (is_low or is_own):
            return f"which charges, {level}"
        return f"which rests, {level}" if is_low else ""

    def link_closed(self, world: str) -> None:
        """The link to the world's robots is closed."""
        with self._changed:
            for name, view in self._views.items():
                if view.world == world:
                    self._views[name] = replace(view, broken=True)
            self._generation += 1
            self._changed.notify_all()

    def connected(self, robot: str, state: ConnectionState, *, now: bool) -> None:
        """The link reports a robot's connection; not `now`: a retained report of its last known state."""
        with self._changed:
            view = self._views.get(robot)
            if view is None:
                return
            is_online = state is ConnectionState.ONLINE
            # NOTE: `heard_s` is for messages by the robot's radio; this report comes from the broker.
            heard_monotonic_s = self._wall.monotonic_s() if is_online and now else view.heard_monotonic_s
            gone = None if is_online else Connection(state.value)
            self._views[robot] = replace(view, gone=gone, heard_monotonic_s=heard_monotonic_s)
            self._generation += 1
            self._changed.notify_all()

    def wake(self) -> None:
        """End all `wait` calls without a message."""
        with self._changed:
            self._generation += 1
            self._changed.notify_all()

    def wait(self, generation: int, timeout_s: float) -> int:
        """Block until the board has changed since `generation`; returns the new generation."""
        with self._changed:
            self._changed.wait_for(lambda: self._generation != generation, timeout_s)
            return self._generation
