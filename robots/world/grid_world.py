"""Makes a world of an occupancy grid: compartments, straight walls, round rocks, and a place and a robot to move."""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise, product
from math import ceil, dist, pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.world.ros_map import OccupancyGrid, RosMapError, read_ros_map
from robots.world.walls import WALL_THICKNESS_M

STAND_M = 0.5
"""Around a robot's middle so much is free where it starts; floor without such a point is left out."""
SPECK_M = 0.08
"""What is smaller across is noise, and left out."""
MAX_ROCK_M = 0.5
"""The greatest radius of what becomes a rock."""
JOIN_M = 0.5
"""Walls in one line are joined across what is occupied and no longer than this: the end of another wall."""
WITHIN_CELLS = 1.5
"""So far, in cells, a wall may lie from the middles of its cells: the steps of an oblique wall are as deep."""
MAX_BORDER = 400_000
MAX_PARTS = 2000
"""How many cell edges the border of the free floor may have, and how many walls and rocks a map may need."""

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Cell = tuple[int, int]
"""Column and row."""
Line = tuple[Cell, Cell]


def ros_map_world(file: Path) -> Mapping[str, Any]:
    """The content of a world file, from map.yaml.

    :raises RosMapError: if the map cannot be read, has no room for a robot, or is too ragged.
    """
    grid = read_ros_map(file)
    try:
        return grid_world(grid, name=_world_name(file.stem))
    except RosMapError as error:
        raise RosMapError(f"{file}: {error}") from error


