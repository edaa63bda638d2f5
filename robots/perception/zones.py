"""The borders of areas that a robot does not enter, always or while another robot is there, as obstacles."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from robots.physical.body import Pose
from robots.physical.geometry import to_robot
from robots.physical.profile import Area

BORDER_RADIUS_M = 0.1
"""Of the discs that stand for a border."""
PITCH_M = 0.2
"""The most between their centres: no hull fits between two of them."""
NEAR_M = 2.0
"""What is farther off does not matter to where a robot goes next."""

Points = NDArray[np.complex128]


class Borders:
    """The borders of areas that a robot never enters, and of those for one robot at a time."""

    def __init__(self, closed: Sequence[Area], one_robot: Sequence[Area] = ()) -> None:
        self._closed = [(area, _border(*area)) for area in closed]
        self._one_robot = [(area, _border(*area)) for area in one_robot]
        self.count = sum(len(border) for _, border in (*self._closed, *self._one_robot))
        """The most discs that `near` gives."""

    def near(self, pose: Pose, others: Iterable[complex] = ()) -> list[complex]:
        """The centres of the discs near a robot, in its frame. Of an area that it is in, none: it may leave.

        :param others: where other robots are, world frame.
        """
        at = complex(pose.x_m, pose.y_m)
        found = [border[np.abs(border - at) <= NEAR_M] for area, border in self._closed if not _has(area, at)]
        if self._one_robot:
            there = list(others)
            found += [
                border[np.abs(border - at) <= NEAR_M]
                for area, border in self._one_robot
                if not _has(area, at) and any(_has(area, other) for other in there)
            ]
        return [to_robot(pose, point) for border in found for point in border.tolist()]


def _has(area: Area, point: complex) -> bool:
    left, right, low, high = area
    return left < point.real < right and low < point.imag < high


def _border(left: float, right: float, low: float, high: float) -> Points:
    """Points along the border, the corners among them."""
    corners = (complex(left, low), complex(right, low), complex(right, high), complex(left, high))
    sides = [
        np.linspace(one, other, int(abs(other - one) / PITCH_M) + 1, endpoint=False)
        for one, other in zip(corners, (*corners[1:], corners[0]), strict=True)
    ]
    return np.concatenate(sides)
