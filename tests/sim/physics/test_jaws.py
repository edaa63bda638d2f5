from math import hypot, pi

import pytest

from robots.physical.body import GRIPPER_REACH_M
from robots.world import WorldFile
from sim.world.simulation import Simulation
from tests.sim.rig import Puppet, fred, run_s, simulate, two_rooms

BEFORE_PASS = (2 - GRIPPER_REACH_M - 0.3, 1.0, 0.0)


def grip_rock() -> tuple[Simulation, dict[str, Puppet]]:
    """Fred drives up to the rock in the hatch, until its light barrier meets it, and closes its jaws."""
    simulation, puppets = simulate(two_rooms(BEFORE_PASS, samples={"rock": "pass"}))
    body = simulation.bodies["fred"]
    assert body.sense().gripper.between_jaws is None
    puppets["fred"].velocity = (0.2, 0.0)
    assert simulation.run_until(lambda: body.sense().gripper.between_jaws == "rock", timeout_s=5)
    puppets["fred"].velocity = (0.0, 0.0)
    assert body.sense().gripper.holding is None
    body.set_gripper(closed=True)
    run_s(simulation, 0.5)
    return simulation, puppets


def test_closing_on_a_sample_grips_it() -> None:
    simulation, _puppets = grip_rock()
    assert simulation.bodies["fred"].sense().gripper.holding == "rock"
    rock = simulation.truth().samples["rock"]
    assert (rock.holders, rock.place, rock.ref) == (("fred",), None, "fred")


def test_a_held_sample_goes_where_its_rover_goes_and_is_set_down_below_the_jaws() -> None:
    simulation, puppets = grip_rock()
    puppets["fred"].velocity = (-0.3, 0.0)
    run_s(simulation, 2)
    puppets["fred"].velocity = (0.0, 0.0)
    run_s(simulation, 1)
    simulation.bodies["fred"].set_gripper(closed=False)
    run_s(simulation, 0.1)
    rock, pose = simulation.truth().samples["rock"], fred(simulation)
    assert rock.holders == ()
    assert rock.x_m < 1.6
    assert hypot(rock.x_m - pose.x_m, rock.y_m - pose.y_m) == pytest.approx(GRIPPER_REACH_M, abs=0.005)


def test_closing_on_nothing_holds_nothing() -> None:
    simulation, _ = simulate(two_rooms((1, 0.5, 0), samples={"rock": "pass"}))
    simulation.bodies["fred"].set_gripper(closed=True)
    run_s(simulation, 0.2)
    gripper = simulation.bodies["fred"].sense().gripper
    assert gripper.closed
    assert gripper.holding is None
    assert simulation.truth().samples["rock"].ref == "pass"


def test_a_held_sample_is_lifted_out_of_its_own_whiskers() -> None:
    simulation, _ = grip_rock()
    # ahead is the hatch: with the rock on the floor the beam would be 0.07 m long
    assert simulation.bodies["fred"].sense().ranges_m[0] > 1


def test_a_held_tag_is_hidden_from_its_holder_only() -> None:
    world = two_rooms(BEFORE_PASS, second=(0.5, 1, 0), samples={"rock": "pass"})
    simulation, puppets = simulate(world)
    puppets["fred"].velocity = (0.2, 0.0)
    body = simulation.bodies["fred"]
    assert simulation.run_until(lambda: body.sense().gripper.between_jaws == "rock", timeout_s=5)
    body.set_gripper(closed=True)
    puppets["fred"].velocity = (-0.2, 0.0)
    run_s(simulation, 1)
    assert "rock" not in body.sense().sightings
    tag = simulation.bodies["ginger"].sense().sightings["rock"]
    jaws_x = fred(simulation).x_m + GRIPPER_REACH_M
    assert tag.range_m == pytest.approx(jaws_x - 0.5, abs=0.05)


def test_two_rovers_may_hold_one_sample_and_the_second_keeps_it() -> None:
    world = two_rooms(BEFORE_PASS, second=(1.0, 0.4, 90), samples={"rock": "pass"})
    simulation, puppets = simulate(world)
    giver, taker = simulation.bodies["fred"], simulation.bodies["ginger"]
    puppets["fred"].velocity = (0.2, 0.0)
    assert simulation.run_until(lambda: giver.sense().gripper.between_jaws == "rock", timeout_s=5)
    giver.set_gripper(closed=True)
    puppets["fred"].velocity = (-0.3, 0.0)
    assert simulation.run_until(lambda: fred(simulation).x_m < 0.8, timeout_s=5)
    puppets["fred"].velocity = (0.0, 0.0)
    run_s(simulation, 0.5)
    # ginger stands south of the rock and drives north until its own barrier meets it
    puppets["ginger"].velocity = (0.1, 0.0)
    assert simulation.run_until(lambda: taker.sense().gripper.between_jaws == "rock", timeout_s=6)
    puppets["ginger"].velocity = (0.0, 0.0)
    taker.set_gripper(closed=True)
    run_s(simulation, 0.2)
    assert simulation.truth().samples["rock"].holders == ("fred", "ginger")
    giver.set_gripper(closed=False)
    run_s(simulation, 0.2)
    assert simulation.truth().samples["rock"].holders == ("ginger",)
    assert giver.sense().gripper.holding is None
    assert taker.sense().gripper.holding == "rock"


