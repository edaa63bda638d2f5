from math import atan2, hypot, inf, pi, radians

import numpy as np
import pytest

from robots.physical.body import RADIUS_M, Readings
from robots.physical.sightings import Sightings
from robots.world import load_world
from sim.physics.sensors import aspect_rad
from sim.world.simulation import Simulation
from tests.sim.rig import fred, run_s, simulate, two_rooms


def read(simulation: Simulation, robot: str = "fred") -> Readings:
    return simulation.bodies[robot].sense()


def seen(simulation: Simulation, robot: str = "fred") -> Sightings:
    return read(simulation, robot).sightings


def test_whisker_beams_begin_ahead_and_go_counter_clockwise() -> None:
    # facing north at (0.7, 0.8): walls at y 1.96 ahead, x 0.04 left, y 0.04 behind, x 1.96 right
    simulation, _ = simulate(two_rooms((0.7, 0.8, 90)))
    ranges = read(simulation).ranges_m
    expected = [1.96 - 0.8, 0.7 - 0.04, 0.8 - 0.04, 1.96 - 0.7]
    assert ranges.shape == (16,)
    assert ranges[[0, 4, 8, 12]] == pytest.approx(np.array(expected) - RADIUS_M, abs=0.05)


def test_a_whisker_that_meets_nothing_in_range_says_infinity() -> None:
    simulation = Simulation(load_world("sample_store"), make_agent=lambda _: _Idle(), jitter_m=0.0)
    ranges = read(simulation, "yard_1").ranges_m  # stands at (1.4, 1.8) facing east: 6.6 m free ahead
    assert ranges[0] == inf
    assert np.isfinite(ranges[8])


class _Idle:
    def tick(self) -> None: ...


def test_whiskers_feel_other_rovers_and_standing_samples() -> None:
    simulation, _ = simulate(two_rooms((0.5, 0.6, 90), second=(1.4, 0.6, 0), samples={"rock": "corner"}))
    ranges = read(simulation).ranges_m
    assert ranges[0] == pytest.approx(1.5 - 0.06 - 0.6 - RADIUS_M, abs=0.05)
    assert ranges[12] == pytest.approx(1.4 - 0.5 - 2 * RADIUS_M, abs=0.05)


def test_a_beacon_is_seen_with_range_bearing_and_aspect() -> None:
    simulation, _ = simulate(two_rooms((1.2, 0.6, 90)))
    sighting = seen(simulation)["pass"]
    assert sighting.range_m == pytest.approx(hypot(0.8, 0.4), abs=0.05)
    assert sighting.bearing_rad == pytest.approx(atan2(0.4, 0.8) - pi / 2, abs=radians(2.5))
    # its axis looks west; from the beacon the rover is south of west, which is counter-clockwise of west
    assert sighting.aspect_rad == pytest.approx(atan2(0.4, 0.8), abs=radians(5))


@pytest.mark.parametrize(
    ("place", "aspect"),
    [
        ((2.0, 0.0), 0.0),
        ((1.0, 1.0), pi / 4),
        ((1.0, -1.0), -pi / 4),
        ((-1.0, 0.1), -0.0997),
        ((0.0, 1.0), pi / 2),
    ],
)
def test_aspect_is_measured_from_the_nearest_axis_counter_clockwise(
    place: tuple[float, float], aspect: float
) -> None:
    (found,) = aspect_rad(np.array([place]), np.zeros((1, 2)), np.array([[0.0, pi, np.nan]]))
    assert abs(found) == pytest.approx(abs(aspect), abs=1e-3)
    if abs(aspect) < pi / 2:
        assert found == pytest.approx(aspect, abs=1e-3)


def test_what_emits_without_an_axis_has_no_aspect() -> None:
    assert aspect_rad(np.array([[1.0, 1.0]]), np.zeros((1, 2)), np.array([[np.nan]])) == 0.0


def test_walls_block_the_line_of_sight_and_hatches_do_not() -> None:
    # east_bay is out of the west rover's reach, but a tag beyond the hatch shines through it
    through, _ = simulate(two_rooms((1, 1, 0), samples={"rock": "east_bay"}))
    beside, _ = simulate(two_rooms((1, 0.4, 0), samples={"rock": "east_bay"}))
    closed, _ = simulate(two_rooms((1, 1, 0), kind="door", samples={"rock": "east_bay"}))
    assert "rock" in seen(through)
    assert "rock" not in seen(beside)
    assert "rock" not in seen(closed)


def test_other_bodies_are_too_low_to_block_the_line_of_sight() -> None:
    simulation, _ = simulate(two_rooms((0.4, 1, 0), second=(1.2, 1, 0)))
    assert {"pass", "ginger"} <= set(seen(simulation))


def test_a_rover_sees_only_the_beacons_of_its_reach() -> None:
    simulation, _ = simulate(two_rooms((1, 1, 0)))
    assert set(seen(simulation)) == {"pass", "corner"}


def test_bearings_are_noisy_but_unbiased() -> None:
    simulation, _ = simulate(two_rooms((1, 1, 0)))
    bearings, ranges = [], []
    for _ in range(200):
        run_s(simulation, 0.05)
        bearings.append(seen(simulation)["pass"].bearing_rad)
        ranges.append(seen(simulation)["pass"].range_m)
    assert np.std(bearings) == pytest.approx(radians(0.5), rel=0.25)
    assert np.mean(bearings) == pytest.approx(0.0, abs=radians(0.15))
    assert np.std(ranges) == pytest.approx(0.01, rel=0.25)


def test_odometry_starts_at_the_rovers_configured_pose_and_drifts() -> None:
    simulation, puppets = simulate(two_rooms((0.5, 1, 0)), seed=3)
    told = puppets["fred"].setup.told
    assert simulation.bodies["fred"].get_position() == told
    assert 0 < hypot(told.x_m - 0.5, told.y_m - 1) < 0.15
    puppets["fred"].velocity = (0.3, 0.0)
    run_s(simulation, 3)
    driven = simulation.bodies["fred"].get_position().x_m - told.x_m
    truly = fred(simulation).x_m - 0.5
    assert driven == pytest.approx(truly, abs=0.06)
    assert driven != truly
