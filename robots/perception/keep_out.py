"""The borders of areas that a robot stays out of, as obstacles."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robots.physical.body import Pose
from robots.physical.geometry import to_robot

BORDER_RADIUS_M = 0.1
"""Of the discs that stand for a border."""
PITCH_M = 0.2
"""The most between their centres: no hull fits between two of them."""
NEAR_M = 2.0
"""What is farther off does not matter to where a robot goes next."""

Points = NDArray[np.complex128]


class Borders:
    """The borders of areas: least x, greatest x, least y, greatest y, metres, world frame."""

    def __init__(self, areas: Sequence[tuple[float, float, float, float]]) -> None:
        self._areas = [(area, _border(*area)) for area in areas]
        self.count = sum(len(border) for _, border in self._areas)
        """The most discs that `near` gives."""

    def near(self, pose: Pose) -> list[complex]:
        """The centres of the discs near a robot, in its frame. Of an area that it is in, none: it may leave."""
        at = complex(pose.x_m, pose.y_m)
        found = [
            border[np.abs(border - at) <= NEAR_M]
            for (left, right, low, high), border in self._areas
            if not (left < at.real < right and low < at.imag < high)
        ]
        return [to_robot(pose, point) for border in found for point in border.tolist()]


def _border(left: float, right: float, low: float, high: float) -> Points:
    """Points along the border, the corners among them."""
    corners = (complex(left, low), complex(right, low), complex(right, high), complex(left, high))
    sides = [
        np.linspace(one, other, int(abs(other - one) / PITCH_M) + 1, endpoint=False)
        for one, other in zip(corners, (*corners[1:], corners[0]), strict=True)
    ]
    return np.concatenate(sides)
