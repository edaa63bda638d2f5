"""Where robots are slower: on sloping ground and in slow zones, and how much farther a way over these seems."""

from collections.abc import Iterable, Sequence
from itertools import combinations, pairwise
from math import dist

from robots.world.parts import Point, Rectangle, Slope

Paced = tuple[Rectangle, float]
"""An area, and the share of its speed that a robot has there."""


def pace_at(point: Point, slopes: Iterable[Slope]) -> float:
    """The share of its speed at which a robot drives here; 1 on level ground."""
    return next((slope.pace for slope in slopes if slope.contains(point)), 1.0)


def level_way_m(start: Point, end: Point, slopes: Sequence[Slope], limited: Sequence[Paced] = ()) -> float:
    """The length of level ground without limits that takes as long as the straight way, metres.

    :param limited: where a limit holds; of several at a point the least counts, on a slope beside the slope's pace.
    """
    length_m = dist(start, end)
    spans = [within(start, end, area) for area in (*slopes, *(area for area, _ in limited))]
    cuts = {share for span in spans if span is not None for share in span}
    if not cuts:
        return length_m
    total = 0.0
    for one, other in pairwise(sorted({0.0, 1.0, *cuts})):
        middle = _along(start, end, (one + other) / 2)
        limit = min((share for area, share in limited if area.contains(middle)), default=1.0)
        total += (other - one) / (pace_at(middle, slopes) * limit)
    return length_m * total


def within(start: Point, end: Point, area: Rectangle) -> tuple[float, float] | None:
    """Where a straight way enters an area and leaves it, shares of its length from 0 to 1; None if it passes by."""
    enters = 0.0
    leaves = 1.0
    for begin, finish, (low, high) in zip(start, end, (area.x, area.y), strict=True):
        step = finish - begin
        if step == 0:
            if not low <= begin <= high:
                return None
            continue
        first, last = sorted(((low - begin) / step, (high - begin) / step))
        enters = max(enters, first)
        leaves = min(leaves, last)
    return (enters, leaves) if enters <= leaves else None


def overlapping(slopes: Iterable[Slope]) -> tuple[Slope, Slope] | None:
    """Two slopes that overlap; None if none do."""
    for one, other in combinations(slopes, 2):
        if all(
            min(a[1], b[1]) > max(a[0], b[0]) for a, b in zip((one.x, one.y), (other.x, other.y), strict=True)
        ):
            return one, other
    return None


def _along(start: Point, end: Point, share: float) -> Point:
    x, y = (one + share * (other - one) for one, other in zip(start, end, strict=True))
    return x, y
