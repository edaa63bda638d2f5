"""What can be spared of the readings is left out; what cannot is a fault that names the sensor."""

from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest

from robots.errors import SensorFault
from robots.perception.health import FROZEN_M, Defect, SensorHealth
from robots.physical.body import Pose, Readings
from robots.physical.sightings import Sighting
from tests.robots.sensed import readings, sees

STEP_M = 0.02


def drive(health: SensorHealth, readings: list[Readings]) -> Readings:
    """The last of the readings of a robot that drives straight on."""
    for tick, one in enumerate(readings):
        judged = health.inspect(one, Pose(x_m=tick * STEP_M, y_m=0, heading_rad=0))
    return judged


def noisy(ticks: int, *, beam: float | None = None, seed: int = 0) -> list[Readings]:
    """Whiskers that read 1 m with noise, and one of them a constant."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(ticks):
        ranges_m = 1 + 0.01 * rng.standard_normal(16)
        if beam is not None:
            ranges_m[3] = beam
        found.append(replace(readings(), ranges_m=ranges_m))
    return found


LONG = round(2 * FROZEN_M / STEP_M)


@pytest.mark.parametrize("value", [nan, -1.0])
def test_a_whisker_that_reads_what_cannot_be_reads_as_the_nearer_beside_it(value: float) -> None:
    health = SensorHealth()
    judged = health.inspect(readings(whiskers={2: 0.7, 3: value, 4: 1.0}), Pose(x_m=0, y_m=0, heading_rad=0))
    assert judged.ranges_m is not None
    assert judged.ranges_m[3] == 0.7
    assert [defect.sensor for defect in health.degraded] == ["whisker 3"]


def test_whiskers_that_fail_side_by_side_are_bridged_by_the_sound_ones() -> None:
    health = SensorHealth()
    judged = health.inspect(readings(whiskers={15: nan, 0: nan, 1: 0.4}), Pose(x_m=0, y_m=0, heading_rad=0))
    assert judged.ranges_m is not None
    assert (judged.ranges_m[15], judged.ranges_m[0], judged.ranges_m[14]) == (0.4, 0.4, inf)


def test_more_than_a_quarter_of_the_whiskers_are_not_spared() -> None:
    lying = readings(whiskers=dict.fromkeys(range(5), nan))
    with pytest.raises(SensorFault, match="5 of 16 whiskers lie: whisker 0 reads nan"):
        SensorHealth().inspect(lying, Pose(x_m=0, y_m=0, heading_rad=0))


@pytest.mark.parametrize("value", [0.0, 0.3, 1.2])
def test_a_whisker_that_reads_the_same_all_the_way_is_left_out(value: float) -> None:
    health = SensorHealth()
    judged = drive(health, noisy(LONG, beam=value))
    assert judged.ranges_m is not None
    assert abs(judged.ranges_m[3] - 1) < 0.1
    assert "wherever it looks" in health.degraded[0].words


def test_a_wall_nearer_than_whiskers_can_tell_does_not_make_them_liars() -> None:
    health = SensorHealth(whisker_least_m=0.25)
    judged = drive(health, [readings(whiskers={3: 0.25, 4: 0.25, 5: 0.25})] * LONG)
    assert health.degraded == ()
    assert judged.ranges_m is not None
    assert judged.ranges_m[4] == 0.25


def test_whiskers_that_meet_nothing_are_not_frozen() -> None:
    health = SensorHealth()
    drive(health, [readings()] * LONG)
    assert health.degraded == ()


def test_a_robot_that_stands_may_read_the_same_for_ever() -> None:
    health = SensorHealth()
    for one in noisy(1) * 200:
        health.inspect(one, Pose(x_m=0, y_m=0, heading_rad=0))
    assert health.degraded == ()


def test_infra_red_that_tells_the_same_all_the_way_is_a_fault() -> None:
    with pytest.raises(SensorFault, match="the beacon sensor reads the same over"):
        drive(SensorHealth(), [readings(sees("bay", 2.0))] * LONG)


def test_a_sighting_that_is_no_number_is_left_out_as_long_as_there_are_others() -> None:
    health = SensorHealth()
    bad = Sighting(identity="bay", range_m=nan, bearing_rad=0)
    judged = health.inspect(readings(bad, sees("other", 1.0)), Pose(x_m=0, y_m=0, heading_rad=0))
    assert list(judged.sightings or ()) == ["other"]
    with pytest.raises(SensorFault, match="bay"):
        health.inspect(readings(bad), Pose(x_m=0, y_m=0, heading_rad=0))


def test_a_battery_gauge_that_lies_leaves_what_it_said_last() -> None:
    health = SensorHealth()
    judged = drive(health, [readings(battery=0.6), readings(battery=nan)])
    assert judged.battery == 0.6
    assert health.degraded == (Defect("battery", "the battery reads nan"),)


def test_odometry_or_a_capture_head_that_is_not_finite_is_a_fault() -> None:
    with pytest.raises(SensorFault, match="odometry"):
        SensorHealth().inspect(readings(), Pose(x_m=nan, y_m=0, heading_rad=0))
    with pytest.raises(SensorFault, match="capture head"):
        drive(SensorHealth(), [readings(head=(nan, 0))])


def test_a_packages_measurement_that_is_no_number_is_left_out() -> None:
    health = SensorHealth()
    judged = drive(health, [replace(readings(), measured={"temperature_c": 21.0, "dust_g": nan})])
    assert judged.measured == {"temperature_c": 21.0}
    assert [defect.words for defect in health.degraded] == ["dust_g reads nan"]
