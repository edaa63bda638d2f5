"""The pose estimate follows beacons where odometry drifts."""

from math import atan2, cos, hypot, pi, sin

import numpy as np
import pytest

from robots.perception.localisation import Localiser
from robots.physical.body import Pose
from robots.physical.geometry import wrap
from robots.physical.profile import BeaconSpec
from robots.physical.sightings import NONE_IN_VIEW, Sighting, Sightings

BEACONS = {
    "one": BeaconSpec(x_m=0, y_m=0, approach_rad=(0,)),
    "two": BeaconSpec(x_m=5, y_m=0, approach_rad=(pi,)),
}


def sighted(pose: Pose, rng: np.random.Generator) -> Sightings:
    seen = []
    for name, spec in BEACONS.items():
        dx, dy = spec.x_m - pose.x_m, spec.y_m - pose.y_m
        bearing = wrap(atan2(dy, dx) - pose.heading_rad + 0.01 * float(rng.standard_normal()))
        range_m = hypot(dx, dy) + 0.01 * float(rng.standard_normal())
        seen.append(Sighting(identity=name, range_m=range_m, bearing_rad=bearing))
    return Sightings.of(seen)


def circle(angle: float) -> Pose:
    return Pose(x_m=2.5 + cos(angle), y_m=2 + sin(angle), heading_rad=wrap(angle + pi / 2))


@pytest.mark.parametrize("seed", range(5))
def test_estimate_stays_within_centimetres_while_odometry_drifts(seed: int) -> None:
    rng = np.random.default_rng(seed)
    localiser = Localiser(circle(0), BEACONS)
    odometry = circle(0)
    for step in range(1, 600):
        true = circle(step * 0.02)
        odometry = Pose(
            x_m=odometry.x_m + 0.022 * cos(odometry.heading_rad),  # a tenth too far
            y_m=odometry.y_m + 0.022 * sin(odometry.heading_rad),
            heading_rad=wrap(odometry.heading_rad + 0.021),
        )
        estimate = localiser.update(odometry, sighted(true, rng))
    assert hypot(estimate.x_m - true.x_m, estimate.y_m - true.y_m) < 0.06
    assert abs(wrap(estimate.heading_rad - true.heading_rad)) < 0.05
    assert hypot(odometry.x_m - true.x_m, odometry.y_m - true.y_m) > 0.2


def test_without_beacons_the_estimate_is_odometry_from_the_start_it_was_told() -> None:
    localiser = Localiser(Pose(x_m=1, y_m=1, heading_rad=pi / 2), BEACONS)
    localiser.update(Pose(x_m=0, y_m=0, heading_rad=0), NONE_IN_VIEW)
    estimate = localiser.update(Pose(x_m=0.5, y_m=0, heading_rad=0), NONE_IN_VIEW)
    assert (estimate.x_m, estimate.y_m) == (pytest.approx(1), pytest.approx(1.5))


def test_uncertainty_grows_without_beacons_and_shrinks_with_them() -> None:
    rng = np.random.default_rng(0)
    localiser = Localiser(circle(0), BEACONS)
    for _ in range(50):
        localiser.update(circle(0), sighted(circle(0), rng))
    sure = localiser.memory().covariance[0]
    for _ in range(100):
        localiser.update(circle(0), NONE_IN_VIEW)
    assert localiser.memory().covariance[0] > sure


def test_one_absurd_sighting_is_not_believed() -> None:
    rng = np.random.default_rng(0)
    localiser = Localiser(circle(0), BEACONS)
    for _ in range(50):
        before = localiser.update(circle(0), sighted(circle(0), rng))
    after = localiser.update(circle(0), Sightings.of([Sighting(identity="one", range_m=0.5, bearing_rad=1)]))
    assert hypot(after.x_m - before.x_m, after.y_m - before.y_m) < 0.05


def test_a_robot_that_was_carried_off_finds_itself_again() -> None:
    rng = np.random.default_rng(0)
    localiser = Localiser(circle(0), BEACONS)
    for _ in range(50):
        localiser.update(circle(0), sighted(circle(0), rng))
    for _ in range(200):
        estimate = localiser.update(circle(0), sighted(circle(2), rng))
    assert hypot(estimate.x_m - circle(2).x_m, estimate.y_m - circle(2).y_m) < 0.1
