"""The arithmetic of localisation's Kalman filter. Compiled (numba): a robot in a hall sees dozens of beacons a tick.

`state`: shape (3,): x, y in metres, heading in radians, world frame. `covariance`: shape (3, 3). Both are changed in
place.
"""

from math import atan2, cos, hypot, pi, sin

import numba
import numpy as np
from numpy.typing import NDArray

STEP_SIGMA_M, STEP_SIGMA_RAD = 0.004, 0.004
"""What stands still still drifts a little in belief: keeps the filter willing to learn."""
DRIFT_PER_M, DRIFT_PER_RAD = 0.08, 0.08
RANGE_SIGMA_M, RANGE_SIGMA_PER_M, BEARING_SIGMA_RAD = 0.02, 0.02, 0.03
GATE = 36.0
"""Squared Mahalanobis distance beyond which a sighting is not believed."""
NEAREST_M = 0.1
"""A beacon nearer than this tells no direction."""
REJECTED_BEFORE_DOUBT = 20
DOUBT_M2 = 0.25
"""What is added to every variance then; of the heading, square radians."""

Floats = NDArray[np.float64]


@numba.njit(cache=True)
def predict(state: Floats, covariance: Floats, ahead_m: float, left_m: float, turned_rad: float) -> None:
    """Go on by odometry's step, in the robot's own frame."""
    c, s = cos(state[2]), sin(state[2])
    east, north = c * ahead_m - s * left_m, s * ahead_m + c * left_m
    state[0] += east
    state[1] += north
    state[2] += turned_rad
    # NOTE: the Jacobian is the identity, but for how x and y depend on the heading: -north and east.
    p02, p12, p22 = covariance[0, 2], covariance[1, 2], covariance[2, 2]
    slip_m2 = (STEP_SIGMA_M + DRIFT_PER_M * hypot(ahead_m, left_m)) ** 2
    covariance[0, 0] += north * (north * p22 - 2 * p02) + slip_m2
    covariance[1, 1] += east * (east * p22 + 2 * p12) + slip_m2
    covariance[0, 1] += east * p02 - north * p12 - north * east * p22
    covariance[0, 2] = p02 - north * p22
    covariance[1, 2] = p12 + east * p22
    covariance[2, 2] += (STEP_SIGMA_RAD + DRIFT_PER_RAD * abs(turned_rad)) ** 2
    _mirror(covariance)


@numba.njit(cache=True)
def correct(state: Floats, covariance: Floats, beacons: Floats, seen: Floats, rejected: int) -> int:
    """Correct by one beacon after the other; how many sightings in a row were not believed.

    Many disbelieved in a row say that it is the estimate that is wrong (pushed, lifted): it is opened again.

    :param beacons: shape (N, 2): x and y on the map of what is seen, NaN of what is no beacon.
    :param seen: shape (N, 3): range in metres, bearing and aspect in radians as sighted.
    :param rejected: how many were not believed before.
    """
    across = np.empty((3, 2))
    gain = np.empty((3, 2))
    for n in range(len(seen)):
        if np.isnan(beacons[n, 0]) or seen[n, 0] <= NEAREST_M:
            continue
        dx, dy = beacons[n, 0] - state[0], beacons[n, 1] - state[1]
        away = max(hypot(dx, dy), 1e-3)
        off_m = seen[n, 0] - away
        off_rad = (seen[n, 1] - atan2(dy, dx) + state[2] + pi) % (2 * pi) - pi
        # how range (a, b) and bearing (d, e, and -1 for the heading) change with the state
        a, b, d, e = -dx / away, -dy / away, dy / away**2, -dx / away**2
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


@numba.njit(cache=True)
def _mirror(covariance: Floats) -> None:
    """It stays symmetric to the last bit."""
    covariance[1, 0] = covariance[0, 1]
    covariance[2, 0] = covariance[0, 2]
    covariance[2, 1] = covariance[1, 2]
