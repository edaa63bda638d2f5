"""A mission that is being recorded: writes onto its tape what is new."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from app.agents.robot_board import RobotView
from app.domain.lifecycles.mission import ENDED
from app.recordings.mcap_writer import EVENTS, GOAL, MISSION, SAMPLES, McapWriter
from robots.wire import Telemetry

ENDINGS = frozenset(f"mission.{state}" for state in ENDED)
ASIDE_S = 1.0
"""Robots of other missions are written down so often, on the world's clock, and only while they move."""
STEP_M, TURN_RAD = 0.01, 0.02


@dataclass(slots=True)
class Track:
    """`names`: what its events are about; `robots`: those whose whole telemetry is written down.

    `is_over`: the mission's end was told. How the mission stands may say so before, while events are still to come.
    """

    mission: str
    writer: McapWriter
    world: str
    places: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    names: frozenset[str] = frozenset()
    robots: frozenset[str] = frozenset()
    is_over: bool = False
    _last: dict[str, Any] = field(default_factory=dict)
    _heard: dict[str, Telemetry] = field(default_factory=dict)

    def event(self, told: dict[str, Any], at_s: float) -> None:
        self.writer.tell(EVENTS, told, at_s)
        self.is_over |= told["subject"] == self.mission and told["type"] in ENDINGS

    def stands(self, topic: str, body: Any, at_s: float) -> None:
        """Tell how something stands, if that is not how it stood."""
        key = topic if topic in (MISSION, GOAL) else f"{topic}/{body['id']}"
        if self._last.get(key) != body:
            self._last[key] = body
            self.writer.tell(topic, body, at_s)

    def knows(self, topic: str, name: str) -> bool:
        return f"{topic}/{name}" in self._last

    def lie(self, samples: Mapping[str, str], at_s: float) -> None:
        """Where the samples are believed to lie: in a place, or in a robot's gripper."""
        if self._last.get(SAMPLES) != samples:
            self._last[SAMPLES] = samples
            self.writer.tell(SAMPLES, samples, at_s)
            self.writer.samples(samples, self.places, at_s)

    def hear(self, views: Mapping[str, RobotView]) -> None:
        """Where the world's robots are now."""
        news = {
            name: view.telemetry
            for name, view in views.items()
            if view.world == self.world and view.telemetry and self._is_news(name, view.telemetry)
        }
        self._heard.update(news)
        self.writer.robots(news, whole=self.robots)

    def _is_news(self, name: str, said: Telemetry) -> bool:
        last = self._heard.get(name)
        if last is None:
            return True
        if name in self.robots:
            return said.at_s > last.at_s
        return said.at_s >= last.at_s + ASIDE_S and _has_changed(last, said)


def _has_changed(last: Telemetry, said: Telemetry) -> bool:
    moved = abs(said.x_m - last.x_m) + abs(said.y_m - last.y_m) > STEP_M
    turned = abs(said.heading_rad - last.heading_rad) > TURN_RAD
    return moved or turned or (said.holding, said.packet_tag) != (last.holding, last.packet_tag)
