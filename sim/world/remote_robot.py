"""A robot's body and link as its agent finds them in another process, and what is sent between the two in a tick."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.physical.body import Gripper, Pose, Readings
from robots.physical.sightings import Sightings
from robots.wire import Message


class ReadingsSender:
    """Packs one robot's odometry, readings and messages. Objects would take longer to send than the agent to tick."""

    def __init__(self) -> None:
        self._names: tuple[str, ...] | None = None

    def packed(self, odometry: Pose, readings: Readings, arrived: Sequence[Message]) -> tuple[Any, ...]:
        """A row: numbers and names, among them how many numbers `numbers_of` the readings has."""
        seen = readings.sightings
        names = None if seen is None else seen.names
        news = names if names != self._names else None
        self._names = names
        gripper = readings.gripper
        return (
            (odometry.x_m, odometry.y_m, odometry.heading_rad),
            readings.time_s,
            -1 if readings.ranges_m is None else len(readings.ranges_m),
            -1 if seen is None else len(seen),
            news,
            readings.bumper,
            None if gripper is None else (gripper.closed, gripper.between_jaws),
            readings.capture_head_m,
            readings.battery,
            readings.charging,
            dict(readings.measured),
            dict(readings.images),
            arrived,
        )


def numbers_of(readings: Readings) -> list[NDArray[np.float64]]:
    """The arrays of the readings, flat."""
    arrays = [] if readings.ranges_m is None else [readings.ranges_m]
    return arrays if readings.sightings is None else [*arrays, readings.sightings.read.ravel()]


@dataclass(slots=True)
class Commands:
    """What one robot's agent has commanded and sent in a tick."""

    velocity: tuple[float, float] | None = None
    grips: list[bool] = field(default_factory=list)
    sensors: frozenset[str] | None = None
    """None: as before."""
    sent: list[Message] = field(default_factory=list)

    @property
    def packed(self) -> tuple[Any, ...]:
        """To be sent."""
        return self.velocity, self.grips, self.sensors, self.sent


class RemoteRobot:
    """A robot's body and link as its agent finds them in another process. Implements `Body` and `Link`."""

    def __init__(self) -> None:
        self._odometry: Pose | None = None
        self._readings: Readings | None = None
        self._arrived: Sequence[Message] = ()
        self._names: tuple[str, ...] = ()
        self._sensors: frozenset[str] | None = None
        self._commands = Commands()

    def feel(self, row: tuple[Any, ...], numbers: NDArray[np.float64]) -> int:
        """Begin a tick.

        :param row: of a `ReadingsSender`. :param numbers: of this robot and those after it.
        :returns: how many of the numbers are this robot's.
        """
        (
            pose,
            time_s,
            beams,
            sighted,
            names,
            bumper,
            grip,
            capture_head_m,
            battery,
            charging,
            measured,
            images,
            self._arrived,
        ) = row
        self._odometry = Pose(x_m=pose[0], y_m=pose[1], heading_rad=pose[2])
        # NOTE: perception compares names to notice what comes into view: the same tuple is the same at a glance.
        self._names = self._names if names is None else names
        whiskers: int = max(0, beams)
        end: int = whiskers + 3 * max(0, sighted)
        self._readings = Readings(
            time_s=time_s,
            ranges_m=None if beams < 0 else numbers[:whiskers],
            bumper=bumper,
            sightings=None if sighted < 0 else Sightings(self._names, numbers[whiskers:end].reshape(-1, 3)),
            gripper=None if grip is None else Gripper(closed=grip[0], between_jaws=grip[1]),
            capture_head_m=capture_head_m,
            battery=battery,
            charging=charging,
            measured=measured,
            images=images,
        )
        self._commands = Commands()
        return end

    @property
    def commands(self) -> Commands:
        """What was commanded and sent in this tick."""
        return self._commands

    def set_velocity(self, linear_m_s: float, angular_rad_s: float) -> None:
        self._commands.velocity = (linear_m_s, angular_rad_s)

    def set_gripper(self, *, closed: bool) -> None:
        self._commands.grips.append(closed)

    def run_sensors(self, sensors: frozenset[str]) -> None:
        if sensors != self._sensors:
            self._sensors = self._commands.sensors = sensors

    def get_position(self) -> Pose:
        assert self._odometry is not None
        return self._odometry

    def sense(self) -> Readings:
        assert self._readings is not None
        return self._readings

    def send(self, message: Message) -> None:
        self._commands.sent.append(message)

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        arrived = self._arrived
        self._arrived = ()
        return arrived

    def close(self) -> None:
        """Nothing to release."""