def grid_world(grid: OccupancyGrid, *, name: str) -> Mapping[str, Any]:
    """The content of a world file: walls and rocks lie within `WITHIN_CELLS` of the occupied cells.

    Each connected part of the free floor becomes a compartment, its bounding rectangle. A place in each and a robot in
    the largest are placeholders.

    :raises RosMapError: if no robot has room, or more walls and rocks are needed than `MAX_PARTS`.
    """
    cell_m = grid.resolution_m
    free = np.pad(grid.free, 1)
    border = sum(int(np.count_nonzero(np.diff(free, axis=axis))) for axis in (0, 1))
    if border > MAX_BORDER:
        raise RosMapError(
            f"the border of the free floor has {border:,} cell edges, at most {MAX_BORDER:,} can be imported; "
            "remove noise from the map, or crop it"
        )
    floors, roomy = _floors(free, ceil(STAND_M / cell_m) + 1)
    if not floors:
        raise RosMapError(
            f"there is no free square of {2 * STAND_M:g} m, in which a robot can stand; check negate and free_thresh"
        )
    solid = np.ones_like(free)
    solid.ravel()[np.concatenate(floors)] = False
    rocks = list(_take_rocks(solid, cell_m))
    lines = _lines(solid, cell_m)
    if len(lines) + len(rocks) > MAX_PARTS:
        raise RosMapError(
            f"more than {MAX_PARTS} walls and rocks are needed; remove noise from the map, or crop it"
        )

    def metres(cells: Floats | Sequence[float]) -> Floats:
        """Points of the world from columns and rows, both shape (…, 2)."""
        x, y, yaw = grid.origin
        turned = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
        return np.asarray((np.asarray(cells) - 0.5) * cell_m @ turned + (x, y), dtype=np.float64)

    def point(cells: Floats | Sequence[float]) -> list[float]:
        return [round(float(value), 3) for value in metres(cells)]

    def cells_of(indices: NDArray[np.int64]) -> Floats:
        return np.stack((indices % free.shape[1], indices // free.shape[1]), axis=1).astype(np.float64)

    compartments, places, stands = [], [], []
    for number, floor in enumerate(floors, start=1):
        last_of_row = np.flatnonzero(np.diff(floor // free.shape[1], append=-1))
        ends = cells_of(floor[np.concatenate(([0], last_of_row, last_of_row[:-1] + 1))])
        corners = [metres(ends + np.array(at)) for at in product((-0.5, 0.5), repeat=2)]
        low, high = (np.round(side(corners, axis=(0, 1)), 3).tolist() for side in (np.min, np.max))
        compartments.append({"name": f"floor_{number}", "x": [low[0], high[0]], "y": [low[1], high[1]]})
        standing = cells_of(floor[roomy[floor]])
        stands.append(standing[0])
        at = point(standing[-1])
        places.append(
            {"name": f"place_{number}", "kind": "place", "at": at, "approach_deg": [0, 90, 180, -90]}
        )
    return {
        "name": name,
        "title": f"{name}, imported; the places and robot_1 are placeholders to be moved",
        "compartments": compartments,
        "walls": [{"start": point(start), "end": point(end)} for start, end in map(_to_cell_edges, lines)],
        "obstacles": [
            {"name": f"rock_{number}", "at": point(middle), "radius_m": round(radius * cell_m, 3)}
            for number, (middle, radius) in enumerate(rocks, start=1)
        ],
        "locations": places,
        "robots": [{"name": "robot_1", "compartment": "floor_1", "start": [*point(stands[0]), 0]}],
    }


def _world_name(stem: str) -> str:
    name = re.sub(r"[^a-z0-9]+", "_", stem.lower()).strip("_")
    return (name if name[:1].isalpha() else f"map_{name}".rstrip("_"))[:64]


def _floors(free: Bools, reach: int) -> tuple[list[NDArray[np.int64]], Bools]:
    """The connected parts of the free floor in which a robot has room, as flat indices, largest first; and where, flat.

    :param reach: number of cells around that must be free.
    """
    rows, columns = free.shape
    roomy = np.zeros_like(free)
    if min(rows, columns) > 2 * reach:
        sums = np.pad(np.cumsum(np.cumsum(free, axis=0, dtype=np.int64), axis=1), ((1, 0), (1, 0)))
        side = 2 * reach + 1
        inside = sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side]
        roomy[reach : rows - reach, reach : columns - reach] = inside == side**2
    flat = roomy.ravel()
    parts = [part for part in _parts(free, diagonal=False) if flat[part].any()]
    return sorted(parts, key=len, reverse=True), flat


def _parts(cells: Bools, *, diagonal: bool) -> list[NDArray[np.int64]]:
    """The flat indices of each connected part of the true cells: runs of a row that touch one of the row before."""
    columns = cells.shape[1] + 1
    flat = np.pad(cells, ((0, 0), (0, 1))).ravel().astype(np.int8)
    steps = np.diff(flat, prepend=0)
    starts, ends = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    first = np.searchsorted(ends, starts - columns - diagonal, side="right")
    last = np.searchsorted(starts, ends - columns + diagonal, side="left")
    root = list(range(len(starts)))

    def find(run: int) -> int:
        while root[run] != run:
            root[run] = root[root[run]]
            run = root[run]
        return run

    for run, (low, high) in enumerate(zip(first.tolist(), last.tolist(), strict=True)):
        for other in range(low, high):
            root[find(run)] = find(other)
    owners = np.repeat([find(run) for run in root], ends - starts)
    indices = np.flatnonzero(flat)
    order = np.argsort(owners, kind="stable")
    indices = (indices - indices // columns)[order]
    return [part for part in np.split(indices, np.flatnonzero(np.diff(owners[order])) + 1) if len(part)]


def _take_rocks(solid: Bools, cell_m: float) -> Iterator[tuple[Floats, float]]:
    """Clear specks and round things of the solid cells; yields the middle and radius of each round one, in cells.

    Round is what has a circle around it whose radius is at most a cell greater than that of a circle of the same area.
    """
    for part in _parts(solid, diagonal=True):
        rows, columns = np.divmod(part, solid.shape[1])
        cells = np.stack((columns, rows), axis=1)
        middle = (cells.min(axis=0) + cells.max(axis=0)) / 2
        radius = float(np.hypot(*(cells - middle).T).max()) + 0.5
        is_speck = 2 * radius * cell_m < SPECK_M
        is_round = radius * cell_m <= MAX_ROCK_M and radius <= sqrt(len(part) / pi) + 1
        if is_speck or is_round:
            solid.ravel()[part] = False
        if is_round and not is_speck:
            yield middle, radius


def _lines(solid: Bools, cell_m: float) -> list[Line]:
    """Walls along the solid cells at the free floor, from cell to cell, longest first.

    No cell of the border is farther from its wall than `WITHIN_CELLS`, or than a wall is thick, whichever is more. A
    wall that lies within another's thickness, as the two faces of a thin wall do, is left out.
    """
    tolerance = max(WITHIN_CELLS, WALL_THICKNESS_M / cell_m)
    pairs = {pair for outline in _outlines(solid) for pair in pairwise(_corners(outline, tolerance))}
    lines = {_straightened(min(pair), max(pair), solid) for pair in pairs if pair[0] != pair[1]}
    joined = sorted(_joined(lines, solid, ceil(JOIN_M / cell_m)), key=lambda line: (-dist(*line), line))
    cover = (cell_m + WALL_THICKNESS_M) / 2 / cell_m + 1e-9
    low, high = (side(np.array(joined), axis=1) for side in (np.min, np.max))
    kept: list[int] = []
    for index, line in enumerate(joined):
        is_near = (low[kept] <= high[index] + cover) & (high[kept] >= low[index] - cover)
        start, end = np.array(line, dtype=np.float64)
        points = np.linspace(start, end, 2 * ceil(dist(*line)) + 1)
        nearest = np.full(len(points), np.inf)
        for other in np.array(kept, dtype=np.int64)[is_near.all(axis=1)]:
            np.minimum(nearest, _distances(points, *joined[other]), out=nearest)
        if nearest.max() > cover:
            kept.append(index)
    return [joined[index] for index in kept]


def _outlines(solid: Bools) -> Iterator[NDArray[np.int64]]:
    """The solid cells along each closed border of the free floor, in order, shape (n, 2), first cell repeated as last.

    A border is followed with the free cells on the left: side by side of the free cells, south, east, north, west.
    """
    columns = solid.shape[1]
    steps = (-columns, 1, columns, -1)
    flat = solid.tobytes()
    free = np.flatnonzero(~solid)
    begun = [(cell, side) for side in range(4) for cell in free[solid.ravel()[free + steps[side]]].tolist()]
    seen: set[tuple[int, int]] = set()
    for first_state in begun:
        state = first_state
        chain: list[int] = []
        while state not in seen:
            seen.add(state)
            cell, side = state
            beside, ahead = steps[side], steps[(side + 1) % 4]
            chain.append(cell + beside)
            if flat[cell + ahead]:
                if flat[cell + ahead + beside]:
                    chain.append(cell + ahead + beside)
                state = (cell, (side + 1) % 4)
            elif flat[cell + ahead + beside]:
                state = (cell + ahead, side)
            else:
                state = (cell + ahead + beside, (side - 1) % 4)
        if chain:
            first = chain.index(min(chain))
            cells = np.array([*chain[first:], *chain[: first + 1]])
            yield np.stack((cells % columns, cells // columns), axis=1)


def _corners(outline: NDArray[np.int64], tolerance: float) -> list[Cell]:
    """The corners of a polygon within `tolerance` cells of the outline (Ramer, Douglas and Peucker)."""
    away = np.abs(outline - outline[0]).sum(axis=1)
    corners = {0, len(outline) - 1}
    open_spans = [(0, int(away.argmax())), (int(away.argmax()), len(outline) - 1)]
    while open_spans:
        first, last = open_spans.pop()
        corners |= {first, last}
        distances = _distances(outline[first : last + 1], outline[first], outline[last])
        worst = int(distances.argmax())
        if distances[worst] > tolerance:
            open_spans += [(first, first + worst), (first + worst, last)]
    return [(int(outline[index][0]), int(outline[index][1])) for index in sorted(corners)]


def _straightened(start: Cell, end: Cell, solid: Bools) -> Line:
    """The line, along a row or column if it is off by a cell and one of the two is solid all along."""
    (x, y), (to_x, to_y) = start, end
    low, high = min(y, to_y), max(y, to_y)
    if to_x - x == 1 < high - low:
        for column in (x, to_x):
            if solid[low : high + 1, column].all():
                return (column, low), (column, high)
    elif high - low == 1 < to_x - x:
        for row in (y, to_y):
            if solid[row, x : to_x + 1].all():
                return (x, row), (to_x, row)
    return start, end


def _joined(lines: Iterable[Line], solid: Bools, gap: int) -> Iterator[Line]:
    """The lines; those along one row or column are one where they touch, or only up to `gap` solid cells part them."""
    along: defaultdict[tuple[bool, int], list[Cell]] = defaultdict(list)
    for start, end in lines:
        if start[1] == end[1]:
            along[False, start[1]].append((start[0], end[0]))
        elif start[0] == end[0]:
            along[True, start[0]].append((start[1], end[1]))
        else:
            yield start, end
    for (upright, at), spans in along.items():
        cells = solid[:, at] if upright else solid[at]
        low, high = min(spans)
        for first, last in [*sorted(spans), (len(cells) + gap + 1,) * 2]:
            if first > high + 1 and not (first - high <= gap and cells[high:first].all()):
                yield ((at, low), (at, high)) if upright else ((low, at), (high, at))
                low = first
            high = max(high, last)


def _to_cell_edges(line: Line) -> Floats:
    """The line's ends, which are the middles of cells, each half a cell farther out."""
    start, end = np.array(line, dtype=np.float64)
    half = (end - start) / (2 * dist(*line))
    return np.stack((start - half, end + half))


def _distances(points: NDArray[Any], start: Any, end: Any) -> Floats:
    """From each point, shape (n, 2), to the straight line between two."""
    origin = np.asarray(start, dtype=np.float64)
    along = np.asarray(end) - origin
    shares = np.clip((points - origin) @ along / max(float(along @ along), 1e-12), 0, 1)
    offsets = points - origin - shares[:, None] * along
    return np.asarray(np.hypot(offsets[:, 0], offsets[:, 1]))
