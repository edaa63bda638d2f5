"""The horizontal cross-section of the scene's bodies at a height, for rays in that plane."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.physics.bullet import UprightPose, pybullet
from sim.physics.rays import Cut


class Shape(NamedTuple):
    """An upright shape of a body: its kind, offset and lowest and highest z relative to the body's middle, half its
    length or its radius, half its width.
    """

    kind: int
    x_m: float
    y_m: float
    low_m: float
    high_m: float
    half_length_m: float
    half_width_m: float


class CollisionShapes:
    """The shapes of all bodies, upright boxes and cylinders, by body. A ball counts as its greatest disc."""

    def __init__(self) -> None:
        self._shapes: dict[int, list[Shape]] = {}
        self._groups: dict[int, int] = {}
        self._tables: dict[int, tuple[NDArray[np.float64], tuple[int, ...]]] = {}
        """By groups: as `_table` returns it."""

    def put(self, body: int, described: Iterable[Sequence[Any]]) -> None:
        """Add a body, of no collision group yet.

        :param described: its shapes as PyBullet's getCollisionShapeData describes them.
        :raises ValueError: for a shape of another kind.
        """
        self._shapes[body] = [_row(shape) for shape in described]
        self.regroup(body, 0)

    def of(self, body: int) -> Sequence[Shape]:
        """A body's shapes."""
        return self._shapes[body]

    def regroup(self, body: int, group: int) -> None:
        """Set the body's collision group."""
        self._groups[body] = group
        self._tables = {}

    def remove(self, body: int) -> None:
        self._shapes.pop(body, None)
        self._groups.pop(body, None)
        self._tables = {}

    def cut(self, pose_of: Callable[[int], UprightPose], *, height_m: float, groups: int) -> Cut:
        """Boxes and discs of the bodies of these groups that reach across a height."""
        table, owners = self._table(groups)
        poses = np.array([pose_of(body) for body in owners]).reshape(-1, 4)
        rise_m = height_m - poses[:, 2]
        cuts = (table[:, 3] < rise_m) & (rise_m < table[:, 4])
        rows = table[cuts]
        bases = poses[cuts]
        cosine = np.cos(bases[:, 3])
        sine = np.sin(bases[:, 3])
        x = bases[:, 0] + cosine * rows[:, 1] - sine * rows[:, 2]
        y = bases[:, 1] + sine * rows[:, 1] + cosine * rows[:, 2]
        is_box = rows[:, 0] == pybullet.GEOM_BOX
        boxes = np.column_stack([x, y, cosine, sine, rows[:, 5], rows[:, 6]])[is_box]
        discs = np.column_stack([x, y, rows[:, 5]])[~is_box]
        return Cut(np.ascontiguousarray(boxes), np.ascontiguousarray(discs))

    def _table(self, groups: int) -> tuple[NDArray[np.float64], tuple[int, ...]]:
        """Shape (S, 7), a row for each shape of a body of these groups, and the shapes' bodies."""
        if groups not in self._tables:
            owners = [body for body, group in self._groups.items() if group & groups]
            rows = [shape for body in owners for shape in self._shapes[body]]
            self._tables[groups] = (
                np.array(rows, np.float64).reshape(-1, 7),
                tuple(body for body in owners for _ in self._shapes[body]),
            )
        return self._tables[groups]


def _row(shape: Sequence[Any]) -> Shape:
    kind = shape[2]
    size = shape[3]
    x, y, z = shape[5]
    if kind == pybullet.GEOM_BOX:
        length_m, width_m, height_m = size
        return Shape(kind, x, y, z - height_m / 2, z + height_m / 2, length_m / 2, width_m / 2)
    if kind == pybullet.GEOM_CYLINDER:
        height_m, radius_m, _ = size
        return Shape(kind, x, y, z - height_m / 2, z + height_m / 2, radius_m, radius_m)
    if kind == pybullet.GEOM_SPHERE:
        radius_m = size[0]
        return Shape(kind, x, y, z - radius_m, z + radius_m, radius_m, radius_m)
    raise ValueError(f"rays support boxes, cylinders and spheres, not PyBullet's shape type {kind}")
