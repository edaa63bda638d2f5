"""Meshes, rotations and line segments as arrays.

A mesh is (vertices: shape (V, 3), metres; faces: shape (F, 3), counter-clockwise seen from outside).
"""

from collections.abc import Sequence
from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Mesh = tuple[Floats, NDArray[np.uint32]]
Centre = tuple[float, float, float]
HIDDEN_M = -10.0
"""Height, below the floor, of what is not visible, so that the count of instances stays the same."""

_CORNERS = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
_BOX_FACES = [
    *[(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4)],
    *[(1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7)],
]


def box(size: Centre = (1.0, 1.0, 1.0), centre: Centre = (0.0, 0.0, 0.0)) -> Mesh:
    """A box of full edge lengths `size`."""
    corners = np.array([(x, y, z) for z in (-1, 1) for x, y in _CORNERS], dtype=np.float32)
    vertices = corners * np.array(size) / 2 + np.array(centre)
    return vertices.astype(np.float32), np.array(_BOX_FACES, dtype=np.uint32)


def cylinder(
    radius_m: float, bottom_m: float, top_m: float, *, top_radius_m: float | None = None, sides: int = 28
) -> Mesh:
    """An upright cylinder or, with another radius at its top, a truncated cone."""
    top_radius = radius_m if top_radius_m is None else top_radius_m
    turns = [2 * pi * index / sides for index in range(sides)]
    lower = [(radius_m * cos(turn), radius_m * sin(turn), bottom_m) for turn in turns]
    upper = [(top_radius * cos(turn), top_radius * sin(turn), top_m) for turn in turns]
    centres = [(0.0, 0.0, bottom_m), (0.0, 0.0, top_m)]
    faces = []
    for i in range(sides):
        j = (i + 1) % sides
        faces += [
            (i, j, sides + j),
            (i, sides + j, sides + i),
            (2 * sides, j, i),
            (2 * sides + 1, sides + i, sides + j),
        ]
    return np.array(lower + upper + centres, dtype=np.float32), np.array(faces, dtype=np.uint32)


def merged(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one."""
    offsets = np.cumsum([0, *[len(vertices) for vertices, _ in meshes]])[:-1]
    faces = [faces + np.uint32(offset) for (_, faces), offset in zip(meshes, offsets, strict=True)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces).astype(np.uint32)


def turned(headings_rad: Sequence[float] | NDArray[np.float64]) -> Floats:
    """Quaternions (w, x, y, z), shape (N, 4), of rotations about the vertical."""
    half = np.asarray(headings_rad, dtype=np.float64) / 2
    zero = np.zeros_like(half)
    return np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1).astype(np.float32)


def segments(
    lines: Sequence[tuple[Sequence[tuple[float, float]], tuple[int, int, int]]], height_m: float
) -> tuple[Floats, NDArray[np.uint8]]:
    """Polylines on the floor with their colours as segments, points and colours each of shape (N, 2, 3).

    The first is hidden below the floor: a node without segments cannot be drawn. A line of one point has none.
    """
    lines = [(line, colour) for line, colour in lines if len(line) > 1]
    ends = np.array([end for line, _ in lines for end in line], dtype=np.float32).reshape(-1, 2)
    counts = np.array([len(line) for line, _ in lines], dtype=np.int64)
    is_inside = np.ones(len(ends), dtype=np.bool_)
    is_inside[np.cumsum(counts) - 1] = False  # nothing leads from the end of a line to the next one
    from_ = np.flatnonzero(is_inside)
    points = np.full((len(from_) + 1, 2, 3), height_m, dtype=np.float32)
    points[0] = HIDDEN_M
    points[1:, 0, :2] = ends[from_]
    points[1:, 1, :2] = ends[from_ + 1]
    shades = np.array([colour for _, colour in lines], dtype=np.uint8).reshape(-1, 3)
    colours = np.zeros((len(from_) + 1, 2, 3), dtype=np.uint8)
    colours[1:] = np.repeat(shades, counts - 1, axis=0)[:, None]
    return points, colours


def ring(inner_m: float, outer_m: float, height_m: float, sides: int = 40) -> Mesh:
    """A flat ring on the floor, seen from above."""
    turns = np.linspace(0, 2 * pi, sides, endpoint=False)
    around = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    rims = [np.column_stack([radius * around, np.full(sides, height_m)]) for radius in (inner_m, outer_m)]
    faces = []
    for i in range(sides):
        j = (i + 1) % sides
        faces += [(i, sides + i, sides + j), (i, sides + j, j)]
    return np.concatenate(rims).astype(np.float32), np.array(faces, dtype=np.uint32)
