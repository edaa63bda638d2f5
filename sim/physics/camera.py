"""Pictures of the scene, rendered by PyBullet's own renderer: without a window or a graphics card.

The bodies are copied into a world that exists for one picture: the physics is not touched, and nothing is kept.
"""

import struct
import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from robots.physical.body import Pose
from sim.physics.bullet import UprightPose, pybullet
from sim.physics.cross_section import Shape

NEAR_M = 0.02
FAR_M = 60.0
DOWN_RAD = 0.12
"""How far the camera looks down (our choice)."""
LIGHT = (0.4, -0.6, 1.0)
"""The direction that the light comes from."""

Colour = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""
FLOOR: Colour = (158, 152, 143)
SKY: Colour = (205, 219, 230)

Pixels = NDArray[np.uint8]
"""Shape (height, width, 3): rows from the top; red, green and blue."""


@dataclass(frozen=True, slots=True)
class Seen:
    """A shape of a body in the picture: of an upright body at a pose, in a colour."""

    shape: Shape
    pose: UprightPose
    colour: Colour


def picture(
    shapes: Iterable[Seen], eye: Pose, *, height_m: float, width: int, height: int, view_deg: float
) -> Pixels:
    """The shapes and the floor as seen from a pose, `height_m` above the floor.

    :param width, height: of the picture, pixels. :param view_deg: the angle of view, from top to bottom.
    """
    client = pybullet.connect(pybullet.DIRECT)
    try:
        for one in shapes:
            _add(client, one)
        floor = _visual(client, pybullet.GEOM_BOX, FLOOR, halfExtents=(FAR_M, FAR_M, 0.01))
        pybullet.createMultiBody(0, -1, floor, (eye.x_m, eye.y_m, -0.01), physicsClientId=client)
        reach = cos(DOWN_RAD)
        ahead = (
            eye.x_m + reach * cos(eye.heading_rad),
            eye.y_m + reach * sin(eye.heading_rad),
            height_m - sin(DOWN_RAD),
        )
        _, _, pixels, _, bodies = pybullet.getCameraImage(
            width,
            height,
            pybullet.computeViewMatrix((eye.x_m, eye.y_m, height_m), ahead, (0, 0, 1)),
            pybullet.computeProjectionMatrixFOV(view_deg, width / height, NEAR_M, FAR_M),
            lightDirection=LIGHT,
            renderer=pybullet.ER_TINY_RENDERER,
            physicsClientId=client,
        )
    finally:
        pybullet.disconnect(client)
    shown: Pixels = np.array(pixels, np.uint8).reshape(height, width, 4)[:, :, :3]
    shown[np.reshape(bodies, (height, width)) < 0] = SKY
    return shown


def png(pixels: Pixels) -> bytes:
    """A picture as a PNG file (ISO/IEC 15948): 8 bits a colour, rows without a filter."""
    height, width, _ = pixels.shape
    rows = np.zeros((height, 1 + 3 * width), np.uint8)  # each begins with its filter's number, 0
    rows[:, 1:] = pixels.reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )


def _add(client: int, one: Seen) -> None:
    shape = one.shape
    x_m, y_m, z_m, heading_rad = one.pose
    half_height_m = (shape.high_m - shape.low_m) / 2
    if shape.kind == pybullet.GEOM_BOX:
        size: dict[str, object] = {"halfExtents": (shape.half_length_m, shape.half_width_m, half_height_m)}
    elif shape.kind == pybullet.GEOM_SPHERE:
        size = {"radius": shape.half_length_m}
    else:
        size = {"radius": shape.half_length_m, "length": 2 * half_height_m}
    middle = (
        x_m + cos(heading_rad) * shape.x_m - sin(heading_rad) * shape.y_m,
        y_m + sin(heading_rad) * shape.x_m + cos(heading_rad) * shape.y_m,
        z_m + shape.low_m + half_height_m,
    )
    turn = (0.0, 0.0, sin(heading_rad / 2), cos(heading_rad / 2))
    visual = _visual(client, shape.kind, one.colour, **size)
    pybullet.createMultiBody(0, -1, visual, middle, turn, physicsClientId=client)


def _visual(client: int, kind: int, colour: Colour, **size: object) -> int:
    visual: int = pybullet.createVisualShape(
        kind,
        rgbaColor=[*(part / 255 for part in colour), 1],
        specularColor=[0, 0, 0],
        physicsClientId=client,
        **size,
    )
    return visual
