"""The rovers: one batched node a part, one node for all whiskers, a label each."""

from collections.abc import Mapping, Sequence
from math import cos, pi, sin

import numpy as np
import viser

from web.layout import RobotTelemetry
from web.scene import palette
from web.scene.geometry import Floats, Mesh, box, cylinder, merged, turned

RADIUS_M = 0.22
HULL_TOP_M = 0.2
WHISKER_HEIGHT_M = 0.12
LABEL_HEIGHT_M = 0.5
JAW_OPEN_M, JAW_CLOSED_M = 0.095, 0.068
QUIET_AFTER_S = 5.0
"""A robot whose newest telemetry is older than this is labelled as not heard."""


class RobotsView:
    """Draws the robots it was made for, at the places telemetry tells."""

    def __init__(self, server: viser.ViserServer, names: Sequence[str]) -> None:
        self._names = tuple(names)
        count = len(names)
        colours = [palette.ROBOTS[index % len(palette.ROBOTS)] for index in range(count)]
        self._turns = turned([0.0] * count)
        self._places = np.zeros((count, 3), dtype=np.float32)
        parts: dict[str, tuple[Mesh, list[palette.Colour]]] = {
            "hull": (_hull(), colours),
            "trim": (_trim(), [palette.TRIM] * count),
            "nose": (_nose(), [palette.NOSE] * count),
            "jaws_left": (_jaw(), [palette.TRIM] * count),
            "jaws_right": (_jaw(), [palette.TRIM] * count),
        }
        self._parts = {
            part: server.scene.add_batched_meshes_simple(
                f"/robots/{part}",
                *mesh,
                batched_wxyzs=self._turns,
                batched_positions=self._places,
                batched_colors=palette.batched(colour),
                visible=False,
                lod="off",
                cast_shadow=False,
                receive_shadow=False,
            )
            for part, (mesh, colour) in parts.items()
        }
        self._whiskers = server.scene.add_line_segments(
            "/robots/whiskers",
            np.zeros((1, 2, 3), dtype=np.float32),
            np.zeros((1, 2, 3), dtype=np.uint8),
            thickness=0.018,
        )
        self._labels = {
            name: server.scene.add_label(
                f"/robots/{name}/label", name, anchor="bottom-center", font_screen_scale=0.95, visible=False
            )
            for name in names
        }

    def update(self, robots: Mapping[str, RobotTelemetry], now_s: float) -> None:
        """Move everything to where the robots say they are. Robots never heard of stay unseen."""
        heard = [name for name in self._names if name in robots]
        for name in heard:
            told, label = robots[name], self._labels[name]
            label.position = (told.x_m, told.y_m, LABEL_HEIGHT_M)
            _set_changed(label, "text", label_text(name, told, now_s))
            _set_changed(label, "visible", True)
        self._place_parts(robots)
        points, colours = whiskers([robots[name] for name in heard])
        self._whiskers.points, self._whiskers.colors = points, colours

    def _place_parts(self, robots: Mapping[str, RobotTelemetry]) -> None:
        self._places[:, 2] = -10.0  # the unheard wait below the floor, so that all parts keep their count
        heard = [(index, robots[name]) for index, name in enumerate(self._names) if name in robots]
        for index, robot in heard:
            self._turns[index] = turned([robot.heading_rad])[0]
        for part, handle in self._parts.items():
            for index, robot in heard:
                self._places[index] = (*_part_place(part, robot), 0.0)
            handle.batched_positions = self._places.copy()
            handle.batched_wxyzs = self._turns.copy()
            _set_changed(handle, "visible", bool(heard))


def label_text(name: str, told: RobotTelemetry, now_s: float) -> str:
    """The robot's name and its active packet, or that it has not been heard of late."""
    if now_s - told.at_s > QUIET_AFTER_S:
        return f"{name} (not heard)"
    return f"{name}: {told.packet_tag}" if told.packet_tag else name


def whiskers(
    robots: Sequence[RobotTelemetry],
) -> tuple[Floats, np.ndarray[tuple[int, ...], np.dtype[np.uint8]]]:
    """Segments from the hull to what each beam meets, shape (N, 2, 3), and their colours, of that shape too.

    A beam that meets nothing is a stub, so that the count stays the same from one update to the next.
    """
    points, colours = [(0.0, 0.0, -10.0)] * 2, [palette.WHISKER_FREE] * 2
    for robot in robots:
        for index, range_m in enumerate(robot.ranges_m):
            heading = robot.heading_rad + 2 * pi * index / len(robot.ranges_m)
            reach = RADIUS_M + 0.06 if range_m is None else max(range_m, RADIUS_M)
            for length in (RADIUS_M, reach):
                points.append(
                    (robot.x_m + length * cos(heading), robot.y_m + length * sin(heading), WHISKER_HEIGHT_M)
                )
            colours += [
                palette.WHISKER_FREE,
                palette.WHISKER_FREE if range_m is None else palette.WHISKER_HIT,
            ]
    shape = (-1, 2, 3)
    return np.array(points, dtype=np.float32).reshape(shape), np.array(colours, dtype=np.uint8).reshape(shape)


def _part_place(part: str, robot: RobotTelemetry) -> tuple[float, float]:
    if not part.startswith("jaws"):
        return robot.x_m, robot.y_m
    aside = (JAW_CLOSED_M if robot.holding else JAW_OPEN_M) * (1 if part == "jaws_left" else -1)
    return robot.x_m - aside * sin(robot.heading_rad), robot.y_m + aside * cos(robot.heading_rad)


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


def _set_changed(handle: object, slot: str, value: object) -> None:
    """Spare the clients a message when nothing changes."""
    if getattr(handle, slot) != value:
        setattr(handle, slot, value)
