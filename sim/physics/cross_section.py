"""The horizontal cross-section of the scene's bodies at a height, for rays in that plane."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.physics.bullet import UprightPose, pybullet
from sim.physics.rays import Cut


class CollisionShapes:
    """The shapes of all bodies, upright boxes and cylinders, by body. A ball counts as its greatest disc."""

    def __init__(self) -> None:
        self._shapes: dict[int, list[tuple[float, ...]]] = {}
        self._groups: dict[int, int] = {}
        self._table: NDArray[np.float64] | None = None
        self._owners: tuple[int, ...] = ()

    def put(self, body: int, described: Iterable[Sequence[Any]]) -> None:
        """Add a body, of no collision group yet.

        :param described: its shapes as PyBullet's getCollisionShapeData describes them.
        :raises ValueError: for a shape of another kind.
        """
        self._shapes[body] = [_row(shape) for shape in described]
        self.regroup(body, 0)

    def regroup(self, body: int, group: int) -> None:
        """Set the body's collision group."""
        self._groups[body] = group
        self._table = None

    def remove(self, body: int) -> None:
        self._shapes.pop(body, None)
        self._groups.pop(body, None)
        self._table = None

    def cut(self, pose_of: Callable[[int], UprightPose], *, height_m: float, groups: int) -> Cut:
        """Boxes and discs of the bodies of these groups that reach across a height."""
        table = self._tabulated()
        poses = np.array([pose_of(body) for body in self._owners]).reshape(-1, 4)
        in_groups = (table[:, 0].astype(np.int64) & groups) != 0
        rise_m = height_m - poses[:, 2]
        cuts = in_groups & (table[:, 5] < rise_m) & (rise_m < table[:, 6])
        rows = table[cuts]
        bases = poses[cuts]
        cosine = np.cos(bases[:, 3])
        sine = np.sin(bases[:, 3])
        x = bases[:, 0] + cosine * rows[:, 3] - sine * rows[:, 4]
        y = bases[:, 1] + sine * rows[:, 3] + cosine * rows[:, 4]
        is_box = rows[:, 1] == pybullet.GEOM_BOX
        boxes = np.column_stack([x, y, cosine, sine, rows[:, 7], rows[:, 8]])[is_box]
        discs = np.column_stack([x, y, rows[:, 7]])[~is_box]
        return Cut(np.ascontiguousarray(boxes), np.ascontiguousarray(discs))

    def _tabulated(self) -> NDArray[np.float64]:
        """Shape (S, 9), a row a shape: its body's group, its kind, its body, then the rest of `_row`."""
        if self._table is None:
            rows = [
                (self._groups[body], shape[0], body, *shape[1:])
                for body, shapes in self._shapes.items()
                for shape in shapes
            ]
            self._table = np.array(rows, np.float64).reshape(-1, 9)
            self._owners = tuple(int(body) for body in self._table[:, 2])
        return self._table


def _row(shape: Sequence[Any]) -> tuple[float, ...]:
    """Kind, offset x and y, lowest and highest z relative to the body's middle, half length or radius, half width."""
    kind = shape[2]
    size = shape[3]
    x, y, z = shape[5]
    if kind == pybullet.GEOM_BOX:
        length_m, width_m, height_m = size
        return (kind, x, y, z - height_m / 2, z + height_m / 2, length_m / 2, width_m / 2)
    if kind == pybullet.GEOM_CYLINDER:
        height_m, radius_m, _ = size
        return (kind, x, y, z - height_m / 2, z + height_m / 2, radius_m, radius_m)
    if kind == pybullet.GEOM_SPHERE:
        radius_m = size[0]
        return (kind, x, y, z - radius_m, z + radius_m, radius_m, radius_m)
    raise ValueError(f"rays support boxes, cylinders and spheres, not PyBullet's shape type {kind}")
