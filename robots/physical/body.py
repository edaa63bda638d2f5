"""The physical level (SRA): what a robot can feel and do. Simulated and real bodies implement `Body`.

Frames: a robot's own frame has x ahead, y to the left, angles counter-clockwise in radians (-pi, pi].
A robot never sees the simulator's truth, only what is declared here.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robots.data import StrEnum
from robots.physical.sightings import Sightings

RADIUS_M = 0.22
"""Radius of a rover's round body."""
GRIPPER_REACH_M = 0.34
"""From the rover's centre to the middle of its jaws."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """A place and heading in the plane; metres and radians."""

    x_m: float
    y_m: float
    heading_rad: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Gripper:
    """The gripper's own sensing: closed or open, and the tag of what the jaws' light barrier meets, if anything."""

    closed: bool
    between_jaws: str | None

    @property
    def holding(self) -> str | None:
        return self.between_jaws if self.closed else None


class Sensor(StrEnum):
    """The sensors that can be switched on and off. Odometry and battery gauge always run."""

    ULTRASONIC = "ultrasonic"
    BUMPER = "bumper"
    INFRA_RED = "infra_red"
    GRIPPER = "gripper"
    CAPTURE_HEAD = "capture_head"

    # NOTE: Enum's own __hash__ is written in Python, and sensors are looked up a hundred times a tick.
    __hash__ = str.__hash__


ALL_SENSORS = frozenset(Sensor)

READS = {
    Sensor.ULTRASONIC: "ranges_m",
    Sensor.BUMPER: "bumper",
    Sensor.INFRA_RED: "sightings",
    Sensor.GRIPPER: "gripper",
    Sensor.CAPTURE_HEAD: "capture_head_m",
}
"""Sensor to its field of `Readings`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Image:
    """An encoded picture that a camera has taken; `media_type` is image/png or image/jpeg."""

    media_type: str
    data: bytes


NOTHING_MEASURED: Mapping[str, float] = MappingProxyType({})
NO_IMAGES: Mapping[str, Image] = MappingProxyType({})


@dataclass(frozen=True, slots=True, kw_only=True)
class Readings:
    """The readings of one tick; None of a sensor that is off.

    `ranges_m`: shape (N,), metres, beam 0 straight ahead, counter-clockwise, inf where nothing is in range.
    `bumper`: touched since the last reading. `capture_head_m`: (x, y) deflection of the compliant capture head,
    metres, (0, 0) when nothing is on it. `battery`: what is left of its charge, 0 to 1. `measured`: by quantity, with
    its unit in the name, what sensors of installed packages read; they always run. `images`: by camera, of the cameras
    that run.
    """

    time_s: float
    ranges_m: NDArray[np.float64] | None
    bumper: bool | None
    sightings: Sightings | None
    gripper: Gripper | None
    capture_head_m: tuple[float, float] | None = (0.0, 0.0)
    battery: float = 1.0
    charging: bool = False
    measured: Mapping[str, float] = field(default_factory=lambda: NOTHING_MEASURED)
    images: Mapping[str, Image] = field(default_factory=lambda: NO_IMAGES)

    def by_sensor(self) -> dict[str, object]:
        """What the sensors and cameras that run have read."""
        read: dict[str, object] = {sensor: getattr(self, name) for sensor, name in READS.items()}
        read |= self.images
        return {sensor: value for sensor, value in read.items() if value is not None}


class Body(Protocol):
    """The seam through which the behavioural agent senses and acts."""

    def set_velocity(self, linear_m_s: float, angular_rad_s: float) -> None:
        """Command forward speed and turn rate; held until the next command."""
        ...

    def set_gripper(self, *, closed: bool) -> None:
        """Close or open the gripper."""
        ...

    def get_position(self) -> Pose:
        """Odometry: dead-reckoned from the start pose the robot was told; it drifts."""
        ...

    def run_sensors(self, sensors: frozenset[str]) -> None:
        """Run these sensors and cameras and no others; held until the next command. At the start all sensors run, and
        no camera.
        """
        ...

    def sense(self) -> Readings:
        """Read the sensors that run."""
        ...
