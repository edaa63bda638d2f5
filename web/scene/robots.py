"""The rovers: one batched node a part, one node for whiskers, one for trails."""

from collections.abc import Sequence

import numpy as np
import viser

from web.api_types import RobotTelemetry
from web.scene import palette
from web.scene.frame import RADIUS_M, Frame, whiskers
from web.scene.geometry import Floats, Mesh, box, cylinder, merged, segments, turned
from web.scene.nodes import Click, on_instance

HULL_TOP_M = 0.2
LABEL_HEIGHT_M = 0.5
TRAIL_HEIGHT_M = 0.015
QUIET_AFTER_S = 5.0
"""A robot whose newest telemetry is older than this is labelled as not heard."""
ALL_WHISKERS = 16
"""In a world with more robots than this, only the selected one's whiskers are drawn."""


class RobotsView:
    """Draws the robots it was made for, as a frame has them."""

    def __init__(
        self, scene: viser.SceneApi, names: Sequence[str], trim: palette.Colour, on_click: Click
    ) -> None:
        count = len(names)
        self._names = tuple(names)
        hues = palette.of_robots(names)
        colours = [hues[name] for name in names]
        looks: dict[str, tuple[Mesh, list[palette.Colour]]] = {
            "hull": (_hull(), colours),
            "trim": (_trim(), [trim] * count),
            "nose": (_nose(), [palette.NOSE] * count),
            "jaws_left": (_jaw(), [trim] * count),
            "jaws_right": (_jaw(), [trim] * count),
        }
        self._parts = {
            part: scene.add_batched_meshes_simple(
                f"/robots/{part}",
                *mesh,
                batched_wxyzs=turned([0.0] * count),
                batched_positions=np.zeros((count, 3), dtype=np.float32),
                batched_colors=palette.batched(colour),
                visible=False,
                lod="off",
                cast_shadow=False,
                receive_shadow=False,
            )
            for part, (mesh, colour) in looks.items()
        }
        on_instance(self._parts["hull"], names, on_click)
        self._whiskers = _lines(scene, "/robots/whiskers", 0.018)
        self._trails = _lines(scene, "/robots/trails", 0.03)
        self._trailed: object = None

    def update(self, frame: Frame, selected: str | None) -> None:
        """Move everything to where the robots say they are. Robots never heard of stay unseen."""
        left, right = frame.jaws
        places = {"jaws_left": left, "jaws_right": right}
        for part, handle in self._parts.items():
            handle.batched_positions = places.get(part, frame.places)
            handle.batched_wxyzs = frame.turns
            if handle.visible != bool(frame.heard):
                handle.visible = bool(frame.heard)
        everyone = len(self._names) <= ALL_WHISKERS
        feeling = [frame.robots[name] for name in frame.heard if everyone or name == selected]
        self._whiskers.points, self._whiskers.colors = whiskers(feeling)
        if frame.trails is not self._trailed:
            self._trailed = frame.trails
            self._draw_trails(frame)

    def _draw_trails(self, frame: Frame) -> None:
        hues = palette.of_robots(self._names)
        lines = {name: way for name, way in frame.trails.items() if len(way) > 1 and name in hues}
        points, colours = segments([(way, hues[name]) for name, way in lines.items()], TRAIL_HEIGHT_M)
        self._trails.points, self._trails.colors = points, colours


def label_text(name: str, told: RobotTelemetry, now_s: float) -> str:
    """The robot's name and its active packet, or that it has not been heard of late."""
    if now_s - told.at_s > QUIET_AFTER_S:
        return f"{name} (not heard)"
    return f"{name}: {told.packet_tag}" if told.packet_tag else name


def _lines(scene: viser.SceneApi, name: str, thickness: float) -> viser.LineSegmentsHandle:
    nothing: Floats = np.zeros((1, 2, 3), dtype=np.float32)
    return scene.add_line_segments(name, nothing, nothing.astype(np.uint8), thickness=thickness)


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
