"""A plan's routes: a line for each robot from place to place, in the plan's order.

The lines are straight: the plan does not contain how robots avoid obstacles between two places.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import viser

from web.api_types import Layout, Plan, Point
from web.scene import palette
from web.scene.geometry import cylinder, segments
from web.scene.nodes import add_instances

HEIGHT_M = 0.03
ARROW_M = 0.24
APART_M = 0.045
"""Distance between the lines of two robots on the same route."""
FAINT = 0.45
"""Share of the colour of legs that do not belong to the selected action."""

Leg = tuple[str, Point, Point]
"""The action, start and end."""


def routes(plan: Plan, layout: Layout) -> dict[str, list[Leg]]:
    """Each robot's legs in the plan's order: every action takes it to the last place of its arguments."""
    at = {place.name: place.at for place in layout.locations}
    here: dict[str, Point] = {}
    legs: dict[str, list[Leg]] = {}
    for action in sorted(plan.actions, key=lambda action: action.earliest_start_s):
        stops = [at[name] for name in action.arguments.values() if name in at]
        for robot in action.agents if stops else ():
            begin = here.get(robot, stops[0])
            if begin != stops[-1]:
                legs.setdefault(robot, []).append((action.id, begin, stops[-1]))
            here[robot] = stops[-1]
    return legs


class PathsView:
    """Draws the planned routes as lines with arrow heads."""

    def __init__(self, scene: viser.SceneApi, names: Sequence[str], theme: palette.Theme) -> None:
        self._scene = scene
        self._theme = theme
        self._names = tuple(names)
        self._hues = palette.of_robots(names)
        self._drawn: object = None
        self._lines: viser.LineSegmentsHandle | None = None
        self._heads: viser.BatchedMeshHandle | None = None

    def update(self, plan: Plan | None, layout: Layout, action: str | None) -> None:
        """Draw the plan's routes, and the selected action's legs stronger than the others."""
        if self._drawn == (plan and plan.id, action):
            return
        self._drawn = (plan and plan.id, action)
        for handle in (self._lines, self._heads):
            if handle is not None:
                handle.remove()
        self._lines = None
        self._heads = None
        if plan is not None:
            self._draw(routes(plan, layout), action)

    def _draw(self, legs: Mapping[str, Sequence[Leg]], action: str | None) -> None:
        selected = action if any(action == leg[0] for way in legs.values() for leg in way) else None
        lines = []
        heads = []
        headings = []
        colours = []
        for robot, way in legs.items():
            lane = APART_M * (1 + self._names.index(robot) % 4 if robot in self._names else 0)
            for id_, begin, end in way:
                start, stop, heading = _beside(begin, end, lane)
                colour = self._hues.get(robot, self._theme.trim)
                if selected is not None and id_ != selected:
                    colour = palette.faded(colour, FAINT, self._theme)
                lines.append(([start, stop], colour))
                heads.append(((start[0] + stop[0]) / 2, (start[1] + stop[1]) / 2, HEIGHT_M))
                headings.append(heading)
                colours.append(colour)
        if not lines:
            return
        points, shades = segments(lines, HEIGHT_M)
        self._lines = self._scene.add_line_segments("/plan/ways", points, shades, thickness=0.045)
        head = cylinder(ARROW_M * 0.62, -0.005, 0.005, sides=3)  # points east
        self._heads = add_instances(self._scene, "/plan/heads", head, heads, colours, headings_rad=headings)


def _beside(begin: Point, end: Point, lane: float) -> tuple[Point, Point, float]:
    """The leg shifted to the right of its direction, and that direction, radians."""
    heading = float(np.arctan2(end[1] - begin[1], end[0] - begin[0]))
    dx = lane * float(np.sin(heading))
    dy = -lane * float(np.cos(heading))
    return (begin[0] + dx, begin[1] + dy), (end[0] + dx, end[1] + dy), heading
