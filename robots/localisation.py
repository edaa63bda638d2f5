"""Where the robot believes it is: an extended Kalman filter over odometry and beacon sightings.

State (x, y, heading) in the world's frame. Odometry's increments predict it; range and bearing of beacons on
the robot's map correct it.
"""

from collections.abc import Iterable, Mapping
from math import atan2, cos, hypot, sin

import numpy as np
from numpy.typing import NDArray

from robots.body import Pose, Sighting
from robots.geometry import to_robot, wrap
from robots.profile import BeaconSpec

START_SIGMA = (0.15, 0.15, 0.15)
STEP_SIGMA_M, STEP_SIGMA_RAD = 0.004, 0.004
"""What stands still still drifts a little in belief: keeps the filter willing to learn."""
DRIFT_PER_M, DRIFT_PER_RAD = 0.08, 0.08
RANGE_SIGMA_M, RANGE_SIGMA_PER_M, BEARING_SIGMA_RAD = 0.02, 0.02, 0.03
GATE = 36.0
"""Squared Mahalanobis distance beyond which a sighting is not believed."""
REJECTED_BEFORE_DOUBT = 20


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

    @property
    def pose(self) -> Pose:
        x, y, heading = (float(value) for value in self._state)
        return Pose(x_m=x, y_m=y, heading_rad=wrap(heading))

    @property
    def sigma(self) -> tuple[float, float, float]:
        """One standard deviation of x, y (metres) and heading (radians)."""
        x, y, heading = np.sqrt(np.diag(self._covariance))
        return float(x), float(y), float(heading)

    def update(self, odometry: Pose, sightings: Iterable[Sighting]) -> Pose:
        """Predict by the step since the last odometry, then correct by every mapped beacon in view."""
        self._predict(odometry)
        for sighting in sightings:
            beacon = self._beacons.get(sighting.identity)
            if beacon is not None and sighting.range_m > 0.1:
                self._correct(beacon, sighting)
        return self.pose

    def _predict(self, odometry: Pose) -> None:
        last, self._odometry = self._odometry, odometry
        if last is None:
            return
        step = to_robot(last, complex(odometry.x_m, odometry.y_m))
        turned = wrap(odometry.heading_rad - last.heading_rad)
        heading = float(self._state[2])
        c, s = cos(heading), sin(heading)
        self._state += (c * step.real - s * step.imag, s * step.real + c * step.imag, turned)
        jacobian = np.eye(3)
        jacobian[0, 2] = -s * step.real - c * step.imag
        jacobian[1, 2] = c * step.real - s * step.imag
        slip_m = STEP_SIGMA_M + DRIFT_PER_M * abs(step)
        slip_rad = STEP_SIGMA_RAD + DRIFT_PER_RAD * abs(turned)
        noise = np.diag([slip_m**2, slip_m**2, slip_rad**2])
        self._covariance = jacobian @ self._covariance @ jacobian.T + noise

    def _correct(self, beacon: BeaconSpec, sighting: Sighting) -> None:
        dx, dy = beacon.x_m - float(self._state[0]), beacon.y_m - float(self._state[1])
        away = max(hypot(dx, dy), 1e-3)
        expected_bearing = atan2(dy, dx) - float(self._state[2])
        surprise = np.array([sighting.range_m - away, wrap(sighting.bearing_rad - expected_bearing)])
        jacobian = np.array([[-dx / away, -dy / away, 0.0], [dy / away**2, -dx / away**2, -1.0]])
        spread_m = RANGE_SIGMA_M + RANGE_SIGMA_PER_M * sighting.range_m
        spread = np.array([[spread_m**2, 0.0], [0.0, BEARING_SIGMA_RAD**2]])
        across = self._covariance @ jacobian.T
        certainty = _inverse(jacobian @ across + spread)
        if float(surprise @ certainty @ surprise) > GATE:
            self._doubt()
            return
        self._rejected = 0
        gain = across @ certainty
        self._state += gain @ surprise
        shrunk = self._covariance - gain @ across.T
        self._covariance = (shrunk + shrunk.T) / 2

    def _doubt(self) -> None:
        """Many sightings disbelieved in a row: it is the estimate that is wrong (pushed, lifted); open it
        again.
        """
        self._rejected += 1
        if self._rejected >= REJECTED_BEFORE_DOUBT:
            self._covariance = self._covariance + np.diag([0.25, 0.25, 0.25])
            self._rejected = 0


def _inverse(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of a 2x2 matrix. NOTE: numpy's general inverse takes ten times as long."""
    (a, b), (c, d) = matrix.tolist()
    scale = 1 / (a * d - b * c)
    return np.array([[d * scale, -b * scale], [-c * scale, a * scale]])
