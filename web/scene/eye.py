"""A camera's geometry: what of the world is where on its picture."""

from dataclasses import dataclass
from math import tan
from typing import Self

import numpy as np
import viser
import viser.transforms
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Eye:
    """A camera: where it is, the rotation from its frame (x right, y down, z ahead) to the world's, and its picture.

    `turn`: shape (3, 3).
    """

    at: Floats
    turn: Floats
    fov_rad: float
    width_px: float
    height_px: float

    @classmethod
    def of(cls, camera: viser.CameraHandle) -> Self:
        """A browser's, as it last said."""
        return cls(
            at=np.asarray(camera.position),
            turn=viser.transforms.SO3(np.asarray(camera.wxyz)).as_matrix().astype(np.float64),
            fov_rad=camera.fov,
            width_px=camera.image_width,
            height_px=camera.image_height,
        )

    def sees(self, points: Floats) -> Floats:
        """Points of the world, shape (N, 3), on the picture: x and y from its upper left, pixels, and the depth."""
        seen = (points - self.at) @ self.turn
        depth = seen[:, 2]
        scale = self.px_a_metre(depth)
        across = self.width_px / 2 + seen[:, 0] * scale
        down = self.height_px / 2 + seen[:, 1] * scale
        return np.stack([across, down, depth], axis=-1)

    def px_a_metre(self, depth: Floats) -> Floats:
        """How many pixels a metre takes that far away; none behind the camera."""
        scale: Floats = self.height_px / 2 / tan(self.fov_rad / 2) / np.where(depth > 0, depth, np.inf)
        return scale
