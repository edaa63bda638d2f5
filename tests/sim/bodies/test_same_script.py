"""The robots' software does not know its body: the same scripts do the same job on every kind of it."""

import pytest

from benchmarks.bodies import embodied
from benchmarks.errands import carry_out, to_store
from robots.world import load_world
from tests.sim.rig import with_only


@pytest.mark.parametrize(
    "bodies",
    [
        ("velocity",),
        ("wheeled",),
        ("avatar",),
        ("avatar", "velocity", "wheeled", "avatar"),
        ({"kind": "wheeled", "base_m": 0.3, "radius_m": 0.05, "speed_rad_s": 16, "slip": 0.1},),
    ],
    ids=["velocity", "wheeled", "avatar", "all together", "small slipping wheels"],
)
def test_the_main_job_is_done_by_the_same_scripts_on_every_kind_of_body(bodies: tuple[object, ...]) -> None:
    errand = to_store("sample_1", "door_1", "bay_7", "yard_1")
    world = load_world("sample_store")
    if len(bodies) == 1:
        world = with_only(world, *(script.robot for script in errand.scripts()))
    result = carry_out(embodied(world, *bodies), errand, seed=2)
    assert result.succeeded, result.words
    assert not any(ran.retries for ran in result.ran)
