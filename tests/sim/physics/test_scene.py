from math import dist, hypot, pi

import numpy as np
import pytest

from robots.physical.body import RADIUS_M
from robots.world import Obstacle, Wall, load_world
from robots.world.walls import solid_pieces
from sim.physics.scene import Scene, pybullet
from sim.world.placement import rocks_of
from sim.world.simulation import Simulation
from tests.sim.rig import Puppet, fred, run_s, simulate, two_rooms

TO_JAWS_M = 0.31  # from a rover's centre to the tip of its jaws


def test_a_wall_stops_a_rover_at_its_jaws() -> None:
    simulation, puppets = simulate(two_rooms((1, 0.5, 0)))
    puppets["fred"].velocity = (0.5, 0.0)
    run_s(simulation, 4)
    assert fred(simulation).x_m == pytest.approx(2 - 0.04 - TO_JAWS_M, abs=0.01)


def test_a_wall_stops_a_rover_that_backs_into_it_at_its_body() -> None:
    simulation, puppets = simulate(two_rooms((1, 0.5, 0)))
    puppets["fred"].velocity = (-0.5, 0.0)
    run_s(simulation, 4)
    assert fred(simulation).x_m == pytest.approx(0.04 + RADIUS_M, abs=0.01)
    assert puppets["fred"].body.sense().bumper


@pytest.mark.parametrize("kind", ["hatch", "door"])
def test_no_rover_passes_a_hatch_or_a_closed_door(kind: str) -> None:
    simulation, puppets = simulate(two_rooms((1, 1, 0), kind=kind))
    puppets["fred"].velocity = (0.5, 0.0)
    run_s(simulation, 6)
    assert fred(simulation).x_m < 2


def test_a_rover_passes_a_gap() -> None:
    simulation, puppets = simulate(two_rooms((1, 1, 0), kind="gap", width_m=0.8))
    puppets["fred"].velocity = (0.5, 0.0)
    run_s(simulation, 4)
    assert fred(simulation).x_m == pytest.approx(1 + 0.5 * 4, abs=0.15)


def test_a_sample_is_pushed_through_a_hatch_that_stops_its_rover() -> None:
    simulation, puppets = simulate(two_rooms((1.2, 1, 0), samples={"rock": "pass"}))
    simulation.bodies["fred"].set_gripper(
        closed=True
    )  # nothing between the jaws yet: they stay shut and empty
    puppets["fred"].velocity = (0.3, 0.0)
    run_s(simulation, 6)
    rock = simulation.truth().samples["rock"]
    assert rock.x_m > 2.04
    assert fred(simulation).x_m < 2


def test_a_ball_rolls_on_when_it_is_no_longer_pushed_until_the_floor_has_stopped_it() -> None:
    simulation, puppets = simulate(two_rooms((0.5, 1, 0)))
    ball = simulation.scene.put_ball((0.9, 1.0), radius_m=0.05, rolling_m_s2=0.2)
    puppets["fred"].velocity = (0.3, 0.0)
    run_s(simulation, 1.5)
    assert simulation.scene.meets("fred", ball)
    pushed_to_m = simulation.scene.point_of(ball)[0]
    puppets["fred"].velocity = (0.0, 0.0)
    run_s(simulation, 2)
    assert not simulation.scene.meets("fred", ball)
    rolled_m = simulation.scene.point_of(ball)[0] - pushed_to_m
    assert rolled_m == pytest.approx(0.3**2 / (2 * 0.2), abs=0.02)
    run_s(simulation, 1)
    assert simulation.scene.point_of(ball)[0] - pushed_to_m == rolled_m


def test_a_sample_that_rolls_goes_on_rolling_after_a_resumption() -> None:
    world = two_rooms((0.5, 1, 0), samples={"rock": "pass"})
    ball = world.samples[0].model_copy(update={"rolling_m_s2": 0.2})
    world = world.model_copy(update={"samples": (ball,)})
    simulation, puppets = simulate(world)
    simulation.put("rock", (0.9, 1.0))
    puppets["fred"].velocity = (0.3, 0.0)
    run_s(simulation, 1.5)
    puppets["fred"].velocity = (0.0, 0.0)
    run_s(simulation, 0.5)
    at_m = simulation.truth().samples["rock"].x_m
    resumed = Simulation(world, make_agent=Puppet, snapshot=simulation.snapshot())
    for one in (simulation, resumed):
        assert not one.is_still
        run_s(one, 2)
        assert one.is_still
        assert one.truth().samples["rock"].x_m > at_m + 0.05
    assert simulation.truth().samples["rock"] == resumed.truth().samples["rock"]


def test_a_pushed_sample_stops_when_it_is_no_longer_pushed() -> None:
    simulation, puppets = simulate(two_rooms((1.2, 1, 0), samples={"rock": "pass"}))
    simulation.bodies["fred"].set_gripper(closed=True)
    puppets["fred"].velocity = (0.5, 0.0)
    run_s(simulation, 1.4)
    puppets["fred"].velocity = (-0.5, 0.0)
    run_s(simulation, 1)
    pushed = simulation.truth().samples["rock"].x_m
    run_s(simulation, 2)
    assert pushed > 2.01
    assert simulation.truth().samples["rock"].x_m == pushed


