"""The robots: a batched node for each part, a node for range readings, a node for trails."""

from collections.abc import Sequence

import numpy as np
import viser

from web.api_types import RobotTelemetry
from web.scene import palette
from web.scene.frame import RADIUS_M, Frame, range_segments
from web.scene.geometry import Mesh, box, cylinder, merged
from web.scene.nodes import HIDDEN, OnClick, add_instances, add_lines, on_instance_click

HULL_TOP_M = 0.2
LABEL_HEIGHT_M = 0.5
SILENT_AFTER_S = 5.0
"""A robot whose newest telemetry is older than this is labelled as not heard."""
MAX_ROBOTS_WITH_RANGES = 16
"""In a world with more robots only the selected one's range readings are drawn."""


class RobotsView:
    """Draws the robots of a world."""

    def __init__(
        self, scene: viser.SceneApi, names: Sequence[str], trim: palette.Colour, on_click: OnClick
    ) -> None:
        self._names = tuple(names)
        colours = palette.of_robots(names)
        hull_colours = [colours[name] for name in names]
        parts: dict[str, tuple[Mesh, list[palette.Colour]]] = {
            "hull": (_hull(), hull_colours),
            "trim": (_trim(), [trim] * len(names)),
            "nose": (_nose(), [palette.NOSE] * len(names)),
            "jaws_left": (_jaw(), [trim] * len(names)),
            "jaws_right": (_jaw(), [trim] * len(names)),
        }
        self._parts = {
            part: add_instances(scene, f"/robots/{part}", mesh, [HIDDEN] * len(names), colours, visible=False)
            for part, (mesh, colours) in parts.items()
        }
        on_instance_click(self._parts["hull"], names, on_click)
        self._ranges = add_lines(scene, "/robots/whiskers", 0.018)
        self._trails = add_lines(scene, "/robots/trails", 0.03)
        self._drawn_trails: object = None

    def update(self, frame: Frame, selected: str | None) -> None:
        """Move the robots to their reported poses. Robots that were never heard stay hidden."""
        left, right = frame.jaws
        positions = {"jaws_left": left, "jaws_right": right}
        for part, handle in self._parts.items():
            handle.batched_positions = positions.get(part, frame.positions)
            handle.batched_wxyzs = frame.rotations
            if handle.visible != bool(frame.heard):
                handle.visible = bool(frame.heard)
        with_all = len(self._names) <= MAX_ROBOTS_WITH_RANGES
        points, colours = range_segments(
            [frame.robots[name] for name in frame.heard if with_all or name == selected]
        )
        self._ranges.points = points
        self._ranges.colors = colours
        if frame.trails is not self._drawn_trails:
            self._drawn_trails = frame.trails
            self._trails.points, self._trails.colors = frame.trail_segments


def label_text(name: str, robot: RobotTelemetry, now_s: float) -> str:
    """The robot's name and its active packet, or that it is not heard."""
    if now_s - robot.at_s > SILENT_AFTER_S:
        return f"{name} (not heard)"
    return f"{name}: {robot.packet_tag}" if robot.packet_tag else name


def _hull() -> Mesh:
    return merged([cylinder(RADIUS_M, 0.05, 0.15), cylinder(RADIUS_M, 0.15, HULL_TOP_M, top_radius_m=0.17)])


def _trim() -> Mesh:
    wheels = [box((0.13, 0.05, 0.12), (0.0, side * 0.19, 0.06)) for side in (-1, 1)]
    mast = cylinder(0.02, HULL_TOP_M, 0.34, sides=10)
    return merged([*wheels, mast, box((0.1, 0.2, 0.05), (RADIUS_M, 0.0, 0.09))])


def _nose() -> Mesh:
    """A white wedge on the deck that points ahead."""
    outline = [(0.16, 0.0), (-0.02, 0.08), (-0.02, -0.08)]
    vertices = [(x, y, z) for z in (HULL_TOP_M + 0.005, HULL_TOP_M + 0.025) for x, y in outline]
    faces = [(0, 2, 1), (3, 4, 5), (0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4), (2, 0, 3), (2, 3, 5)]
    return np.array(vertices, dtype=np.float32), np.array(faces, dtype=np.uint32)


def _jaw() -> Mesh:
    return box((0.2, 0.018, 0.07), (RADIUS_M + 0.11, 0.0, 0.1))
