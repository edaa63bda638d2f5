"""Generated stores can be simulated: rovers start where told, clear of all."""

import pytest

from robots.world import StoreShape, generate_world, store_shape
from tests.sim.rig import run_s, simulate


@pytest.mark.parametrize(
    "shape",
    [
        store_shape(),
        store_shape(samples=6, compartments=3),
        store_shape(store_robots=4, yard_robots=4, doors=8),
        store_shape(samples=12, bay_capacity=3),
    ],
    ids=["default", "three compartments", "two robots an aisle", "bays with berths"],
)
def test_nothing_touches_or_moves_at_the_start(shape: StoreShape) -> None:
    world = generate_world(shape)
    simulation, _ = simulate(world)
    try:
        run_s(simulation, 0.5)
        truth = simulation.truth()
        for spec in world.robots:
            pose = truth.robots[spec.name]
            assert (pose.x_m, pose.y_m) == pytest.approx(spec.start[:2], abs=0.01)
        assert {sample: found.ref for sample, found in truth.samples.items()} == world.initial_places
    finally:
        simulation.close()
