"""Where a page's camera is: over the whole world, or with a robot."""

from math import cos, radians, sin

import numpy as np
import viser

from web.api_types import Layout, Point
from web.scene.eye import Eye, Floats

FOV_RAD = radians(45)
ELEVATION_RAD = radians(58)
FILLED = 0.92
"""Of the picture's width and height, by the world."""
NEAREST_M, FARTHEST_M = 2.0, 2000.0
FOLLOWED_FROM_M = 4.5
"""How far the camera is from a robot that it begins to follow, if it was farther off."""

BACK = np.array([0.0, -cos(ELEVATION_RAD), sin(ELEVATION_RAD)])
"""The direction of the camera from what it looks at: south of it and above."""
TURN = np.stack([np.array([1.0, 0.0, 0.0]), np.cross(-BACK, [1.0, 0.0, 0.0]), -BACK], axis=-1)


def aim(client: viser.ClientHandle, layout: Layout) -> None:
    """Set the camera south of the world and above it, as near as the whole of it stays in view."""
    (west, south), (east, north) = layout.bounds
    middle = np.array([(west + east) / 2, (south + north) / 2, 0.0])
    corners = np.array([(x, y, 0.0) for x in (west, east) for y in (south, north)])
    seen = client.camera
    away = distance_m(corners - middle, seen.image_width, seen.image_height)
    with client.atomic():
        client.camera.fov = FOV_RAD
        client.camera.position = middle + away * BACK
        client.camera.look_at = middle


def distance_m(corners: Floats, width_px: float, height_px: float) -> float:
    """How far off to see all corners, shape (N, 3), metres from what is looked at."""
    near, far = NEAREST_M, FARTHEST_M
    while far - near > 0.01:
        middle = (near + far) / 2
        eye = Eye(at=middle * BACK, turn=TURN, fov_rad=FOV_RAD, width_px=width_px, height_px=height_px)
        across, down, depth = eye.sees(corners).T
        fits = (
            np.abs(across / width_px - 0.5).max() < FILLED / 2
            and np.abs(down / height_px - 0.5).max() < FILLED / 2
        )
        if fits and depth.min() > 0:
            far = middle
        else:
            near = middle
    return far


def follow(client: viser.ClientHandle, robot: Point, *, begins: bool) -> None:
    """Take the camera along: whoever turns it or comes nearer keeps that."""
    offset = np.asarray(client.camera.position) - np.asarray(client.camera.look_at)
    distance = float(np.linalg.norm(offset))
    if begins and distance > FOLLOWED_FROM_M:
        offset *= FOLLOWED_FROM_M / distance
    there = np.array([*robot, 0.0])
    with client.atomic():
        client.camera.position = there + offset
        client.camera.look_at = there
