"""Rays in a plane against a horizontal cross-section of the scene. Compiled (numba).

Arrays: boxes: shape (B, 6): middle x, y, cosine and sine of the heading, half length along it, half width, metres.
discs: shape (D, 3): middle x, y, radius. A body's number is its row among the boxes; discs count on after them. The
physics engine casts the same rays in three dimensions, at about 8 µs each; a batch here takes about a hundredth of
that, because bodies are sorted into cells, and a ray meets only those of the cells that it crosses.
"""

from math import floor, inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robots.compiled import kernel, part

Floats = NDArray[np.float64]
Ray = tuple[float, float, float, float]
"""Its start x, y, and the vector to its end, metres."""
FREE = 1.0
"""The share of a ray that meets nothing."""


class Cut(NamedTuple):
    """A cross-section at one height: boxes and discs as above."""

    boxes: Floats
    discs: Floats


class Cells(NamedTuple):
    """Cells over a cross-section, in columns and rows, and the bodies in each: those whose bounds overlap it."""

    left: float
    """Least x of the first column; `low` is the least y of the first row."""
    low: float
    width_m: float
    """Of a column; `height_m` is that of a row."""
    height_m: float
    columns: int
    rows: int
    starts: NDArray[np.int64]
    """Shape (columns * rows + 1,): cell c holds `bodies[starts[c]]` to `bodies[starts[c + 1]]`."""
    bodies: NDArray[np.int64]
    bounds: Floats
    """Shape (bodies, 4): least x and y, greatest x and y of each body."""


CELL_M = 2.0
"""Width and height of a cell, unless there would be more than `MAX_CELLS` of them side by side."""
MAX_CELLS = 64
STEEP_M = 1e-2
"""A ray that goes no farther than this to the east or west is looked for in whole columns."""
SLACK_M = 1e-6
"""Added to bounds, so that rounding puts no ray beside a body that it grazes."""
CLEARANCE_M = 0.3
"""A view with so much room beside it is not tested again before its ends have moved as far."""


@kernel
def cells_of(cut: Cut) -> Cells:
    """Sort the bodies of a cross-section into cells."""
    bounds = _bounds(cut)
    left = low = inf
    right = high = -inf
    for n in range(len(bounds)):
        left = min(left, bounds[n, 0])
        low = min(low, bounds[n, 1])
        right = max(right, bounds[n, 2])
        high = max(high, bounds[n, 3])
    if len(bounds) == 0:
        left = low = right = high = 0.0
    width_m = max(CELL_M, (right - left) / MAX_CELLS)
    height_m = max(CELL_M, (high - low) / MAX_CELLS)
    columns = int((right - left) / width_m) + 1
    rows = int((high - low) / height_m) + 1
    starts = np.zeros(columns * rows + 1, np.int64)
    spans = np.empty((len(bounds), 4), np.int64)
    for n in range(len(bounds)):
        spans[n, 0] = int((bounds[n, 0] - left) / width_m)
        spans[n, 1] = int((bounds[n, 1] - low) / height_m)
        spans[n, 2] = int((bounds[n, 2] - left) / width_m)
        spans[n, 3] = int((bounds[n, 3] - low) / height_m)
        for column in range(spans[n, 0], spans[n, 2] + 1):
            for row in range(spans[n, 1], spans[n, 3] + 1):
                starts[column * rows + row + 1] += 1
    for cell in range(columns * rows):
        starts[cell + 1] += starts[cell]
    bodies = np.empty(starts[-1], np.int64)
    filled = starts[:-1].copy()
    for n in range(len(bounds)):
        for column in range(spans[n, 0], spans[n, 2] + 1):
            for row in range(spans[n, 1], spans[n, 3] + 1):
                cell = column * rows + row
                bodies[filled[cell]] = n
                filled[cell] += 1
    return Cells(left, low, width_m, height_m, columns, rows, starts, bodies, bounds)


@part
def _bounds(cut: Cut) -> Floats:
    """As `Cells.bounds`."""
    boxes, discs = cut
    bounds = np.empty((len(boxes) + len(discs), 4))
    for n in range(len(bounds)):
        if n < len(boxes):
            x, y, cosine, sine, half_length, half_width = boxes[n]
            half_x = abs(cosine) * half_length + abs(sine) * half_width + SLACK_M
            half_y = abs(sine) * half_length + abs(cosine) * half_width + SLACK_M
        else:
            x, y, radius = discs[n - len(boxes)]
            half_x = half_y = radius + SLACK_M
        bounds[n, 0] = x - half_x
        bounds[n, 1] = y - half_y
        bounds[n, 2] = x + half_x
        bounds[n, 3] = y + half_y
    return bounds


