"""The frame of a vehicle's map relative to the world's."""

from math import cos, pi, radians, sin, tau

from pydantic import Field

from robots.data import Checked

Pose = tuple[float, float, float]
"""x and y in metres, heading in radians, counter-clockwise from the x axis."""


class Frame(Checked):
    """How a point of the world is found on the vehicle's map: scaled, turned, then shifted by `offset`.

    `scale`: map units a metre; `rotation_deg` counter-clockwise; `offset`: where on the map the world's origin is.
    """

    map_id: str = Field(default="default", min_length=1)
    offset: tuple[float, float] = (0.0, 0.0)
    rotation_deg: float = 0.0
    scale: float = Field(default=1.0, gt=0)

    def on_map(self, pose: Pose) -> Pose:
        """A pose of the world on the map; the heading in (-pi, pi]."""
        x, y, heading = pose
        turn = radians(self.rotation_deg)
        return (
            self.offset[0] + self.scale * (x * cos(turn) - y * sin(turn)),
            self.offset[1] + self.scale * (x * sin(turn) + y * cos(turn)),
            wrapped(heading + turn),
        )

    def in_world(self, pose: Pose) -> Pose:
        """A pose on the map in the world; the heading in (-pi, pi]."""
        x = (pose[0] - self.offset[0]) / self.scale
        y = (pose[1] - self.offset[1]) / self.scale
        turn = -radians(self.rotation_deg)
        return x * cos(turn) - y * sin(turn), x * sin(turn) + y * cos(turn), wrapped(pose[2] + turn)


def wrapped(angle: float) -> float:
    """The angle in (-pi, pi]."""
    turned = angle % tau
    return turned - tau if turned > pi else turned
