"""Sloping ground: where it is, how it slows robots, and how much farther a way over it seems."""

from collections.abc import Iterable
from itertools import combinations
from math import dist

from robots.world.parts import Point, Slope


def pace_at(point: Point, slopes: Iterable[Slope]) -> float:
    """The share of its speed at which a robot drives here; 1 on level ground."""
    return next((slope.pace for slope in slopes if slope.contains(point)), 1.0)


def level_way_m(start: Point, end: Point, slopes: Iterable[Slope]) -> float:
    """The length of level ground that takes as long as the straight way, metres."""
    length_m = dist(start, end)
    return length_m * (1 + sum(_share_within(start, end, slope) * (1 / slope.pace - 1) for slope in slopes))


def overlapping(slopes: Iterable[Slope]) -> tuple[Slope, Slope] | None:
    """Two slopes that overlap; None if none do."""
    for one, other in combinations(slopes, 2):
        if all(
            min(a[1], b[1]) > max(a[0], b[0]) for a, b in zip((one.x, one.y), (other.x, other.y), strict=True)
        ):
            return one, other
    return None


def _share_within(start: Point, end: Point, slope: Slope) -> float:
    """The share of a straight way that lies within the slope, 0 to 1."""
    enters = 0.0
    leaves = 1.0
    for begin, finish, (low, high) in zip(start, end, (slope.x, slope.y), strict=True):
        step = finish - begin
        if step == 0:
            if not low <= begin <= high:
                return 0.0
            continue
        first, last = sorted(((low - begin) / step, (high - begin) / step))
        enters = max(enters, first)
        leaves = min(leaves, last)
    return max(0.0, leaves - enters)