@kernel
def free_shares(cut: Cut, starts: Floats, ends: Floats, fans: NDArray[np.int64]) -> Floats:
    """The share of each ray that is free, 1 where nothing is hit, 0 where it begins within something solid.

    :param starts, ends: shape (N, 2), metres.
    :param fans: shape (F + 1,): the rays `fans[f]` to `fans[f + 1]` begin near each other.
    """
    cells = cells_of(cut)
    free = np.ones(len(starts))
    in_fan = np.full(len(cut.boxes) + len(cut.discs), -1)
    near_bodies = np.empty(len(in_fan), np.int64)
    for fan in range(len(fans) - 1):
        first = fans[fan]
        last = fans[fan + 1]
        if first == last:
            continue
        near_count = 0
        left, low, right, high = _extent(starts[first:last], ends[first:last])
        for column in range(*_span(left, right, cells.left, cells.width_m, cells.columns)):
            for row in range(*_span(low, high, cells.low, cells.height_m, cells.rows)):
                cell = column * cells.rows + row
                for at in range(cells.starts[cell], cells.starts[cell + 1]):
                    n = cells.bodies[at]
                    if in_fan[n] == fan:
                        continue
                    in_fan[n] = fan
                    body_left, body_low, body_right, body_high = cells.bounds[n]
                    if body_left <= right and body_right >= left and body_low <= high and body_high >= low:
                        near_bodies[near_count] = n
                        near_count += 1
        for ray in range(first, last):
            share = 1.0
            path = _ray(starts, ray, ends, ray)
            for at in range(near_count):
                share = min(share, _to_body(cut, near_bodies[at], path))
            free[ray] = share
    return free


@part
def _extent(starts: Floats, ends: Floats) -> tuple[float, float, float, float]:
    """Least x and y, greatest x and y of rays."""
    left = low = inf
    right = high = -inf
    for ray in range(len(starts)):
        left = min(left, starts[ray, 0], ends[ray, 0])
        low = min(low, starts[ray, 1], ends[ray, 1])
        right = max(right, starts[ray, 0], ends[ray, 0])
        high = max(high, starts[ray, 1], ends[ray, 1])
    return left, low, right, high


@part
def _span(least: float, greatest: float, origin: float, side_m: float, count: int) -> tuple[int, int]:
    """The cells of a row or column that an interval overlaps: the first, and the one after the last."""
    return max(0, floor((least - origin) / side_m)), min(count, floor((greatest - origin) / side_m) + 1)


class Views(NamedTuple):
    """What is remembered of the views from R observers to E emitters. It saves time only."""

    blocker: NDArray[np.int64]
    """Shape (R, E): the body that blocked the view last; most stay hidden by the same wall."""
    clear_m: Floats
    """Shape (R, E): the view is clear until the travels of its ends together are as long."""
    observers_m: Floats
    """Shape (R,): how far each observer has moved; `emitters_m`, shape (E,), likewise."""
    emitters_m: Floats


class LinesOfSight:
    """Which of R observers see which of E emitters, from tick to tick."""

    def __init__(self, observers: int, emitters: int) -> None:
        self._views = Views(
            np.zeros((observers, emitters), np.int64),
            np.zeros((observers, emitters)),
            np.zeros(observers),
            np.zeros(emitters),
        )
        self._cut = Cut(np.empty((0, 6)), np.empty((0, 3)))
        self._at = (np.zeros((observers, 2)), np.zeros((emitters, 2)))

    def read(
        self, cut: Cut, observers: Floats, emitters: Floats, reach_m: Floats, known: NDArray[np.bool_]
    ) -> NDArray[np.int64]:
        """Pairs of indices, shape (N, 2), by observer and then by emitter.

        :param observers, emitters: shape (R, 2) and (E, 2), metres. :param reach_m: shape (E,).
        :param known: shape (R, E): the pairs that matter.
        """
        if not all(map(np.array_equal, cut, self._cut)):
            self._views.clear_m.fill(0.0)
        at = (observers, emitters)
        for travel_m, now, before in zip(self._views[2:], at, self._at, strict=True):
            np.add(travel_m, np.hypot(*(now - before).T), out=travel_m)
        self._cut = cut
        self._at = at
        return _in_sight(cut, observers, emitters, reach_m, known, self._views)


@kernel
def _in_sight(
    cut: Cut, observers: Floats, emitters: Floats, reach_m: Floats, known: NDArray[np.bool_], views: Views
) -> NDArray[np.int64]:
    cells = cells_of(cut)
    wide = _widened(cut)
    wide_cells = cells_of(wide)
    bodies = len(cut.boxes) + len(cut.discs)
    blocker = views.blocker
    clear_m = views.clear_m
    seen = np.empty((known.sum(), 2), np.int64)
    found = 0
    for r in range(len(observers)):
        for e in range(len(emitters)):
            if not known[r, e]:
                continue
            ray = _ray(observers, r, emitters, e)
            if ray[2] * ray[2] + ray[3] * ray[3] > reach_m[e] * reach_m[e]:
                continue
            travel_m = views.observers_m[r] + views.emitters_m[e]
            if travel_m >= clear_m[r, e]:
                if blocker[r, e] < bodies and _to_body(cut, blocker[r, e], ray) < FREE:
                    continue
                if _blocking(wide, wide_cells, ray) < 0:
                    clear_m[r, e] = travel_m + CLEARANCE_M
                else:
                    n = _blocking(cut, cells, ray)
                    if n >= 0:
                        blocker[r, e] = n
                        continue
            seen[found] = r, e
            found += 1
    return seen[:found]


