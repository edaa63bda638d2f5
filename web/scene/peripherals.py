"""Doors, hatches and lifts: a panel where each is closed, raised where it is open."""

from collections.abc import Sequence
from math import atan2, cos, dist, sin

import viser

from web.api_types import Fact, Layout, Point
from web.scene import palette
from web.scene.building import WALL_HEIGHT_M, WALL_WIDTH_M
from web.scene.geometry import box
from web.scene.nodes import add_mesh

PANEL_HEIGHT_M = 0.9 * WALL_HEIGHT_M
RAISED_M = WALL_HEIGHT_M
"""How far the panel of an open door is raised above where it closes."""


def panels_of(layout: Layout) -> dict[Fact, tuple[Point, Point]]:
    """Each panel's ends, metres, by the fact that says that it is open."""
    found: dict[Fact, tuple[Point, Point]] = {}
    for one in layout.peripherals:
        if one.start is not None and one.end is not None:
            found[Fact(predicate="opened", args=(one.name,))] = (one.start, one.end)
        found |= {
            Fact(predicate="lift_at", args=(one.name, stop.level)): (stop.start, stop.end)
            for stop in one.stops
        }
    return found


class PeripheralsView:
    """The panels, one node each; they are moved when facts say that they stand otherwise."""

    def __init__(self, scene: viser.SceneApi, layout: Layout) -> None:
        self._panels: dict[Fact, viser.MeshHandle] = {}
        self._middles: dict[Fact, Point] = {}
        self._open: frozenset[Fact] = frozenset()
        for fact, (start, end) in panels_of(layout).items():
            self._add(scene, fact, start, end)

    def update(self, facts: Sequence[Fact]) -> None:
        """Show which panels are open, by the facts."""
        is_open = frozenset(fact for fact in facts if fact in self._panels)
        for fact in is_open ^ self._open:
            x, y = self._middles[fact]
            self._panels[fact].position = (x, y, RAISED_M if fact in is_open else 0.0)
        self._open = is_open

    def _add(self, scene: viser.SceneApi, is_open: Fact, start: Point, end: Point) -> None:
        middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
        shape = box((dist(start, end), WALL_WIDTH_M, PANEL_HEIGHT_M), (0.0, 0.0, PANEL_HEIGHT_M / 2))
        panel = add_mesh(
            scene,
            f"/peripherals/{'/'.join(is_open.args)}",
            shape,
            palette.OPENINGS["door"],
            (*middle, 0.0),
        )
        heading_rad = atan2(end[1] - start[1], end[0] - start[0])
        panel.wxyz = (cos(heading_rad / 2), 0.0, 0.0, sin(heading_rad / 2))
        self._panels[is_open] = panel
        self._middles[is_open] = middle
