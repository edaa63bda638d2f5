"""A sensor that fails: the robot goes on without it, rides it out, or gives up in time and names it."""

import itertools
from dataclasses import replace
from math import nan

import numpy as np

from robots.deliberative.mind import Mind
from robots.deliberative.reader import rules_of
from robots.executive.agent import FAULT_S
from robots.physical.body import Pose, Readings
from robots.physical.profile import RobotProfile
from robots.repertoire import load_repertoire
from robots.wire import FailureCategory, ScriptState
from tests.robots.fake_world import STEP_S, FakeWorld
from tests.robots.stories import EAST, Service, packet, room, run, run_for, script


def fred(world: FakeWorld) -> Service:
    return Service(world, world.add("fred", Pose(x_m=4.0, y_m=1.5, heading_rad=EAST)), "fred")


def test_a_sensor_that_lies_for_long_fails_the_script_by_name_and_stops_the_robot() -> None:
    world = room()
    service = fred(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door")))
    run_for(world, [service], 1)
    body = world.bodies["fred"]
    good = body.sense()
    body.faulty = replace(good, ranges_m=np.full(16, nan))
    run_for(world, [service], 0.2)
    assert body.velocity == (0, 0)
    assert service.telemetry[-1].degraded == ("16 of 16 whiskers lie: whisker 0 reads nan",)
    run_for(world, [service], FAULT_S + 1)
    assert service.report is not None
    assert (service.report.state, service.report.category) == (ScriptState.FAILED, FailureCategory.ROBOT)
    assert "16 of 16 whiskers lie: whisker 0 reads nan" in service.report.detail


def test_a_robot_goes_on_without_a_whisker_that_lies_and_tells_so() -> None:
    world = room()
    service = fred(world)
    body = world.bodies["fred"]
    honest = body.sense
    body.sense = lambda: one_whisker_nan(honest())  # type: ignore[method-assign]
    service.order(script("fred", packet("NAVIGATE", ref2="door")))
    assert run(world, [service], lambda: service.report is not None)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED
    assert service.telemetry[-5].degraded == ("whisker 5 reads nan",)


def one_whisker_nan(readings: Readings) -> Readings:
    if readings.ranges_m is None:
        return readings
    ranges_m = np.array(readings.ranges_m)
    ranges_m[5] = nan
    return replace(readings, ranges_m=ranges_m)


def test_a_sensor_that_fails_every_other_tick_is_given_up_too() -> None:
    world = room()
    service = fred(world)
    body = world.bodies["fred"]
    honest, ticks = body.sense, itertools.count()
    body.sense = lambda: replace(honest(), ranges_m=None) if next(ticks) % 3 else honest()  # type: ignore[method-assign]
    service.order(script("fred", packet("NAVIGATE", ref2="door")))
    assert run(world, [service], lambda: service.report is not None, limit_s=4 * FAULT_S)
    assert service.report is not None
    assert "ultrasonic reads nothing" in service.report.detail


def test_a_glitch_of_a_sensor_is_ridden_out() -> None:
    world = room()
    service = fred(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door")))
    run_for(world, [service], 1)
    body = world.bodies["fred"]
    body.faulty = replace(body.sense(), battery=nan)
    run_for(world, [service], 0.5)
    body.faulty = None
    assert run(world, [service], lambda: service.report is not None)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED


def test_telemetry_tells_of_a_touch_since_the_last_one_and_nothing_while_the_bumper_is_off() -> None:
    world = room(noise=0.0)
    rules = "AGENT guard;\nPERCEPTOR hit IS bumped();\nBELIEF(hit) => COMMIT(adoptBelief(met));"

    def mind(profile: RobotProfile) -> Mind:
        return Mind(profile, load_repertoire(), [rules_of(rules, "guard.rules")])

    felt = Service(world, world.add("fred", Pose(x_m=1.0, y_m=1.5, heading_rad=EAST), mind=mind), "fred")
    blind = Service(world, world.add("ginger", Pose(x_m=5.0, y_m=1.5, heading_rad=EAST)), "ginger")
    run_for(world, [felt, blind], 1.0)
    body = world.bodies["fred"]
    body.bumped = True
    run_for(world, [felt, blind], STEP_S)
    body.bumped = False
    run_for(world, [felt, blind], 1.0)
    touches = [one.touched for one in felt.telemetry]
    assert touches.count(True) == 1
    assert touches[-1] is False
    assert {one.touched for one in blind.telemetry} == {None}
