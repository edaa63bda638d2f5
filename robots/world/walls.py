"""The solid parts of walls: pieces between hatches and gaps, and the panels of closed doors."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import hypot

from robots.world.parts import Point, Wall

WALL_THICKNESS_M = 0.08


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """A straight solid piece of wall, or a door's panel; metres in the world's frame."""

    start: Point
    end: Point
    door: bool = False

    @property
    def length_m(self) -> float:
        return hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])

    def distance_m(self, point: Point) -> float:
        """From a point to the panel's middle line."""
        along = _along(self.start, self.end, point)
        nearest = _between(self.start, self.end, min(1.0, max(0.0, along)))
        return hypot(point[0] - nearest[0], point[1] - nearest[1])


def panels_of(walls: Iterable[Wall]) -> tuple[Panel, ...]:
    """Every solid piece of the walls."""
    return tuple(panel for wall in walls for panel in solid_pieces(wall))


def solid_pieces(wall: Wall) -> tuple[Panel, ...]:
    """Split a wall at its openings. Hatches and gaps are left free, a door is closed by its own panel."""
    pieces: list[Panel] = []
    reached_m = 0.0
    for opening in sorted(wall.openings, key=lambda each: each.at_m):
        low_m = opening.at_m - opening.width_m / 2
        high_m = opening.at_m + opening.width_m / 2
        pieces.append(_piece(wall, reached_m, low_m))
        if opening.kind == "door":
            pieces.append(_piece(wall, max(reached_m, low_m), high_m, door=True))
        reached_m = max(reached_m, high_m)
    pieces.append(_piece(wall, reached_m, wall.length_m))
    return tuple(piece for piece in pieces if piece.length_m > 1e-6)


def clearance_m(point: Point, panels: Iterable[Panel]) -> float:
    """From a point to the surface of the nearest panel; infinite without panels."""
    return min((panel.distance_m(point) for panel in panels), default=float("inf")) - WALL_THICKNESS_M / 2


def _piece(wall: Wall, from_m: float, to_m: float, *, door: bool = False) -> Panel:
    if to_m <= from_m:
        return Panel(start=wall.start, end=wall.start)
    start = _between(wall.start, wall.end, from_m / wall.length_m)
    return Panel(start=start, end=_between(wall.start, wall.end, to_m / wall.length_m), door=door)


def _between(start: Point, end: Point, share: float) -> Point:
    return (start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1]))


def _along(start: Point, end: Point, point: Point) -> float:
    dx = end[0] - start[0]
    dy = end[1] - start[1]
    return ((point[0] - start[0]) * dx + (point[1] - start[1]) * dy) / (dx * dx + dy * dy)