def test_a_sample_slips_from_the_second_holder_when_the_first_drives_away() -> None:
    world = two_rooms(BEFORE_PASS, second=(1.0, 0.4, 90), samples={"rock": "pass"})
    simulation, puppets = simulate(world)
    first, second = simulation.bodies["fred"], simulation.bodies["ginger"]
    puppets["fred"].velocity = (0.2, 0.0)
    assert simulation.run_until(lambda: first.sense().gripper.between_jaws == "rock", timeout_s=5)
    first.set_gripper(closed=True)
    puppets["fred"].velocity = (-0.3, 0.0)
    assert simulation.run_until(lambda: fred(simulation).x_m < 0.8, timeout_s=5)
    puppets["fred"].velocity = (0.0, 0.0)
    run_s(simulation, 0.5)
    puppets["ginger"].velocity = (0.1, 0.0)
    assert simulation.run_until(lambda: second.sense().gripper.between_jaws == "rock", timeout_s=6)
    puppets["ginger"].velocity = (0.0, 0.0)
    second.set_gripper(closed=True)
    puppets["fred"].velocity = (-0.3, 0.0)
    run_s(simulation, 1.5)
    assert simulation.truth().samples["rock"].holders == ("fred",)


def test_jaws_do_not_carry_a_sample_through_a_wall() -> None:
    simulation, puppets = grip_rock()
    puppets["fred"].velocity = (-0.3, 0.0)
    run_s(simulation, 1)
    puppets["fred"].velocity = (0.0, 1.0)
    run_s(simulation, 0.9)
    puppets["fred"].velocity = (0.3, 0.0)
    run_s(simulation, 5)
    rock = simulation.truth().samples["rock"]
    assert rock.holders == ("fred",)
    assert 0 < rock.x_m < 1.96
    assert 0 < rock.y_m < 1.96


def beam_in_the_west() -> WorldFile:
    """A long object across fred's way, so that its left handle is straight ahead of him."""
    world = two_rooms((0.3, 0.95, 0), second=(0.3, 0.25, 0), kind="door")
    beam = {"name": "beam", "at": "table", "length_m": 0.7}
    table = {"name": "table", "kind": "place", "at": (1.0, 0.6), "approach_deg": (180,)}
    kept = world.model_dump()
    return WorldFile.model_validate({**kept, "samples": [beam], "locations": [*kept["locations"], table]})


def grip_beam() -> tuple[Simulation, dict[str, Puppet]]:
    """Both grip a handle of the beam."""
    simulation, puppets = simulate(beam_in_the_west())
    for name in ("fred", "ginger"):
        body = simulation.bodies[name]
        puppets[name].velocity = (0.05, 0.0)
        assert simulation.run_until(lambda b=body: b.sense().gripper.between_jaws == "beam", timeout_s=15)
        puppets[name].velocity = (0.0, 0.0)
        body.set_gripper(closed=True)
    run_s(simulation, 1)
    return simulation, puppets


def test_two_rovers_grip_a_long_object_at_its_handles_and_carry_it_between_them() -> None:
    simulation, puppets = grip_beam()
    before = simulation.truth().samples["beam"]
    assert before.holders == ("fred", "ginger")
    for puppet in puppets.values():
        puppet.velocity = (-0.1, 0.0)
    run_s(simulation, 2)
    after = simulation.truth().samples["beam"]
    assert after.x_m == pytest.approx(before.x_m - 0.2, abs=0.03)
    assert simulation.truth().slipped == 0


def test_a_head_feels_that_its_rover_is_behind_the_other() -> None:
    simulation, puppets = grip_beam()
    puppets["fred"].velocity = (-0.1, 0.0)
    run_s(simulation, 1)
    assert simulation.bodies["fred"].sense().capture_head_m[0] > 0.01
    assert simulation.bodies["ginger"].sense().capture_head_m[0] < -0.01


def test_a_rover_that_drives_is_pulled_along_by_the_other_over_the_object_that_they_hold() -> None:
    """Either robot's motion is transmitted to the other (MACTA §5)."""
    driven_to_m = []
    for other_m_s in (-0.02, -0.05):
        simulation, puppets = grip_beam()
        puppets["ginger"].velocity = (-0.02, 0.0)
        puppets["fred"].velocity = (other_m_s, 0.0)
        run_s(simulation, 1.5)
        assert simulation.truth().slipped == 0
        driven_to_m.append(simulation.truth().robots["ginger"].x_m)
    beside_each_other_m, behind_m = driven_to_m
    assert behind_m < beside_each_other_m - 0.004


def test_the_brakes_of_a_rover_that_stands_hold_it_against_the_other() -> None:
    simulation, puppets = grip_beam()
    stood_m = simulation.truth().robots["ginger"].x_m
    puppets["fred"].velocity = (-0.05, 0.0)
    run_s(simulation, 1)
    assert simulation.truth().robots["ginger"].x_m == pytest.approx(stood_m, abs=1e-3)


def test_a_handle_slips_out_of_a_rover_that_drives_off_alone() -> None:
    simulation, puppets = grip_beam()
    puppets["fred"].velocity = (-0.4, 1.5)
    run_s(simulation, 3)
    truth = simulation.truth()
    assert truth.slipped >= 1
    assert len(truth.samples["beam"].holders) <= 1


def test_a_long_object_that_is_pushed_against_a_wall_does_not_pass_it() -> None:
    simulation, puppets = grip_beam()
    for puppet in puppets.values():
        puppet.velocity = (0.3, 0.0)
    run_s(simulation, 4)
    truth = simulation.truth()
    assert 1.85 < truth.samples["beam"].x_m < 1.96


def test_a_long_object_that_nobody_holds_lies_where_it_was_released() -> None:
    simulation, _ = grip_beam()
    for name in ("fred", "ginger"):
        simulation.bodies[name].set_gripper(closed=False)
    run_s(simulation, 0.5)
    beam = simulation.truth().samples["beam"]
    assert (beam.holders, beam.place) == ((), "table")
    assert abs(beam.heading_rad) == pytest.approx(pi / 2, abs=0.1)
