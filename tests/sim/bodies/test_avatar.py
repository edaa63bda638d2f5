from math import copysign, radians

import numpy as np
import pytest

from benchmarks.bodies import embodied
from robots.adapters.peripheral import CLOSED, OPEN
from robots.physical.body import RADIUS_M, Pose
from robots.world import WorldFile, load_world
from robots.world.walls import Panel
from sim.bodies import FloorMap
from sim.snapshot import Rock
from tests.sim.rig import fred, run_s, simulate, two_rooms, with_only

TO_JAWS_M = 0.31
WALL = Panel(start=(2.0, 0.0), end=(2.0, 2.0))


def avatar(world: WorldFile) -> WorldFile:
    """Fred is an avatar, who else there is has a velocity-set body."""
    return embodied(world, "avatar", "velocity")


@pytest.mark.parametrize(
    ("pose", "room_m"),
    [
        (Pose(x_m=1.0, y_m=1.0, heading_rad=0.0), 0.96 - TO_JAWS_M),
        (Pose(x_m=1.0, y_m=1.0, heading_rad=radians(180)), 0.96 - RADIUS_M),
        (Pose(x_m=1.8, y_m=1.0, heading_rad=radians(90)), 0.16 - RADIUS_M),
        (Pose(x_m=2.0, y_m=2.5, heading_rad=radians(-90)), 0.46 - TO_JAWS_M),
    ],
    ids=["jaws to the wall", "back to the wall", "into the wall", "jaws to its end"],
)
def test_room_is_from_hull_or_jaws_to_the_surface_of_a_wall(pose: Pose, room_m: float) -> None:
    assert FloorMap([WALL]).clearance_m(pose) == pytest.approx(room_m, abs=0.025)


def test_room_is_from_the_jaws_flank_to_the_end_of_a_wall() -> None:
    pose = Pose(x_m=2.25, y_m=2.11, heading_rad=radians(180))
    assert FloorMap([WALL]).clearance_m(pose) == pytest.approx(0.11 - 0.06 - 0.04)


def test_room_is_from_hull_or_jaws_to_a_rock() -> None:
    floor = FloorMap([], [Rock((2.0, 1.0), 0.3)])
    assert floor.clearance_m(Pose(x_m=1.0, y_m=1.0, heading_rad=0.0)) == pytest.approx(0.7 - TO_JAWS_M)
    assert floor.clearance_m(Pose(x_m=1.0, y_m=1.0, heading_rad=2.0)) == pytest.approx(0.7 - RADIUS_M)


def test_an_empty_floor_has_room_without_end() -> None:
    assert FloorMap([]).clearance_m(Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)) == np.inf


@pytest.mark.parametrize("speed_m_s", [0.5, -0.5])
@pytest.mark.parametrize("kind", ["hatch", "door"])
@pytest.mark.parametrize("heading_deg", [0, 37, -160])
def test_no_avatar_goes_through_a_wall_a_hatch_or_a_closed_door(
    speed_m_s: float, kind: str, heading_deg: float
) -> None:
    simulation, puppets = simulate(avatar(two_rooms((1, 1, heading_deg), kind=kind)))
    puppets["fred"].velocity = (speed_m_s, 0.3)
    run_s(simulation, 4)
    puppets["fred"].velocity = (speed_m_s, 0.0)
    run_s(simulation, 4)
    pose = fred(simulation)
    assert RADIUS_M + 0.03 < pose.x_m < 2 - RADIUS_M - 0.03
    assert RADIUS_M + 0.03 < pose.y_m < 2 - RADIUS_M - 0.03
    assert simulation.bodies["fred"].sense().bumper


