"""The offset between the robot's map and the world: `map` of ROS 2 seen from the world's frame."""

from math import atan2, cos, sin
from typing import NamedTuple


class PlanePose(NamedTuple):
    """Metres, and radians counter-clockwise from the x axis."""

    x_m: float
    y_m: float
    heading_rad: float


def turned(pose: PlanePose, offset: PlanePose) -> PlanePose:
    """A pose of the map's frame in the world's frame. `offset`: the pose of the map's origin in the world's frame."""
    c, s = cos(offset.heading_rad), sin(offset.heading_rad)
    heading = pose.heading_rad + offset.heading_rad
    return PlanePose(
        offset.x_m + c * pose.x_m - s * pose.y_m,
        offset.y_m + s * pose.x_m + c * pose.y_m,
        atan2(sin(heading), cos(heading)),
    )


def turned_back(pose: PlanePose, offset: PlanePose) -> PlanePose:
    """A pose of the world's frame in the map's frame; undoes `turned`."""
    c, s = cos(offset.heading_rad), sin(offset.heading_rad)
    dx, dy = pose.x_m - offset.x_m, pose.y_m - offset.y_m
    heading = pose.heading_rad - offset.heading_rad
    return PlanePose(c * dx + s * dy, c * dy - s * dx, atan2(sin(heading), cos(heading)))


def heading_of(orientation: object) -> float:
    """The heading of a quaternion, radians (-pi, pi]. `orientation`: geometry_msgs/Quaternion."""
    x, y, z, w = (float(getattr(orientation, name)) for name in "xyzw")
    return atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
