"""Sensor actions run as long as they are asked for; their data stores end with them (P-SMPA, algorithm 3)."""

import pytest

from robots.errors import SensorFault, SensorOff
from robots.perception.sensing import Mode, SensorAction, SensoryController
from robots.physical.body import ALL_SENSORS, Pose, Sensor
from tests.robots.fake_world import FakeBody
from tests.robots.stories import room

RANGES = SensorAction(sensor=Sensor.ULTRASONIC)
LOOK = SensorAction(sensor=Sensor.INFRA_RED, mode=Mode.ONE_SHOT)


def fitted() -> tuple[FakeBody, SensoryController]:
    body = FakeBody(room(), "fred", Pose(x_m=3, y_m=1.5, heading_rad=0))
    return body, SensoryController(body)


def test_the_body_runs_what_is_asked_for_and_nothing_else() -> None:
    body, sensory = fitted()
    sensory.run([RANGES])
    assert body.running == {Sensor.ULTRASONIC}
    sensory.run([])
    assert body.running == frozenset()


def test_what_was_read_is_joined_and_what_does_not_run_is_not_known() -> None:
    body, sensory = fitted()
    sensory.run([RANGES])
    data = sensory.collect(body.sense())
    assert len(data.get(Sensor.ULTRASONIC)) == 16
    with pytest.raises(SensorOff, match="gripper"):
        data.get(Sensor.GRIPPER)


def test_readings_nobody_asked_for_are_not_known() -> None:
    """A body runs all its sensors when it is switched on."""
    body, sensory = fitted()
    assert body.running == ALL_SENSORS
    assert not sensory.collect(body.sense()).values


def test_a_store_ends_with_its_action() -> None:
    body, sensory = fitted()
    sensory.run(tuple(SensorAction(sensor=sensor) for sensor in ALL_SENSORS))
    sensory.collect(body.sense())
    sensory.run([])
    sensory.run([RANGES])
    with pytest.raises(SensorOff):
        sensory.collect(body.sense()).get(Sensor.INFRA_RED)


def test_a_one_shot_is_switched_off_when_it_has_read_and_its_percept_stays() -> None:
    body, sensory = fitted()
    sensory.run([LOOK])
    assert body.running == {Sensor.INFRA_RED}
    seen = sensory.collect(body.sense()).get(Sensor.INFRA_RED)
    sensory.run([LOOK])
    assert body.running == frozenset()
    assert sensory.collect(body.sense()).get(Sensor.INFRA_RED) == seen


def test_a_sensor_that_runs_and_says_nothing_is_at_fault() -> None:
    body, sensory = fitted()
    sensory.run([RANGES])
    body.running = frozenset()
    with pytest.raises(SensorFault, match="ultrasonic reads nothing"):
        sensory.collect(body.sense())
