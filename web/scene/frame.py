"""One instant of a world, and the arrays that the scenes of all pages share."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import pi

import numpy as np
from numpy.typing import NDArray

from web.api_types import Fact, Point, RobotTelemetry
from web.scene import palette
from web.scene.geometry import HIDDEN_M, Floats, segments, turned

RADIUS_M = 0.22
RANGES_HEIGHT_M = 0.12
JAW_OPEN_M = 0.095
JAW_CLOSED_M = 0.068
TRAIL_HEIGHT_M = 0.015

Colours = NDArray[np.uint8]


@dataclass(frozen=True, kw_only=True)
class Frame:
    """The moving parts of a world.

    :param names: the robots, in drawing order.
    :param trails: recent positions by robot, oldest first.
    """

    time_s: float = 0.0
    names: tuple[str, ...] = ()
    robots: Mapping[str, RobotTelemetry] = field(default_factory=dict)
    facts: Sequence[Fact] = ()
    trails: Mapping[str, Sequence[Point]] = field(default_factory=dict)

    @cached_property
    def heard(self) -> tuple[str, ...]:
        return tuple(name for name in self.names if name in self.robots)

    @cached_property
    def positions(self) -> Floats:
        """The robots' positions, shape (N, 3), metres; below the floor if never heard."""
        positions = np.full((len(self.names), 3), HIDDEN_M, dtype=np.float32)
        for index, name in enumerate(self.names):
            if name in self.robots:
                positions[index] = (self.robots[name].x_m, self.robots[name].y_m, 0.0)
        return positions

    @cached_property
    def _headings(self) -> NDArray[np.float64]:
        return np.array([self.robots[n].heading_rad if n in self.robots else 0.0 for n in self.names])

    @cached_property
    def rotations(self) -> Floats:
        """The robots' headings as quaternions, shape (N, 4)."""
        return turned(self._headings)

    @cached_property
    def jaws(self) -> tuple[Floats, Floats]:
        """Positions of the left and the right jaws, each of shape (N, 3), metres."""
        apart = [
            JAW_CLOSED_M if n in self.robots and self.robots[n].holding else JAW_OPEN_M for n in self.names
        ]
        left = np.stack([-np.sin(self._headings), np.cos(self._headings), 0 * self._headings], axis=-1)
        aside = (left * np.array(apart)[:, None]).astype(np.float32)
        return self.positions + aside, self.positions - aside

    @cached_property
    def trail_segments(self) -> tuple[Floats, Colours]:
        """The trails' segments and their colours, both of shape (N, 2, 3)."""
        colours = palette.of_robots(self.names)
        lines = [(trail, colours[name]) for name, trail in self.trails.items() if name in colours]
        return segments(lines, TRAIL_HEIGHT_M)


def range_segments(robots: Sequence[RobotTelemetry]) -> tuple[Floats, Colours]:
    """Segments from the hull to the end of each beam and their colours, both of shape (N, 2, 3).

    A beam that meets nothing is a short line, so that the count stays the same between updates.
    """
    hidden = np.full((1, 2, 3), HIDDEN_M, dtype=np.float32)
    colours = [np.full((1, 2, 3), palette.WHISKER_FREE, dtype=np.uint8)]
    points = [hidden]
    for robot in robots:
        ranges_m = np.array(robot.ranges_m, dtype=np.float64)  # None becomes NaN
        free = np.isnan(ranges_m)
        headings = robot.heading_rad + 2 * pi * np.arange(len(ranges_m)) / max(1, len(ranges_m))
        ends_m = np.where(free, RADIUS_M + 0.06, np.maximum(ranges_m, RADIUS_M))
        lengths = np.stack([np.full_like(ends_m, RADIUS_M), ends_m], axis=-1)
        ahead = np.stack([np.cos(headings), np.sin(headings)], axis=-1)
        beams = np.full((len(ranges_m), 2, 3), RANGES_HEIGHT_M, dtype=np.float32)
        beams[..., :2] = (robot.x_m, robot.y_m) + lengths[..., None] * ahead[:, None, :]
        points.append(beams)
        shades = np.full((len(ranges_m), 2, 3), palette.WHISKER_FREE, dtype=np.uint8)
        shades[~free, 1] = palette.WHISKER_HIT
        colours.append(shades)
    return np.concatenate(points), np.concatenate(colours)