@part
def _widened(cut: Cut) -> Cut:
    """The cross-section with bodies wider by the clearance on each side."""
    boxes = cut.boxes.copy()
    boxes[:, 4:] += CLEARANCE_M + SLACK_M
    discs = cut.discs.copy()
    discs[:, 2] += CLEARANCE_M + SLACK_M
    return Cut(boxes, discs)


@part
def _blocking(cut: Cut, cells: Cells, ray: Ray) -> int:
    """The number of a body that the ray meets, -1 without one."""
    x, y, way_x, way_y = ray
    first, last = _span(min(x, x + way_x), max(x, x + way_x), cells.left, cells.width_m, cells.columns)
    slope = way_y / way_x if abs(way_x) > STEEP_M else inf
    least_y = min(y, y + way_y)
    greatest_y = max(y, y + way_y)
    for column in range(first, last):
        low = least_y
        high = greatest_y
        if slope < inf:  # the part of the ray in this column
            enters = y + (cells.left + column * cells.width_m - x) * slope
            leaves = enters + cells.width_m * slope
            low = max(low, min(enters, leaves))
            high = min(high, max(enters, leaves))
        lowest, highest = _span(low, high, cells.low, cells.height_m, cells.rows)
        if lowest >= highest:
            continue
        cell = column * cells.rows
        # NOTE: the cells of a column are neighbours in `bodies`.
        for at in range(cells.starts[cell + lowest], cells.starts[cell + highest]):
            if _to_body(cut, cells.bodies[at], ray) < FREE:
                return int(cells.bodies[at])
    return -1


@kernel
def near(points: Floats, others: Floats, within_m: float) -> NDArray[np.int64]:
    """Pairs of points and other points within a distance in the plane, as rows: shape (N, 2), by point and other point.

    :param points, others: shape (P, 2 or more) and (O, 2 or more).
    """
    found = np.empty((len(points) * len(others), 2), np.int64)
    count = 0
    for n in range(len(points)):
        x = points[n, 0]
        y = points[n, 1]
        for m in range(len(others)):
            off_x = others[m, 0] - x
            off_y = others[m, 1] - y
            if off_x * off_x + off_y * off_y <= within_m * within_m:
                found[count] = n, m
                count += 1
    return found[:count]


@part
def _ray(starts: Floats, first: int, ends: Floats, last: int) -> Ray:
    # NOTE: rays are numbers and not rows of arrays, whose making would take longer than the rest.
    x = starts[first, 0]
    y = starts[first, 1]
    return x, y, ends[last, 0] - x, ends[last, 1] - y


@part
def _to_body(cut: Cut, n: int, ray: Ray) -> float:
    """The share of the ray up to a body, 1 if it misses it."""
    boxes, discs = cut
    if n < len(boxes):
        return _to_box(boxes, n, *ray)
    return _to_disc(discs, n - len(boxes), *ray)


@part
def _to_box(boxes: Floats, n: int, x: float, y: float, way_x: float, way_y: float) -> float:
    """Slab by slab: the ray is within the box where it is between both pairs of sides."""
    cosine = boxes[n, 2]
    sine = boxes[n, 3]
    off_x = x - boxes[n, 0]
    off_y = y - boxes[n, 1]
    across = cosine * off_y - sine * off_x
    way_across = cosine * way_y - sine * way_x
    if _beside(across, way_across, boxes[n, 5]):
        return 1.0
    along = cosine * off_x + sine * off_y
    way_along = cosine * way_x + sine * way_y
    if _beside(along, way_along, boxes[n, 4]):
        return 1.0
    enters, leaves = _within(along, way_along, boxes[n, 4], 0.0, 1.0)
    if enters > leaves:
        return 1.0
    enters, leaves = _within(across, way_across, boxes[n, 5], enters, leaves)
    return 1.0 if enters > leaves else enters


@part
def _beside(at: float, way: float, half: float) -> bool:
    """True if a ray begins and ends on one side of a slab: most do, and this test needs no division."""
    end = at + way
    return (at > half and end > half) or (at < -half and end < -half)


@part
def _within(at: float, way: float, half: float, enters: float, leaves: float) -> tuple[float, float]:
    """The part of a ray, from and to, that is between -half and half; from > to if there is none."""
    if abs(way) < 1e-12:
        return (2.0, 1.0) if abs(at) > half else (enters, leaves)
    one = (-half - at) / way
    other = (half - at) / way
    return max(enters, min(one, other)), min(leaves, max(one, other))


@part
def _to_disc(discs: Floats, n: int, x: float, y: float, way_x: float, way_y: float) -> float:
    off_x = x - discs[n, 0]
    off_y = y - discs[n, 1]
    inside = off_x * off_x + off_y * off_y - discs[n, 2] * discs[n, 2]
    if inside <= 0.0:
        return 0.0
    toward = off_x * way_x + off_y * way_y
    length = way_x * way_x + way_y * way_y
    root = toward * toward - length * inside
    if toward >= 0.0 or root < 0.0:
        return 1.0
    return float(min(1.0, (-toward - np.sqrt(root)) / length))
