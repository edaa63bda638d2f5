"""What a horizontal cut through the scene's bodies leaves solid, for rays in its plane."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.physics.body_poses import Upright
from sim.physics.rays import Cut

SPHERE, BOX, CYLINDER = 2, 3, 4  # PyBullet's numbers of shapes


@dataclass(slots=True)
class Outlines:
    """The shapes of all bodies, upright boxes and cylinders, by body. What a ball cuts is its greatest disc."""

    _shapes: dict[int, list[tuple[float, ...]]] = field(default_factory=dict)
    _groups: dict[int, int] = field(default_factory=dict)
    _table: NDArray[np.float64] | None = None
    _owners: tuple[int, ...] = ()

    def put(self, body: int, described: Iterable[Sequence[Any]]) -> None:
        """Account for a body, of no collision group yet.

        :param described: as PyBullet's getCollisionShapeData describes its shapes.
        :raises ValueError: for a shape of another kind.
        """
        self._shapes[body] = [_row(shape) for shape in described]
        self.regroup(body, 0)

    def regroup(self, body: int, group: int) -> None:
        """The body is of this collision group now."""
        self._groups[body] = group
        self._table = None

    def remove(self, body: int) -> None:
        self._shapes.pop(body, None)
        self._groups.pop(body, None)
        self._table = None

    def cut(self, at: Callable[[int], Upright], *, height_m: float, groups: int) -> Cut:
        """Boxes and discs of the bodies of these groups, where they reach across a height.

        :param at: where each body is.
        """
        table = self._tabulated()
        wheres = np.array([at(body) for body in self._owners]).reshape(-1, 4)
        in_groups = (table[:, 0].astype(np.int64) & groups) != 0
        rise_m = height_m - wheres[:, 2]
        cuts = in_groups & (table[:, 5] < rise_m) & (rise_m < table[:, 6])
        rows, at_rows = table[cuts], wheres[cuts]
        cosine, sine = np.cos(at_rows[:, 3]), np.sin(at_rows[:, 3])
        x = at_rows[:, 0] + cosine * rows[:, 3] - sine * rows[:, 4]
        y = at_rows[:, 1] + sine * rows[:, 3] + cosine * rows[:, 4]
        box = rows[:, 1] == BOX
        boxes = np.column_stack([x, y, cosine, sine, rows[:, 7], rows[:, 8]])[box]
        discs = np.column_stack([x, y, rows[:, 7]])[~box]
        return Cut(np.ascontiguousarray(boxes), np.ascontiguousarray(discs))

    def _tabulated(self) -> NDArray[np.float64]:
        """A row a shape: its body's group, its kind, its body, and what `_row` tells of it."""
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
    """Kind, offset x and y, from and to in height relative to the body's middle, half length or radius, half width."""
    kind, size, (x, y, z) = shape[2], shape[3], shape[5]
    if kind == BOX:
        length_m, width_m, height_m = size
        return (kind, x, y, z - height_m / 2, z + height_m / 2, length_m / 2, width_m / 2)
    if kind == CYLINDER:
        height_m, radius_m, _ = size
        return (kind, x, y, z - height_m / 2, z + height_m / 2, radius_m, radius_m)
    if kind == SPHERE:
        radius_m = size[0]
        return (kind, x, y, z - radius_m, z + radius_m, radius_m, radius_m)
    raise ValueError(
        f"rays know boxes, cylinders and spheres, and this body has a shape of PyBullet's kind {kind}"
    )