@pytest.mark.parametrize(("start_m", "speed_m_s"), [(4.9, 0.5), (6.1, -0.5)])
def test_a_door_stops_an_avatar_until_it_is_open_and_again_once_it_is_closed(
    start_m: float, speed_m_s: float
) -> None:
    """The door stands at x = 5.5 m."""
    simulation, puppets = simulate(avatar(with_only(load_world("guarded_store"), "store_1")))
    gate = simulation.peripherals.mechanisms["gate_1"]

    def drive_s(seconds: float, velocity_m_s: float) -> float:
        """The end's distance beyond the door, along the way of the first drive."""
        puppets["store_1"].velocity = (velocity_m_s, 0.0)
        run_s(simulation, seconds)
        return (simulation.scene.pose("store_1").x_m - 5.5) * copysign(1.0, speed_m_s)

    simulation.scene.put_rover("store_1", Pose(x_m=start_m, y_m=6.3, heading_rad=0.0))
    assert drive_s(3.0, speed_m_s) < -RADIUS_M - 0.03
    assert simulation.bodies["store_1"].sense().bumper
    gate.go_to(OPEN)
    assert drive_s(4.1, 0.0) < -RADIUS_M
    assert drive_s(2.5, speed_m_s) > 0.5
    gate.go_to(CLOSED)
    drive_s(4.1, 0.0)
    assert drive_s(4.0, -speed_m_s) > RADIUS_M + 0.03
    simulation.close()


def test_an_avatar_passes_a_gap_and_comes_to_where_its_velocity_takes_it() -> None:
    simulation, puppets = simulate(avatar(two_rooms((1, 1, 0), kind="gap", width_m=0.8)))
    puppets["fred"].velocity = (0.5, 0.0)
    run_s(simulation, 4)
    assert fred(simulation).x_m == pytest.approx(1 + 0.5 * 4 - 0.5 * 0.25, abs=0.02)
    assert not simulation.bodies["fred"].sense().bumper


def test_an_avatar_casts_no_shadow_in_the_physical_world() -> None:
    world = avatar(two_rooms((0.4, 1, 0), second=(1.2, 1, 180), samples={"rock": "pass"}))
    simulation, puppets = simulate(world)
    puppets["fred"].velocity = (0.5, 0.0)
    run_s(simulation, 3)
    robots, rock = simulation.truth().robots, simulation.truth().samples["rock"]
    assert robots["fred"].x_m > 1.6  # through where ginger stands
    assert (robots["ginger"].x_m, robots["ginger"].y_m) == (1.2, 1.0)
    assert not puppets["ginger"].body.sense().bumper
    assert (rock.x_m, rock.y_m) == pytest.approx((2.0, 1.0), abs=0.05)


def test_an_avatar_and_solid_robots_see_each_others_beacons() -> None:
    simulation, _ = simulate(avatar(two_rooms((0.4, 1, 0), second=(1.4, 1, 180))))
    for observer, other in (("fred", "ginger"), ("ginger", "fred")):
        sightings = simulation.bodies[observer].sense().sightings
        assert sightings is not None
        seen = sightings[other]
        assert (seen.range_m, seen.bearing_rad) == pytest.approx((1.0, 0.0), abs=0.05)


def test_an_avatar_hears_solid_robots_and_walls() -> None:
    simulation, _ = simulate(avatar(two_rooms((0.4, 1, 0), second=(1.4, 1, 180))))
    readings = simulation.bodies["fred"].sense()
    assert readings.ranges_m is not None
    assert readings.ranges_m[0] == pytest.approx(1.0 - 2 * RADIUS_M, abs=0.05)
    assert readings.ranges_m[8] == pytest.approx(0.4 - 0.04 - RADIUS_M, abs=0.05)


def test_an_avatars_jaws_take_a_sample_with_them() -> None:
    simulation, puppets = simulate(avatar(two_rooms((1.66, 1, 0), samples={"rock": "pass"})))
    run_s(simulation, 0.1)
    assert simulation.bodies["fred"].sense().gripper.between_jaws == "rock"  # type: ignore[union-attr]
    simulation.bodies["fred"].set_gripper(closed=True)
    puppets["fred"].velocity = (-0.5, 0.0)
    run_s(simulation, 2)
    rock = simulation.truth().samples["rock"]
    assert rock.holders == ("fred",)
    assert rock.x_m < 1.5