def test_rovers_do_not_pass_through_each_other() -> None:
    simulation, puppets = simulate(two_rooms((0.4, 1, 0), second=(1.4, 1, 0)))
    puppets["fred"].velocity = (0.5, 0.0)
    run_s(simulation, 3)
    robots = simulation.truth().robots
    apart_m = hypot(
        robots["fred"].x_m - robots["ginger"].x_m,
        robots["fred"].y_m - robots["ginger"].y_m,
    )
    assert apart_m >= 2 * RADIUS_M - 0.005
    assert puppets["ginger"].body.sense().bumper


def test_a_rover_turns_and_drives_along_its_heading() -> None:
    simulation, puppets = simulate(two_rooms((1, 1, 0)))
    puppets["fred"].velocity = (0.0, 1.0)
    run_s(simulation, pi / 2 + 0.5 / 6)  # the ramp to 1 rad/s at 6 rad/s2 costs half its time
    puppets["fred"].velocity = (0.0, 0.0)
    run_s(simulation, 0.5)
    assert fred(simulation).heading_rad == pytest.approx(pi / 2, abs=0.15)
    puppets["fred"].velocity = (0.5, 0.0)
    run_s(simulation, 1)
    assert fred(simulation).y_m > 1.2


def test_a_rover_keeps_within_its_acceleration() -> None:
    simulation, puppets = simulate(two_rooms((0.5, 1, 0)))
    puppets["fred"].velocity = (9.0, 0.0)
    run_s(simulation, 0.5)
    # half a second at 1 m/s2 covers an eighth of a metre; then the limit of 0.5 m/s holds
    assert fred(simulation).x_m - 0.5 == pytest.approx(0.125, abs=0.01)
    run_s(simulation, 1)
    assert fred(simulation).x_m - 0.5 == pytest.approx(0.625, abs=0.01)


def test_a_command_that_is_no_number_stops_the_rover() -> None:
    simulation, puppets = simulate(two_rooms((0.5, 1, 0)))
    puppets["fred"].velocity = (0.5, 0.0)
    run_s(simulation, 1)
    puppets["fred"].velocity = (float("nan"), float("inf"))
    run_s(simulation, 1)
    stopped = fred(simulation)
    run_s(simulation, 1)
    assert fred(simulation) == stopped


def test_a_wall_is_solid_but_for_its_hatches_and_gaps() -> None:
    wall = Wall.model_validate(
        {
            "start": (0, 0),
            "end": (8, 0),
            "openings": [
                {"kind": "door", "at_m": 6, "width_m": 1.0},
                {"kind": "hatch", "at_m": 2, "width_m": 0.4},
                {"kind": "gap", "at_m": 4, "width_m": 1.0},
            ],
        }
    )
    pieces = [(round(p.start[0], 6), round(p.end[0], 6), p.door) for p in solid_pieces(wall)]
    assert pieces == [
        (0.0, 1.8, False),
        (2.2, 3.5, False),
        (4.5, 5.5, False),
        (5.5, 6.5, True),
        (6.5, 8.0, False),
    ]


def test_rocks_stop_whiskers_and_rovers_but_not_the_line_of_sight() -> None:
    world = two_rooms((0.5, 1, 0), samples={"stone": "pass"})
    rock = {"name": "rock", "at": (1.3, 1.0), "radius_m": 0.2}
    simulation, puppets = simulate(world.model_validate({**world.model_dump(), "obstacles": [rock]}))
    readings = simulation.bodies["fred"].sense()
    assert readings.ranges_m[0] == pytest.approx(0.8 - 0.2 - RADIUS_M, abs=0.05)
    assert "stone" in readings.sightings
    puppets["fred"].velocity = (0.3, 0.0)
    run_s(simulation, 4)
    assert fred(simulation).x_m < 1.3 - 0.2 - RADIUS_M + 0.02


@pytest.mark.parametrize("seed", range(5))
def test_a_seed_puts_rocks_within_their_jitter_and_rovers_clear_of_them(seed: int) -> None:
    world = load_world("relocation_lab")
    rocks = rocks_of(world, np.random.default_rng(seed))
    for rock, spec in zip(rocks, world.obstacles, strict=True):
        assert 0 < dist(rock.point, spec.at) <= spec.jitter_m
    crowded = world.model_copy(
        update={"obstacles": (Obstacle(name="rock", at=(1.4, 4.7), radius_m=0.4, jitter_m=0.1),)}
    )
    simulation, _ = simulate(crowded, seed=seed, jitter_m=0.8)
    pose = simulation.truth().robots["fred"]
    near = rocks_of(crowded, np.random.default_rng(np.random.SeedSequence(seed).spawn(1)[0]))[0]
    assert dist((pose.x_m, pose.y_m), near.point) > near.radius_m + RADIUS_M


def test_a_scene_that_is_dropped_without_being_closed_gives_its_world_back() -> None:
    scene = Scene([], {}, {})
    client = scene.client
    assert pybullet.isConnected(client)
    del scene
    assert not pybullet.isConnected(client)
