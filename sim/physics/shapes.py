"""Collision shapes in PyBullet, by the client's number; metres."""

from robots.body import GRIPPER_REACH_M, RADIUS_M
from sim.physics.quiet import quietly

with quietly():
    import pybullet


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
    """From a rover's middle to its jaws' front.

    They end short of their grip's middle, so that two rovers' jaws can meet at one sample.
    """
    return GRIPPER_REACH_M - half_width_m / 2


def rover(client: int, *, height_m: float, jaws_m: float, half_width_m: float) -> int:
    """A round body with its jaws ahead, which pass over standing samples but not through walls.

    :param jaws_m: how high the jaws are. :param half_width_m: of the jaws.
    """
    inside, tip = RADIUS_M - 0.04, front_m(half_width_m)
    shape: int = pybullet.createCollisionShapeArray(
        shapeTypes=[pybullet.GEOM_CYLINDER, pybullet.GEOM_BOX],
        radii=[RADIUS_M, 0.0],
        lengths=[height_m, 0.0],
        halfExtents=[[0.0, 0.0, 0.0], [(tip - inside) / 2, half_width_m, 0.05]],
        collisionFramePositions=[[0, 0, 0], [(tip + inside) / 2, 0, jaws_m - height_m / 2]],
        physicsClientId=client,
    )
    return shape
