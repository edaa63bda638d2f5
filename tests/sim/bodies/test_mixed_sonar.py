"""Solid robots and avatars in one world hear each other by real and virtual sonar in a row."""

from math import dist, inf
from typing import Any

import numpy as np
import pytest

from benchmarks.bodies import embodied
from benchmarks.trial import Trial, packet, room
from robots.physical.body import RADIUS_M
from robots.world import WorldFile
from sim.world.agent import AgentSetup
from sim.world.simulation import Simulation
from tests.sim.rig import run_s, simulate, two_rooms


def hearing(world: WorldFile, *sonar: str) -> WorldFile:
    """All robots hear by these."""
    file = world.model_dump()
    for robot in file["robots"]:
        robot["sonar"] = sonar
    return WorldFile.model_validate(file)


def ranges_m(world: WorldFile) -> np.ndarray[Any, np.dtype[np.float64]]:
    simulation, _ = simulate(world)
    heard_m = simulation.bodies["fred"].sense().ranges_m
    assert heard_m is not None
    return heard_m


@pytest.mark.parametrize("second", [(1.5, 0.7, 0), (0.8, 1.5, 90), (1.4, 1.45, 10)])
def test_an_avatar_is_heard_as_a_solid_robot_would_be(second: tuple[float, float, float]) -> None:
    world = two_rooms((0.6, 0.7, 20), second=second, whiskers=32)
    solid, virtual = (ranges_m(embodied(world, "velocity", body)) for body in ("velocity", "avatar"))
    alone = ranges_m(two_rooms((0.6, 0.7, 20), whiskers=32))
    assert not np.allclose(solid, alone, atol=0.2)
    assert virtual == pytest.approx(solid, abs=0.05)


def test_walls_are_between_solid_robots_and_avatars() -> None:
    file = two_rooms((1, 1, 0), second=(1.4, 0.6, 0)).model_dump(mode="json")
    file["robots"][1] |= {"compartment": "east", "start": [2.4, 1.6, 0], "body": "avatar"}
    hidden = ranges_m(WorldFile.model_validate(file))
    assert hidden == pytest.approx(ranges_m(two_rooms((1, 1, 0))), abs=0.05)


def test_each_hears_only_by_what_it_is_fitted_with() -> None:
    world = embodied(two_rooms((0.4, 0.5, 0), second=(1.4, 0.5, 180)), "velocity", "avatar")
    real, virtual = ranges_m(hearing(world, "real")), ranges_m(hearing(world, "virtual"))
    assert real[0] == pytest.approx(2 - 0.04 - 0.4 - RADIUS_M, abs=0.05)  # the wall behind the avatar
    assert virtual[0] == pytest.approx(1.0 - 2 * RADIUS_M)
    assert np.isfinite(virtual).sum() == 1
    assert ranges_m(hearing(world, "real", "virtual")) == pytest.approx(np.minimum(real, virtual))


@pytest.mark.parametrize("start", [(0.6, 0.7, 20), (1.6, 1.1, -130)])
def test_the_maps_echoes_are_those_of_the_real_ring_where_nothing_else_stands(
    start: tuple[float, float, float],
) -> None:
    world = two_rooms(start, whiskers=32)
    assert ranges_m(hearing(world, "map")) == pytest.approx(ranges_m(hearing(world, "real")), abs=0.06)


def test_the_map_has_no_solid_robots() -> None:
    world = two_rooms((0.4, 0.5, 0), second=(1.4, 0.5, 180))
    alone = two_rooms((0.4, 0.5, 0))
    assert ranges_m(hearing(world, "map")) == pytest.approx(ranges_m(hearing(alone, "map")))
    assert ranges_m(hearing(world, "real"))[0] == pytest.approx(1.0 - 2 * RADIUS_M, abs=0.05)


class Careful:
    """Knows what it hears, and nothing else: drives ahead, stands while something is near ahead."""

    def __init__(self, setup: AgentSetup) -> None:
        self._body, self._drives = setup.body, setup.spec.name == "fred"

    def tick(self) -> None:
        heard_m = self._body.sense().ranges_m
        ahead_m = inf if heard_m is None else min(heard_m[[-1, 0, 1]])
        self._body.set_velocity(0.4 if self._drives and ahead_m > 0.3 else 0.0, 0.0)


@pytest.mark.parametrize(
    ("sonar", "passes"), [(("real",), True), (("real", "virtual"), False)], ids=["real only", "both"]
)
@pytest.mark.parametrize(
    "bodies", [("velocity", "avatar"), ("wheeled", "avatar")], ids=["velocity", "wheeled"]
)
def test_by_virtual_sonar_alone_a_solid_robot_stops_before_an_avatar(
    bodies: tuple[str, str], sonar: tuple[str, ...], passes: bool
) -> None:
    world = hearing(embodied(two_rooms((0.4, 0.5, 0), second=(1.4, 0.5, 180)), *bodies), *sonar)
    simulation = Simulation(world, make_agent=Careful, jitter_m=0.0)
    simulation.run_until(lambda: False, timeout_s=5)
    robots = simulation.truth().robots
    apart_m = dist((robots["fred"].x_m, robots["fred"].y_m), (robots["ginger"].x_m, robots["ginger"].y_m))
    assert apart_m < 2 * RADIUS_M if passes else 2 * RADIUS_M + 0.1 < apart_m < 0.9


def test_an_avatar_stops_before_a_solid_robot_by_real_sonar() -> None:
    world = hearing(embodied(two_rooms((0.4, 0.5, 0), second=(1.4, 0.5, 180)), "avatar", "velocity"), "real")
    simulation = Simulation(world, make_agent=Careful, jitter_m=0.0)
    simulation.run_until(lambda: False, timeout_s=5)
    robots = simulation.truth().robots
    assert 2 * RADIUS_M + 0.1 < robots["ginger"].x_m - robots["fred"].x_m < 0.9


def test_bodies_of_all_kinds_move_and_sense_alike_for_a_seed() -> None:
    def history(seed: int) -> list[str]:
        world = embodied(two_rooms((0.4, 0.5, 0), second=(1.4, 0.7, 180)), "wheeled", "avatar")
        simulation, puppets = simulate(world, seed=seed)
        puppets["fred"].velocity, puppets["ginger"].velocity = (0.3, 0.1), (0.2, -0.1)
        run_s(simulation, 1.5)
        return [repr((body.sense(), body.get_position())) for body in simulation.bodies.values()]

    assert history(3) == history(3)
    assert history(3) != history(4)


@pytest.mark.parametrize(
    ("bodies", "avoid"),
    [
        (("velocity", "avatar"), "patterns"),
        (("velocity", "avatar"), "vfh_plus"),
        (("velocity", "avatar"), "dynamic_window"),
        (("wheeled", "avatar"), "patterns"),
        (("avatar", "velocity"), "patterns"),
        (("avatar", "avatar"), "patterns"),
    ],
    ids=str,
)
def test_the_agent_moves_round_a_robot_that_it_cannot_touch(bodies: tuple[str, str], avoid: str) -> None:
    world = embodied(room(start=(1, 3, 0), other=(3, 3.05, 180)), *bodies)
    trial = Trial(world, packet("MOVE_TO", x=5, y=3, avoid=avoid), seed=1)
    trial.run()
    assert trial.events == ["goal"]
    nearest_m = min(dist((pose.x_m, pose.y_m), (3, 3.05)) for pose in trial.path)
    assert nearest_m > 2 * RADIUS_M
