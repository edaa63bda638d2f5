"""A slope slows every body alike."""

import pytest

from benchmarks.bodies import embodied
from robots.world import WorldFile
from tests.sim.rig import fred, run_s, simulate, two_rooms


def driven_m(body: str, pace: float) -> float:
    """How far a robot gets within four seconds on a slope of this pace."""
    world = two_rooms((0.5, 1, 0), kind="gap", width_m=1.2)
    slope = {"name": "hill", "x": (0, 4), "y": (0, 2), "pace": pace}
    file = WorldFile.model_validate(world.model_dump() | {"slopes": [slope]})
    simulation, puppets = simulate(embodied(file, body))
    puppets["fred"].velocity = (0.5, 0.0)
    run_s(simulation, 4)
    return fred(simulation).x_m - 0.5


@pytest.mark.parametrize("body", ["velocity", "wheeled", "avatar"])
def test_a_robot_gets_as_far_on_a_slope_as_its_pace_says(body: str) -> None:
    assert driven_m(body, 0.5) == pytest.approx(0.5 * driven_m(body, 1.0), rel=0.15)
