"""What is known of each robot right now, from its telemetry. Kept in memory: telemetry is never a record."""

import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Self

from app.domain.states import Connection
from robots.clock import Clock
from robots.link.mqtt.topics import ConnectionState
from robots.wire import Telemetry
from robots.world import WorldFile

SILENT_AFTER_S = 5.0
"""Seconds (wall clock) without a word after which a robot counts as offline."""
LOW_BATTERY = 0.2
REFRESHED = 0.05
"""So much above the low mark a battery must be before its robot counts as fit again (our choice)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotView:
    """A robot as last heard: `heard_at` by the wall clock, epoch seconds, `heard_s` by the world's; None before.

    :param broken: the link that it is reached over is gone for good.
    :param gone: what was last said of its connection, if that was not that it is there.
    :param resting: why the robot is not recruited now, in words; empty if it may be.
    """

    name: str
    world: str
    telemetry: Telemetry | None = None
    heard_at: float | None = None
    heard_s: float | None = None
    broken: bool = False
    gone: Connection | None = None
    resting: str = ""

    @property
    def is_gone(self) -> bool:
        """True if it is known not to be there, which its radio has no part in."""
        return self.broken or self.gone is not None

    def connection(self, now: float) -> Connection:
        if self.broken:
            return Connection.CONNECTION_BROKEN
        if self.gone is not None:
            return self.gone
        if self.heard_at is None or now - self.heard_at > SILENT_AFTER_S:
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
    ) -> None:
        """
        :param robots: each with its world.
        :param clocks: by world.
        :param low_battery: a robot whose battery holds less, 0 to 1, is not recruited.
        """
        self.rested: list[Callable[[str], None]] = []
        """Called with the world when a robot of it may be recruited again, by the thread that heard so."""
        self._clocks, self._low_battery = clocks, low_battery
        self._changed = threading.Condition()
        self._views = {name: RobotView(name=name, world=world) for name, world in robots}
        self._generation = 0

    @classmethod
    def of(cls, worlds: Mapping[str, WorldFile], *, clocks: Mapping[str, Clock], low_battery: float) -> Self:
        """Of all robots of the worlds."""
        robots = ((robot.name, name) for name, world in worlds.items() for robot in world.robots)
        return cls(robots, clocks=clocks, low_battery=low_battery)

    def views(self, world: str | None = None) -> Mapping[str, RobotView]:
        with self._changed:
            return {n: v for n, v in self._views.items() if world is None or v.world == world}

    def view(self, robot: str) -> RobotView:
        with self._changed:
            return self._views[robot]

    def points(self, world: str) -> Mapping[str, tuple[float, float]]:
        """Where the robots of the world last said they are, (x, y) in metres."""
        heard = {name: view.telemetry for name, view in self.views(world).items()}
        return {name: (said.x_m, said.y_m) for name, said in heard.items() if said is not None}

    def resting(self, world: str) -> Mapping[str, str]:
        """The robots of the world that are not recruited now, each with the reason in words."""
        return {name: view.resting for name, view in self.views(world).items() if view.resting}

    def heard(self, robot: str, telemetry: Telemetry | None = None) -> None:
        """The robot said something; with telemetry, that is its newest view."""
        with self._changed:
            view = self._views.get(robot)
            if view is None:
                return
            telemetry = telemetry or view.telemetry
            resting = "" if telemetry is None else self._why_resting(telemetry, was=view.resting)
            self._views[robot] = replace(
                view,
                telemetry=telemetry,
                heard_at=time.time(),
                heard_s=self._clocks[view.world].now_s(),
                broken=False,
                gone=None,
                resting=resting,
            )
            self._generation += 1
            self._changed.notify_all()
        if view.resting and not resting:
            for tell in self.rested:
                tell(view.world)

    def _why_resting(self, telemetry: Telemetry, *, was: str) -> str:
        # NOTE: a battery at the mark would otherwise call the robot fit and unfit ten times a second.
        enough = self._low_battery + (REFRESHED if was else 0.0)
        if telemetry.driven_by is not None:
            return f"which {telemetry.driven_by} drives"
        level = f"its battery at {telemetry.battery:.0%}"
        if telemetry.charging:
            return f"which charges, {level}"
        return f"which rests, {level}" if telemetry.battery < min(enough, 1.0) else ""

    def broke(self, world: str) -> None:
        """The link to the world's robots is gone."""
        with self._changed:
            for name, view in self._views.items():
                if view.world == world:
                    self._views[name] = replace(view, broken=True)
            self._generation += 1
            self._changed.notify_all()

    def connected(self, robot: str, state: ConnectionState, *, now: bool) -> None:
        """The link says whether the robot is there; not `now`: whether it was when that was last heard of."""
        with self._changed:
            view = self._views.get(robot)
            if view is None:
                return
            there = state is ConnectionState.ONLINE
            # NOTE: that the broker has let it in did not come by its radio, so the world's clock has no part in it.
            heard_at = time.time() if there and now else view.heard_at
            gone = None if there else Connection(state.value)
            self._views[robot] = replace(view, gone=gone, heard_at=heard_at)
            self._generation += 1
            self._changed.notify_all()

    def wake(self) -> None:
        """Let those that wait go on, though nothing was heard."""
        with self._changed:
            self._generation += 1
            self._changed.notify_all()

    def wait(self, generation: int, timeout_s: float) -> int:
        """Block until something was heard after `generation`; answers the generation then."""
        with self._changed:
            self._changed.wait_for(lambda: self._generation != generation, timeout_s)
            return self._generation
