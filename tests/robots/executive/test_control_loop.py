"""Sensors run while they are needed; sequential SMPA senses and acts in turn, and does the same job."""

from cmath import rect
from collections.abc import Iterator
from dataclasses import replace
from math import pi

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.executive.control_loop import moved_by_odometry
from robots.perception.fusion import Perception
from robots.perception.percepts import Percepts
from robots.perception.sensing import MutualDataStore
from robots.physical.body import Pose, Sensor
from robots.physical.profile import Architecture, RobotProfile
from robots.wire import Control, ControlVerb, Performative, ScriptState, StatusQuery, StatusReport
from tests.robots.fake_world import FakeBody, FakeWorld
from tests.robots.stories import EAST, NORTH, WEST, Service, carry, fact, packet, room, run, run_for, script

ABOUT = {Sensor.INFRA_RED, Sensor.GRIPPER}


def manned(
    pose: Pose, architecture: Architecture = Architecture.PARALLEL, samples: dict[str, complex] | None = None
) -> tuple[FakeWorld, Service]:
    world = room(samples)
    return world, Service(world, world.add("fred", pose, architecture=architecture), "fred")


def sensed_on_the_way(world: FakeWorld, service: Service) -> Iterator[tuple[FakeBody, frozenset[Sensor]]]:
    """The body and what runs, tick by tick until the script has ended."""
    for _ in range(4000):
        if service.report is not None:
            return
        world.tick()
        service.listen()
        yield world.bodies["fred"], world.bodies["fred"].running


START = Pose(x_m=3, y_m=1.2, heading_rad=WEST)
GO = script("fred", packet("NAVIGATE", ref2="yard"))


def test_a_robot_with_nothing_to_do_senses_nothing() -> None:
    world, service = manned(START)
    run_for(world, [service], 1.0)
    assert world.bodies["fred"].running == frozenset()
    last = service.telemetry[-1]
    assert (last.sensors, last.sensing_j) == ((), 0.0)
    assert last.sensing_saved_j > 0


def test_sensors_run_with_the_script_and_end_with_it() -> None:
    world, service = manned(START)
    service.order(GO)
    ran = [running for _, running in sensed_on_the_way(world, service)]
    assert {*ABOUT, Sensor.ULTRASONIC} in ran
    assert all(Sensor.BUMPER not in running and Sensor.CAPTURE_HEAD not in running for running in ran)
    world.tick()
    assert world.bodies["fred"].running == frozenset()


def test_a_robot_that_waits_does_without_whiskers() -> None:
    world, service = manned(START)
    service.order(script("fred", packet("NAVIGATE", ref2="yard", after=["another"])))
    run_for(world, [service], 2.0)
    assert world.bodies["fred"].running == ABOUT


def test_a_paused_robot_senses_nothing_and_goes_on_when_resumed() -> None:
    world, service = manned(START)
    service.order(GO)
    run_for(world, [service], 2.0)
    service.send(Control(script_id=GO.id, verb=ControlVerb.PAUSE))
    run_for(world, [service], 0.5)
    assert world.bodies["fred"].running == frozenset()
    service.send(Control(script_id=GO.id, verb=ControlVerb.RESUME))
    assert run(world, [service], lambda: service.report is not None, limit_s=60)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED


def test_a_robot_that_senses_nothing_looks_round_before_it_says_what_it_perceives() -> None:
    world, service = manned(Pose(x_m=1, y_m=1.2, heading_rad=-NORTH), samples={"sample": 1 + 0.4j})
    run_for(world, [service], 1.0)
    service.send(StatusQuery(script_id="none"), Performative.QUERY)
    run_for(world, [service], 0.2)
    answer = next(m.body for m in service.heard if isinstance(m.body, StatusReport))
    assert fact("in(sample, door)") in answer.perceived
    assert fact("near(fred, door)") in answer.perceived
    assert world.bodies["fred"].running == frozenset()


def test_a_sensor_that_dies_on_the_way_is_named_when_the_script_is_given_up() -> None:
    world, service = manned(START)
    body = world.bodies["fred"]
    alive = body.sense
    service.order(GO)
    run_for(world, [service], 2.0)
    body.sense = lambda: replace(alive(), ranges_m=None)  # type: ignore[method-assign]
    assert run(world, [service], lambda: service.report is not None, limit_s=5)
    assert service.report is not None
    assert service.report.state is ScriptState.FAILED
    assert "ultrasonic reads nothing" in service.report.detail


def test_a_robot_without_a_sensor_that_a_script_needs_refuses_it() -> None:
    world = room()
    service = Service(world, world.add("fred", START, sensors=frozenset(ABOUT)), "fred")
    service.order(GO)
    run_for(world, [service], 0.2)
    assert any("fred has no ultrasonic" in getattr(m.body, "reason", "") for m in service.heard)


def test_a_sequential_robot_stands_while_it_senses_and_is_blind_while_it_moves() -> None:
    world, service = manned(START, Architecture.SEQUENTIAL)
    service.order(GO)
    moved, sensed = 0, 0
    for body, running in sensed_on_the_way(world, service):
        assert not running or body.velocity == (0.0, 0.0)
        moved += body.velocity != (0.0, 0.0)
        sensed += bool(running)
    assert moved > sensed > 0
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED


@pytest.mark.parametrize("architecture", Architecture)
def test_a_sample_is_fetched_carried_and_deposited_under_either_architecture(
    architecture: Architecture,
) -> None:
    world, service = manned(
        Pose(x_m=4, y_m=1.5, heading_rad=EAST), architecture, samples={"sample": 1 + 0.4j}
    )
    service.order(carry("fred", "sample", "door", "yard"))
    assert run(world, [service], lambda: service.report is not None, limit_s=200)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED, service.report.detail
    assert abs(world.samples["sample"] - (5.4 + 1.2j)) < 0.1


poses = st.builds(
    Pose, x_m=st.floats(0.6, 5.4), y_m=st.floats(0.6, 2.4), heading_rad=st.floats(-pi + 0.01, pi - 0.01)
)


def seen_from(pose: Pose) -> Percepts:
    """Without noise, by a robot that knows where it is."""
    world = room({"sample": 1 + 0.4j}, noise=0.0)
    body = FakeBody(world, "fred", pose)
    perception = Perception(RobotProfile(name="fred", start=pose, beacons=world.beacons))
    return perception.perceive(MutualDataStore(body.sense().by_sensor()), pose, 0.0)


@settings(max_examples=40, deadline=None)  # the first call compiles
@given(poses, poses)
def test_a_model_carried_along_shows_what_fresh_sensing_would_show(before: Pose, after: Pose) -> None:
    model = moved_by_odometry(seen_from(before), seen_from(after))
    for name, fresh in seen_from(after).sightings.items():
        if name in model.sightings:
            kept = model.sightings[name]
            assert kept.range_m == pytest.approx(fresh.range_m, abs=1e-6)
            if fresh.range_m > 0.01:
                assert abs(complex_of(kept.bearing_rad) - complex_of(fresh.bearing_rad)) < 1e-6
    approach = (model.approach_point("yard"), seen_from(after).approach_point("yard"))
    assert approach[0] == pytest.approx(approach[1], abs=1e-6)


def complex_of(angle_rad: float) -> complex:
    return rect(1.0, angle_rad)
