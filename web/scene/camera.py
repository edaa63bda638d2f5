"""A page's camera: projection of the world's points to its picture, and camera moves."""

from dataclasses import dataclass
from math import cos, radians, sin, tan
from typing import Self

import numpy as np
import viser
import viser.transforms
from numpy.typing import NDArray

from web.api_types import Layout, Point

Floats = NDArray[np.float64]

FOV_RAD = radians(45)
ELEVATION_RAD = radians(58)
MAX_SHARE = 0.92
"""Share of the picture's width and height that the world may fill."""
MIN_DISTANCE_M = 2.0
MAX_DISTANCE_M = 2000.0
PRECISION_M = 0.01
FOLLOW_DISTANCE_M = 4.5
"""Distance to which the camera approaches a robot that it begins to follow."""

BACK = np.array([0.0, -cos(ELEVATION_RAD), sin(ELEVATION_RAD)])
"""Direction from the point looked at to the camera: south and up."""
ROTATION = np.stack([np.array([1.0, 0.0, 0.0]), np.cross(-BACK, [1.0, 0.0, 0.0]), -BACK], axis=-1)


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraView:
    """A pinhole camera.

    :param position: shape (3,), metres.
    :param rotation: shape (3, 3), from the camera's frame (x right, y down, z ahead) to the world's.
    """

    position: Floats
    rotation: Floats
    fov_rad: float
    width_px: float
    height_px: float

    @classmethod
    def of(cls, camera: viser.CameraHandle) -> Self:
        """A browser's camera as last reported."""
        return cls(
            position=np.asarray(camera.position),
            rotation=viser.transforms.SO3(np.asarray(camera.wxyz)).as_matrix().astype(np.float64),
            fov_rad=camera.fov,
            width_px=camera.image_width,
            height_px=camera.image_height,
        )

    def project(self, points: Floats) -> Floats:
        """Project points, shape (N, 3), metres, to (x, y, depth): pixels from the upper left, metres."""
        seen = (points - self.position) @ self.rotation
        depth = seen[:, 2]
        scale = self.px_per_m(depth)
        x = self.width_px / 2 + seen[:, 0] * scale
        y = self.height_px / 2 + seen[:, 1] * scale
        return np.stack([x, y, depth], axis=-1)

    def px_per_m(self, depth_m: Floats) -> Floats:
        """Pixels per metre at that depth; 0 behind the camera."""
        scale: Floats = self.height_px / 2 / tan(self.fov_rad / 2) / np.where(depth_m > 0, depth_m, np.inf)
        return scale


def show_whole_world(client: viser.ClientHandle, layout: Layout) -> None:
    """Place the camera south of and above the world, at the smallest distance that shows all of it."""
    (west, south), (east, north) = layout.bounds
    middle = np.array([(west + east) / 2, (south + north) / 2, 0.0])
    corners = np.array([(x, y, 0.0) for x in (west, east) for y in (south, north)])
    camera = client.camera
    distance = distance_m(corners - middle, camera.image_width, camera.image_height)
    with client.atomic():
        camera.fov = FOV_RAD
        camera.position = middle + distance * BACK
        camera.look_at = middle


def distance_m(corners: Floats, width_px: float, height_px: float) -> float:
    """Smallest distance from which all corners are in view; shape (N, 3), metres from the point looked at."""
    near_m = MIN_DISTANCE_M
    far_m = MAX_DISTANCE_M
    while far_m - near_m > PRECISION_M:
        middle_m = (near_m + far_m) / 2
        view = CameraView(
            position=middle_m * BACK,
            rotation=ROTATION,
            fov_rad=FOV_RAD,
            width_px=width_px,
            height_px=height_px,
        )
        x, y, depth = view.project(corners).T
        is_within = max(np.abs(x / width_px - 0.5).max(), np.abs(y / height_px - 0.5).max()) < MAX_SHARE / 2
        if is_within and depth.min() > 0:
            far_m = middle_m
        else:
            near_m = middle_m
    return far_m


def follow(client: viser.ClientHandle, robot: Point, *, begins: bool) -> None:
    """Move the camera with the robot; the operator's own angle and distance are kept."""
    offset = np.asarray(client.camera.position) - np.asarray(client.camera.look_at)
    distance = float(np.linalg.norm(offset))
    if begins and distance > FOLLOW_DISTANCE_M:
        offset *= FOLLOW_DISTANCE_M / distance
    target = np.array([*robot, 0.0])
    with client.atomic():
        client.camera.position = target + offset
        client.camera.look_at = target
