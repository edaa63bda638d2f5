"""What is known of each robot right now, from its telemetry. Kept in memory: telemetry is never a record."""

import threading
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from app.states import Connection
from robots.wire import Telemetry

SILENT_AFTER_S = 5.0
"""Seconds (wall clock) without a word after which a robot counts as offline."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotView:
    """A robot as last heard. `heard_at` is the wall clock's epoch seconds, None before the first word."""

    name: str
    world: str
    telemetry: Telemetry | None = None
    heard_at: float | None = None
    broken: bool = False

    def connection(self, now: float) -> Connection:
        if self.broken:
            return Connection.CONNECTION_BROKEN
        if self.heard_at is None or now - self.heard_at > SILENT_AFTER_S:
            return Connection.OFFLINE
        return Connection.ONLINE


class RobotBoard:
    """The newest view of every robot; readers wait for changes."""

    def __init__(self, robots: Iterable[tuple[str, str]]) -> None:
        self._changed = threading.Condition()
        self._views = {name: RobotView(name=name, world=world) for name, world in robots}
        self._generation = 0

    def views(self, world: str | None = None) -> Mapping[str, RobotView]:
        with self._changed:
            return {n: v for n, v in self._views.items() if world is None or v.world == world}

    def heard(self, robot: str, telemetry: Telemetry | None = None) -> None:
        """The robot said something; with telemetry, that is its newest view."""
        with self._changed:
            view = self._views.get(robot)
            if view is None:
                return
            telemetry = telemetry or view.telemetry
            self._views[robot] = replace(view, telemetry=telemetry, heard_at=time.time(), broken=False)
            self._generation += 1
            self._changed.notify_all()

    def broke(self, world: str) -> None:
        """The link to the world's robots is gone."""
        with self._changed:
            for name, view in self._views.items():
                if view.world == world:
                    self._views[name] = replace(view, broken=True)
            self._generation += 1
            self._changed.notify_all()

    def wait(self, generation: int, timeout_s: float) -> int:
        """Block until something was heard after `generation`; answers the generation then."""
        with self._changed:
            self._changed.wait_for(lambda: self._generation != generation, timeout_s)
            return self._generation
