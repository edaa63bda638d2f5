"""PyBullet: imported without its banner, with collision shapes and the poses of upright bodies. Metres, radians."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from math import atan2, cos, remainder, sin, tau

from robots.physical.body import GRIPPER_REACH_M, RADIUS_M


@contextmanager
def _stderr_suppressed() -> Iterator[None]:
    """PyBullet prints its build time from native code at import; discard it."""
    stderr = os.dup(2)
    devnull = os.open(os.devnull, os.O_WRONLY)
    os.dup2(devnull, 2)
    try:
        yield
    finally:
        os.dup2(stderr, 2)
        os.close(stderr)
        os.close(devnull)


with _stderr_suppressed():
    import pybullet

__all__ = ["BodyPoses", "UprightPose", "box", "cylinder", "front_m", "pybullet", "rover"]

UprightPose = tuple[float, float, float, float]
"""x, y, z of a body's middle, and its heading; it does not tilt."""


def box(client: int, length_m: float, width_m: float, height_m: float) -> int:
    half = [length_m / 2, width_m / 2, height_m / 2]
    shape: int = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
    return shape


def cylinder(client: int, radius_m: float, height_m: float) -> int:
    shape: int = pybullet.createCollisionShape(
        pybullet.GEOM_CYLINDER, radius=radius_m, height=height_m, physicsClientId=client
    )
    return shape


def front_m(half_width_m: float) -> float:
    """Distance from a rover's middle to the front of its jaws.

    They end short of their grip's middle, so that two rovers' jaws can meet at one sample.
    """
    return GRIPPER_REACH_M - half_width_m / 2


def rover(client: int, *, height_m: float, jaws_m: float, half_width_m: float) -> int:
    """A round body with its jaws ahead, which pass over standing samples but not through walls.

    :param jaws_m: height of the jaws. :param half_width_m: of the jaws.
    """
    inside = RADIUS_M - 0.04
    tip = front_m(half_width_m)
    shape: int = pybullet.createCollisionShapeArray(
        shapeTypes=[pybullet.GEOM_CYLINDER, pybullet.GEOM_BOX],
        radii=[RADIUS_M, 0.0],
        lengths=[height_m, 0.0],
        halfExtents=[[0.0, 0.0, 0.0], [(tip - inside) / 2, half_width_m, 0.05]],
        collisionFramePositions=[[0, 0, 0], [(tip + inside) / 2, 0, jaws_m - height_m / 2]],
        physicsClientId=client,
    )
    return shape


class BodyPoses:
    """Cache of the poses of one PyBullet world's bodies. Whoever lets a body move must invalidate it."""

    def __init__(self, client: int) -> None:
        self._client = client
        self._known: dict[int, UprightPose] = {}

    def of(self, body: int) -> UprightPose:
        known = self._known.get(body)
        if known is None:
            (x, y, z), quaternion = self._read(body)
            known = (x, y, z, _heading_rad(quaternion))
            self._known[body] = known
        return known

    def invalidate(self, body: int) -> None:
        self._known.pop(body, None)

    def place(self, body: int, middle: tuple[float, float, float], heading_rad: float) -> None:
        """Put a body somewhere, upright."""
        quaternion = (0.0, 0.0, sin(heading_rad / 2), cos(heading_rad / 2))
        pybullet.resetBasePositionAndOrientation(body, middle, quaternion, physicsClientId=self._client)
        self.invalidate(body)

    def level(self, body: int, height_m: float) -> None:
        """Put a body that moved back into its plane, if a push has lifted or tilted it."""
        (x, y, z), quaternion = self._read(body)
        heading_rad = _heading_rad(quaternion)
        if z != height_m or quaternion[0] or quaternion[1]:
            self.place(body, (x, y, height_m), heading_rad)
        self._known[body] = (x, y, height_m, heading_rad)

    def _read(self, body: int) -> tuple[tuple[float, float, float], tuple[float, float, float, float]]:
        middle, quaternion = pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client)
        return middle, quaternion


def _heading_rad(quaternion: tuple[float, float, float, float]) -> float:
    """Heading of a body that only turns in the plane, by its quaternion x, y, z, w."""
    return remainder(2 * atan2(quaternion[2], quaternion[3]), tau)
