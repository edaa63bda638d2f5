"""Where the robot believes it is: an extended Kalman filter over odometry and beacon sightings.

State (x, y, heading) in the world's frame. Odometry's increments predict it; range and bearing of beacons on
the robot's map correct it.
"""

from collections.abc import Mapping
from math import nan

import numpy as np
from numpy.typing import NDArray

from robots.executive.memory import EstimateMemory
from robots.perception.kalman import correct, predict
from robots.physical.body import Pose
from robots.physical.geometry import to_robot, wrap
from robots.physical.profile import BeaconSpec
from robots.physical.sightings import Sightings

START_SIGMA = (0.15, 0.15, 0.15)


class Localiser:
    """Keeps the pose estimate. Feed it once a tick."""

    def __init__(self, start: Pose, beacons: Mapping[str, BeaconSpec]) -> None:
        self._state: NDArray[np.float64] = np.array(
            [start.x_m, start.y_m, start.heading_rad], dtype=np.float64
        )
        self._covariance: NDArray[np.float64] = np.diag(np.square(START_SIGMA))
        self._beacons = beacons
        self._odometry: Pose | None = None
        self._rejected = 0
        self._names: tuple[str, ...] = ()
        self._mapped: NDArray[np.float64] = np.empty((0, 2))

    @property
    def pose(self) -> Pose:
        x, y, heading = self._state.tolist()
        return Pose(x_m=x, y_m=y, heading_rad=wrap(heading))

    @property
    def sigma(self) -> tuple[float, float, float]:
        """One standard deviation of x, y (metres) and heading (radians)."""
        x, y, heading = np.sqrt(np.diag(self._covariance))
        return float(x), float(y), float(heading)

    def memory(self) -> EstimateMemory:
        return EstimateMemory(
            pose=self.pose,
            covariance=tuple(self._covariance.ravel().tolist()),
            odometry=self._odometry,
            rejected=self._rejected,
        )

    def recall(self, memory: EstimateMemory) -> None:
        """Go on from an estimate, and from what odometry read then: it counts on while the robot is off."""
        pose = memory.pose
        self._state[:] = pose.x_m, pose.y_m, pose.heading_rad
        self._covariance[:] = np.reshape(memory.covariance, (3, 3))
        self._odometry, self._rejected = memory.odometry, memory.rejected

    def update(self, odometry: Pose, sightings: Sightings) -> Pose:
        """Predict by the step since the last odometry, then correct by every mapped beacon in view."""
        self._predict(odometry)
        if sightings.names != self._names:
            self._names = sightings.names
            self._mapped = np.array([self._point(name) for name in self._names]).reshape(-1, 2)
        self._rejected = correct(self._state, self._covariance, self._mapped, sightings.read, self._rejected)
        return self.pose

    def _point(self, identity: str) -> tuple[float, float]:
        beacon = self._beacons.get(identity)
        return (nan, nan) if beacon is None else (beacon.x_m, beacon.y_m)

    def _predict(self, odometry: Pose) -> None:
        last, self._odometry = self._odometry, odometry
        if last is not None:
            step = to_robot(last, complex(odometry.x_m, odometry.y_m))
            turned_rad = wrap(odometry.heading_rad - last.heading_rad)
            predict(self._state, self._covariance, step.real, step.imag, turned_rad)
