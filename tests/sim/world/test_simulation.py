import hashlib
from math import hypot

import pytest

from robots.physical.body import RADIUS_M
from robots.world import load_world
from robots.world.walls import clearance_m, panels_of
from sim.world.agent import AgentSetup
from sim.world.simulation import Simulation
from tests.sim.rig import run_s, simulate, two_rooms


class Wanderer:
    """Drives ahead, turns where whiskers are short, and snaps at what comes between its jaws."""

    def __init__(self, setup: AgentSetup) -> None:
        self._body = setup.body

    def tick(self) -> None:
        readings = self._body.sense()
        ahead_m = min(readings.ranges_m[[0, 1, -1]])
        self._body.set_velocity(*((0.5, 0.0) if ahead_m > 0.4 else (0.0, 1.2)))
        if readings.gripper.between_jaws is not None:
            self._body.set_gripper(closed=True)


def history(seed: int, *, seconds: float = 20.0) -> str:
    """A digest of all poses at each tick and of what is sensed."""
    simulation = Simulation(load_world("sample_store"), make_agent=Wanderer, seed=seed)
    digest = hashlib.sha256()
    for _ in range(round(seconds * 60)):
        simulation.step()
        digest.update(repr(simulation.truth()).encode())
    for body in simulation.bodies.values():
        digest.update(repr((body.sense().sightings, body.get_position())).encode())
    return digest.hexdigest()


def test_the_same_seed_gives_the_same_world_to_the_last_bit() -> None:
    assert history(5) == history(5)


def test_another_seed_gives_another_world() -> None:
    assert history(5, seconds=1) != history(6, seconds=1)


@pytest.mark.parametrize("seed", range(20))
def test_start_poses_are_clear_of_everything_and_in_the_robots_area(seed: int) -> None:
    world = load_world("sample_store")
    simulation = Simulation(world, make_agent=Wanderer, seed=seed)
    poses = simulation.truth().robots
    for spec in world.robots:
        pose = poses[spec.name]
        point = (pose.x_m, pose.y_m)
        assert world.area_of(spec).contains(point)
        assert hypot(pose.x_m - spec.start[0], pose.y_m - spec.start[1]) <= 0.4
        assert clearance_m(point, panels_of(world.walls)) > RADIUS_M
        others = [other for name, other in poses.items() if name != spec.name]
        assert all(hypot(pose.x_m - o.x_m, pose.y_m - o.y_m) > 2 * RADIUS_M for o in others)
        body = simulation.bodies[spec.name]
        assert not body.sense().bumper


def test_a_robot_knows_its_start_only_approximately() -> None:
    world = load_world("sample_store")
    told: dict[str, AgentSetup] = {}

    def keep(setup: AgentSetup) -> Wanderer:
        told[setup.spec.name] = setup
        return Wanderer(setup)

    simulation = Simulation(world, make_agent=keep, seed=4)
    for name, true in simulation.truth().robots.items():
        off_m = hypot(told[name].told.x_m - true.x_m, told[name].told.y_m - true.y_m)
        assert 0 < off_m < 0.15


def test_agents_act_at_20_hz_of_the_worlds_clock() -> None:
    simulation, puppets = simulate(two_rooms())
    run_s(simulation, 2)
    assert simulation.clock.now_s() == pytest.approx(2)
    assert puppets["fred"].ticks == 40


def test_truth_names_the_location_a_sample_lies_in_and_no_other() -> None:
    simulation, _ = simulate(two_rooms(samples={"rock": "corner", "stone": "pass"}))
    samples = simulation.truth().samples
    assert (samples["rock"].place, samples["stone"].place) == ("corner", "pass")
    simulation.scene.set_down("rock", (1.0, 1.5))
    assert simulation.truth().samples["rock"].place is None
