"""`macta soak`: what it does to the world that it tries the service with."""

import random
from pathlib import Path

from app.cli.soak import push_one, true_state, with_outages
from robots.world import load_world, world_yaml
from sim.process.snapshot_file import SnapshotFile
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation

WORLD = load_world("sample_store")


def test_each_robot_falls_silent_at_times_of_its_own(tmp_path: Path) -> None:
    world = with_outages(WORLD, random.Random(1))
    links = [world.link_of(robot) for robot in world.robots]
    assert len({link.outages for link in links}) == len(WORLD.robots)
    assert all(any(not link.in_contact(float(at_s)) for at_s in range(600)) for link in links)
    assert all(any(link.in_contact(float(at_s)) for at_s in range(600)) for link in links)
    file = tmp_path / "world.yaml"
    file.write_text(world_yaml(world))
    assert load_world(file) == world


def test_a_rover_that_is_pushed_stands_elsewhere_in_the_snapshot_and_nothing_else_does(
    tmp_path: Path,
) -> None:
    with SnapshotFile(tmp_path / "worlds" / f"{WORLD.name}.json") as file:
        simulation = Simulation(WORLD, make_agent=behavioural_agent, seed=1, jitter_m=0.0)
        file.write(simulation.snapshot())
        before = simulation.truth()
        simulation.close()
    assert push_one(tmp_path, WORLD, random.Random(3)) == "rover pushed"
    with SnapshotFile(tmp_path / "worlds" / f"{WORLD.name}.json") as file:
        after = file.read(WORLD)
    moved = [name for name, pose in after.rovers.items() if pose != before.robots[name]]
    assert len(moved) == 1
    lies = {name: sample.ref for name, sample in before.samples.items()}
    assert true_state(tmp_path, WORLD).lies == lies


def test_without_a_world_that_is_kept_nobody_is_pushed(tmp_path: Path) -> None:
    assert push_one(tmp_path, WORLD, random.Random(3)) == ""
