"""The open recording of one mission: writes what has changed."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from app.agents.robot_board import RobotView
from app.domain.events import MissionEnded
from app.recordings.mcap_writer import EVENTS, GOAL, MINDS, MISSION, NUMBERS, SAMPLES, McapWriter
from robots.wire import MindReport, Telemetry

ENDINGS = frozenset(MissionEnded.types())
OTHERS_INTERVAL_S = 1.0
"""Other robots are written this often (world's clock), and only while they move."""
MIN_MOVE_M = 0.01
MIN_TURN_RAD = 0.02


@dataclass(slots=True)
class MissionRecording:
    """A recording that is being written.

    :param names: ids and names whose events belong to the mission.
    :param robots: the mission's robots; their whole telemetry is written.
    :param is_over: the event of the mission's end was written. The mission's state may show the end earlier, before its
        last events were written.
    """

    mission: str
    writer: McapWriter
    world: str
    places: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    names: frozenset[str] = frozenset()
    robots: frozenset[str] = frozenset()
    is_over: bool = False
    _last: dict[str, Any] = field(default_factory=dict)
    _latest: dict[str, Telemetry] = field(default_factory=dict)

    def write_event(self, event: dict[str, Any], at_s: float) -> None:
        self.writer.write_json(EVENTS, event, at_s)
        self.is_over |= event["subject"] == self.mission and event["type"] in ENDINGS

    def write_state(self, topic: str, body: Any, at_s: float) -> None:
        """Write the state of something if it has changed."""
        key = topic if topic in (MISSION, GOAL) else f"{topic}/{body['id']}"
        if self._last.get(key) != body:
            self._last[key] = body
            self.writer.write_json(topic, body, at_s)

    def has_written(self, topic: str, name: str) -> bool:
        return f"{topic}/{name}" in self._last

    def write_samples(self, samples: Mapping[str, str], at_s: float) -> None:
        """Write the believed place or robot of each sample, if any has changed."""
        if self._last.get(SAMPLES) != samples:
            self._last[SAMPLES] = samples
            self.writer.write_json(SAMPLES, samples, at_s)
            self.writer.write_samples(samples, self.places, at_s)

    def write_numbers(self, numbers: Mapping[str, float], at_s: float) -> None:
        """Write the world's numeric facts, if any has changed."""
        if self._last.get(NUMBERS) != numbers:
            self._last[NUMBERS] = numbers
            self.writer.write_json(NUMBERS, numbers, at_s)

    def write_mind(self, robot: str, report: MindReport) -> None:
        """Write what the robot believes and is committed to, if that has changed."""
        topic = MINDS + robot
        told = report.model_dump(mode="json", exclude={"kind", "at_s"})
        if self._last.get(topic) != told:
            self._last[topic] = told
            self.writer.write_json(topic, {"at_s": report.at_s, **told}, report.at_s)

    def write_robots(self, views: Mapping[str, RobotView]) -> None:
        """Write the new telemetry of the world's robots."""
        news = {
            name: view.telemetry
            for name, view in views.items()
            if view.world == self.world and view.telemetry and self._is_news(name, view.telemetry)
        }
        self._latest.update(news)
        self.writer.write_robots(news, whole=self.robots)

    def _is_news(self, name: str, now: Telemetry) -> bool:
        last = self._latest.get(name)
        if last is None:
            return True
        if name in self.robots:
            return now.at_s > last.at_s
        return now.at_s >= last.at_s + OTHERS_INTERVAL_S and _has_changed(last, now)


def _has_changed(last: Telemetry, now: Telemetry) -> bool:
    moved = abs(now.x_m - last.x_m) + abs(now.y_m - last.y_m) > MIN_MOVE_M
    turned = abs(now.heading_rad - last.heading_rad) > MIN_TURN_RAD
    return moved or turned or (now.holding, now.packet_tag) != (last.holding, last.packet_tag)
