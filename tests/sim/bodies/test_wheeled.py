from math import hypot
from typing import Any

import numpy as np
import pytest

from benchmarks.bodies import embodied
from robots.physical.body import Pose
from robots.world import WorldFile
from tests.sim.rig import fred, run_s, simulate, two_rooms


def wheeled(world: WorldFile, **measures: Any) -> WorldFile:
    return embodied(world, {"kind": "wheeled", **measures})


def drift_m(seed: int, **measures: Any) -> float:
    """How far what odometry says of a way of about 2.4 m ends from what was driven."""
    world = wheeled(two_rooms((0.6, 1, 0), kind="gap", width_m=1.2), **measures)
    simulation, puppets = simulate(world, seed=seed)
    body = simulation.bodies["fred"]
    told = body.get_position()
    puppets["fred"].velocity = (0.5, 0.0)
    run_s(simulation, 5)
    puppets["fred"].velocity = (0.0, 0.0)
    run_s(simulation, 1)
    true, felt = fred(simulation), body.get_position()
    driven_m = hypot(true.x_m - 0.6, true.y_m - 1.0)
    return abs(hypot(felt.x_m - told.x_m, felt.y_m - told.y_m) - driven_m) + abs(
        (felt.heading_rad - told.heading_rad) - true.heading_rad
    )


def test_slip_on_the_floor_shows_as_drift_of_odometry() -> None:
    even = np.mean([drift_m(seed, slip=0.0) for seed in range(4)])
    uneven = np.mean([drift_m(seed, slip=0.3) for seed in range(4)])
    assert uneven > 2 * even


@pytest.mark.parametrize(("traction", "spins"), [(0.7, False), (0.1, True)])
def test_at_a_wall_strong_traction_stalls_the_wheels_and_weak_traction_lets_them_spin(
    traction: float, spins: bool
) -> None:
    simulation, puppets = simulate(wheeled(two_rooms((1, 0.5, 0)), traction=traction))
    puppets["fred"].velocity = (0.4, 0.0)
    run_s(simulation, 5)
    at_wall, counted = fred(simulation), simulation.bodies["fred"].get_position()
    run_s(simulation, 2)
    assert fred(simulation).x_m == pytest.approx(at_wall.x_m, abs=0.02)
    assert simulation.bodies["fred"].sense().bumper
    on_m = simulation.bodies["fred"].get_position().x_m - counted.x_m
    assert on_m > 0.5 if spins else abs(on_m) < 0.1


def test_a_rover_that_is_pushed_gives_way_and_its_encoders_feel_it_along_the_wheels_only() -> None:
    world = wheeled(two_rooms((0.5, 1, 0), kind="gap", width_m=1.2, second=(1.2, 1, 0)), torque_n_m=1.0)
    simulation, puppets = simulate(world)
    puppets["fred"].velocity = (0.5, 0.0)
    before = simulation.bodies["ginger"].get_position()
    run_s(simulation, 4)
    pushed_m = simulation.truth().robots["ginger"].x_m - 1.2
    after = simulation.bodies["ginger"].get_position()
    assert pushed_m > 0.1
    assert hypot(after.x_m - before.x_m, after.y_m - before.y_m) == pytest.approx(pushed_m, abs=0.1)


def test_a_rover_that_is_lifted_and_set_down_elsewhere_stands_there() -> None:
    simulation, puppets = simulate(wheeled(two_rooms((0.6, 1, 0))))
    puppets["fred"].velocity = (0.2, 0.0)
    run_s(simulation, 0.5)
    puppets["fred"].velocity = (0.0, 0.0)
    simulation.scene.put_rover("fred", Pose(x_m=1.2, y_m=0.7, heading_rad=1.0))
    run_s(simulation, 0.5)
    there = fred(simulation)
    assert hypot(there.x_m - 1.2, there.y_m - 0.7) < 0.03


def test_wheels_roll_alike_for_a_seed_and_otherwise_for_another() -> None:
    def end(seed: int) -> Pose:
        simulation, puppets = simulate(wheeled(two_rooms((0.6, 1, 0))), seed=seed)
        puppets["fred"].velocity = (0.3, 0.2)
        run_s(simulation, 2)
        return fred(simulation)

    assert end(3) == end(3)
    assert end(3) != end(4)
