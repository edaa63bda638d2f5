"""Rays in a plane against a horizontal cross-section of the scene. Compiled (numba).

Arrays: boxes: shape (B, 6): middle x, y, cosine and sine of the heading, half length along it, half width, metres.
discs: shape (D, 3): middle x, y, radius. The physics engine casts the same rays in three dimensions, at about 8 µs
each; a batch here takes about a hundredth of that, because far bodies are excluded before any ray is cast.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robots.compiled import kernel

Floats = NDArray[np.float64]
Ray = tuple[float, float, float, float]
"""Its start x, y, and the vector to its end, metres."""
FREE = 1.0
"""The share of a ray that meets nothing."""


class Cut(NamedTuple):
    """A cross-section at one height: boxes and discs as above."""

    boxes: Floats
    discs: Floats


@kernel
def free_shares(cut: Cut, starts: Floats, ends: Floats, fans: NDArray[np.int64]) -> Floats:
    """The share of each ray that is free, 1 where nothing is hit, 0 where it begins within something solid.

    :param starts, ends: shape (N, 2), metres.
    :param fans: shape (F + 1,): the rays `fans[f]` to `fans[f + 1]` begin near each other.
    """
    boxes, discs = cut
    free = np.ones(len(starts))
    near_boxes = np.empty(len(boxes), np.int64)
    near_discs = np.empty(len(discs), np.int64)
    for fan in range(len(fans) - 1):
        first = fans[fan]
        last = fans[fan + 1]
        if first == last:
            continue
        x, y = starts[first]
        reach_m = 0.0
        for ray in range(first, last):
            reach_m = max(reach_m, np.hypot(ends[ray, 0] - x, ends[ray, 1] - y))
            reach_m = max(reach_m, np.hypot(starts[ray, 0] - x, starts[ray, 1] - y))
        boxes_near = 0
        discs_near = 0
        for n in range(len(boxes)):
            if np.hypot(boxes[n, 0] - x, boxes[n, 1] - y) <= reach_m + np.hypot(boxes[n, 4], boxes[n, 5]):
                near_boxes[boxes_near] = n
                boxes_near += 1
        for n in range(len(discs)):
            if np.hypot(discs[n, 0] - x, discs[n, 1] - y) <= reach_m + discs[n, 2]:
                near_discs[discs_near] = n
                discs_near += 1
        for ray in range(first, last):
            share = 1.0
            for n in near_boxes[:boxes_near]:
                share = min(share, _to_box(boxes, n, *_ray(starts, ray, ends, ray)))
            for n in near_discs[:discs_near]:
                share = min(share, _to_disc(discs, n, *_ray(starts, ray, ends, ray)))
            free[ray] = share
    return free


@kernel
def in_sight(
    cut: Cut,
    observers: Floats,
    shining: Floats,
    reach_m: Floats,
    known: NDArray[np.bool_],
    blocker: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Which observer sees which emitter: pairs of indices, shape (N, 2), by observer and then by emitter.

    :param observers, shining: shape (R, 2) and (E, 2), metres. :param reach_m: shape (E,).
    :param known: shape (R, E): the pairs that matter.
    :param blocker: shape (R, E), kept from call to call: the body that blocked the view last, which is tried first.
        It saves time only: most hidden emitters stay hidden by the same wall.
    """
    boxes, discs = cut
    seen = np.empty((known.sum(), 2), np.int64)
    found = 0
    for r in range(len(observers)):
        for e in range(len(shining)):
            if not known[r, e]:
                continue
            ray = _ray(observers, r, shining, e)
            if ray[2] * ray[2] + ray[3] * ray[3] > reach_m[e] * reach_m[e]:
                continue
            if _blocks(boxes, discs, blocker[r, e], ray):
                continue
            hidden = False
            for n in range(len(boxes) + len(discs)):
                if _blocks(boxes, discs, n, ray):
                    blocker[r, e] = n
                    hidden = True
                    break
            if not hidden:
                seen[found] = r, e
                found += 1
    return seen[:found]


@kernel
def near(points: Floats, x: float, y: float, within_m: float) -> NDArray[np.int64]:
    """The rows of the points, shape (N, 2 or more), that are within a distance of one in the plane."""
    found = np.empty(len(points), np.int64)
    count = 0
    for n in range(len(points)):
        off_x = points[n, 0] - x
        off_y = points[n, 1] - y
        if off_x * off_x + off_y * off_y <= within_m * within_m:
            found[count] = n
            count += 1
    return found[:count]


@kernel
def _ray(starts: Floats, first: int, ends: Floats, last: int) -> Ray:
    # NOTE: rays are numbers and not rows of arrays, whose making would take longer than the rest.
    x = starts[first, 0]
    y = starts[first, 1]
    return x, y, ends[last, 0] - x, ends[last, 1] - y


@kernel
def _blocks(boxes: Floats, discs: Floats, n: int, ray: Ray) -> bool:
    if n < len(boxes):
        return _to_box(boxes, n, *ray) < 1.0
    if n < len(boxes) + len(discs):
        return _to_disc(discs, n - len(boxes), *ray) < 1.0
    return False


@kernel
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


@kernel
def _beside(at: float, way: float, half: float) -> bool:
    """True if a ray begins and ends on one side of a slab: most do, and this test needs no division."""
    end = at + way
    return (at > half and end > half) or (at < -half and end < -half)


@kernel
def _within(at: float, way: float, half: float, enters: float, leaves: float) -> tuple[float, float]:
    """The part of a ray, from and to, that is between -half and half; from > to if there is none."""
    if abs(way) < 1e-12:
        return (2.0, 1.0) if abs(at) > half else (enters, leaves)
    one = (-half - at) / way
    other = (half - at) / way
    return max(enters, min(one, other)), min(leaves, max(one, other))


@kernel
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
