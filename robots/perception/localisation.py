"""Pose estimation: an extended Kalman filter over odometry and beacon sightings.

State: (x, y, heading) in the world's frame. Odometry's increments predict it; range and bearing of beacons on the
robot's map correct it. The arithmetic is compiled (numba): a robot in a hall sees dozens of beacons a tick. There
`state` has shape (3,), metres and radians, `covariance` shape (3, 3); both are changed in place.
"""

from collections.abc import Mapping
from math import atan2, cos, hypot, nan, pi, sin

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from robots.compiled import kernel, part
from robots.data import Checked
from robots.physical.body import Pose
from robots.physical.geometry import to_robot, wrap
from robots.physical.profile import BeaconSpec
from robots.physical.sightings import Sightings

START_SIGMA = (0.15, 0.15, 0.15)


class EstimateMemory(Checked):
    """The estimate; `covariance` row by row of x, y, heading; `odometry` as last read."""

    pose: Pose
    covariance: tuple[float, ...] = Field(min_length=9, max_length=9)
    odometry: Pose | None
    rejected: int


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

    def memory(self) -> EstimateMemory:
        return EstimateMemory(
            pose=self.pose,
            covariance=tuple(self._covariance.ravel().tolist()),
            odometry=self._odometry,
            rejected=self._rejected,
        )

    def recall(self, memory: EstimateMemory) -> None:
        """Restore an estimate with its odometry, which counts on while the robot is off."""
        pose = memory.pose
        self._state[:] = pose.x_m, pose.y_m, pose.heading_rad
        self._covariance[:] = np.reshape(memory.covariance, (3, 3))
        self._odometry = memory.odometry
        self._rejected = memory.rejected

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
        last = self._odometry
        self._odometry = odometry
        if last is not None:
            step = to_robot(last, complex(odometry.x_m, odometry.y_m))
            turned_rad = wrap(odometry.heading_rad - last.heading_rad)
            predict(self._state, self._covariance, step.real, step.imag, turned_rad)


STEP_SIGMA_M = 0.004
STEP_SIGMA_RAD = 0.004
"""Process noise of a robot at rest, so that the filter keeps correcting."""
DRIFT_PER_M = 0.08
DRIFT_PER_RAD = 0.08
RANGE_SIGMA_M = 0.02
RANGE_SIGMA_PER_M = 0.02
BEARING_SIGMA_RAD = 0.03
GATE = 36.0
"""Squared Mahalanobis distance beyond which a sighting is rejected."""
NEAREST_M = 0.1
"""A beacon nearer than this has no usable bearing."""
REJECTED_BEFORE_DOUBT = 20
DOUBT_M2 = 0.25
"""Added to every variance then; of the heading, square radians."""

Floats = NDArray[np.float64]


@kernel
def predict(state: Floats, covariance: Floats, ahead_m: float, left_m: float, turned_rad: float) -> None:
    """Predict by a step of odometry, robot's frame."""
    c = cos(state[2])
    s = sin(state[2])
    east = c * ahead_m - s * left_m
    north = s * ahead_m + c * left_m
    state[0] += east
    state[1] += north
    state[2] += turned_rad
    # NOTE: the Jacobian is the identity, but for how x and y depend on the heading: -north and east.
    p02 = covariance[0, 2]
    p12 = covariance[1, 2]
    p22 = covariance[2, 2]
    slip_m2 = (STEP_SIGMA_M + DRIFT_PER_M * hypot(ahead_m, left_m)) ** 2
    covariance[0, 0] += north * (north * p22 - 2 * p02) + slip_m2
    covariance[1, 1] += east * (east * p22 + 2 * p12) + slip_m2
    covariance[0, 1] += east * p02 - north * p12 - north * east * p22
    covariance[0, 2] = p02 - north * p22
    covariance[1, 2] = p12 + east * p22
    covariance[2, 2] += (STEP_SIGMA_RAD + DRIFT_PER_RAD * abs(turned_rad)) ** 2
    _mirror(covariance)


@kernel
def correct(state: Floats, covariance: Floats, beacons: Floats, seen: Floats, rejected: int) -> int:
    """Correct by each beacon in turn; returns how many sightings in a row were rejected.

    Many rejections in a row mean that the estimate is wrong (the robot was pushed or lifted): its variance is raised.

    :param beacons: shape (N, 2): x and y on the map, NaN of what is no beacon.
    :param seen: shape (N, 3): range in metres, bearing and aspect in radians.
    :param rejected: the number of rejections in a row before.
    """
    across = np.empty((3, 2))
    gain = np.empty((3, 2))
    for n in range(len(seen)):
        if np.isnan(beacons[n, 0]) or seen[n, 0] <= NEAREST_M:
            continue
        dx = beacons[n, 0] - state[0]
        dy = beacons[n, 1] - state[1]
        away = max(hypot(dx, dy), 1e-3)
        off_m = seen[n, 0] - away
        off_rad = (seen[n, 1] - atan2(dy, dx) + state[2] + pi) % (2 * pi) - pi
        # the Jacobian: of the range (a, b, 0), of the bearing (d, e, -1)
        a = -dx / away
        b = -dy / away
        d = dy / away**2
        e = -dx / away**2
        for i in range(3):
            across[i, 0] = covariance[i, 0] * a + covariance[i, 1] * b
            across[i, 1] = covariance[i, 0] * d + covariance[i, 1] * e - covariance[i, 2]
        spread_m2 = (RANGE_SIGMA_M + RANGE_SIGMA_PER_M * seen[n, 0]) ** 2
        s00 = a * across[0, 0] + b * across[1, 0] + spread_m2
        s01 = a * across[0, 1] + b * across[1, 1]
        s11 = d * across[0, 1] + e * across[1, 1] - across[2, 1] + BEARING_SIGMA_RAD**2
        scale = 1 / (s00 * s11 - s01 * s01)
        if scale * (s11 * off_m**2 - 2 * s01 * off_m * off_rad + s00 * off_rad**2) > GATE:
            rejected += 1
            if rejected >= REJECTED_BEFORE_DOUBT:
                rejected = 0
                for i in range(3):
                    covariance[i, i] += DOUBT_M2
            continue
        rejected = 0
        for i in range(3):
            gain[i, 0] = scale * (across[i, 0] * s11 - across[i, 1] * s01)
            gain[i, 1] = scale * (across[i, 1] * s00 - across[i, 0] * s01)
            state[i] += gain[i, 0] * off_m + gain[i, 1] * off_rad
        for i in range(3):
            for j in range(i, 3):
                covariance[i, j] -= gain[i, 0] * across[j, 0] + gain[i, 1] * across[j, 1]
        _mirror(covariance)
    return rejected


@part
def _mirror(covariance: Floats) -> None:
    """Keep it exactly symmetric."""
    covariance[1, 0] = covariance[0, 1]
    covariance[2, 0] = covariance[0, 2]
    covariance[2, 1] = covariance[1, 2]
