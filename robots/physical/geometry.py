"""Plane geometry. A point is a complex number: x ahead (or east), y to the left (or north), metres."""

from cmath import rect
from math import pi

from robots.compiled import part
from robots.physical.body import Pose


@part
def wrap(angle_rad: float) -> float:
    """The same angle in (-pi, pi]. Kernels call it, too."""
    turned = (angle_rad + pi) % (2 * pi) - pi
    return pi if turned == -pi else turned


def clip(value: float, low: float = -1.0, high: float = 1.0) -> float:
    return max(low, min(high, value))


def to_world(pose: Pose, point: complex) -> complex:
    """A point of the robot's frame in the world's frame."""
    return complex(pose.x_m, pose.y_m) + point * rect(1.0, pose.heading_rad)


def to_robot(pose: Pose, point: complex) -> complex:
    """A point of the world's frame in the robot's frame."""
    return (point - complex(pose.x_m, pose.y_m)) * rect(1.0, -pose.heading_rad)
