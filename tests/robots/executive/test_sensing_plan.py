"""A script becomes a plan, and the plan a machine whose states run just the sensors they need (P-SMPA, algorithm 2)."""

import pytest

from robots.errors import RepertoireError
from robots.executive.sensing_plan import BehaviourState, Phase, StateMachine, schedule
from robots.perception.sensing import SensorAction
from robots.physical.body import ALL_SENSORS, Sensor
from robots.repertoire import load_repertoire
from robots.wire import BehaviourPacket
from tests.robots.sensed import PROFILE
from tests.robots.stories import packet, script

REPERTOIRE = load_repertoire()
GO = packet("NAVIGATE", ref2="bay")
DOCK = packet("DOCK", object="sample", ref1="bay")
CARRY = packet("TRANSPORT", object="sample", ref1="bay", ref2="bay")
SIGHT_AND_GRIP = {Sensor.INFRA_RED, Sensor.GRIPPER}


def machine(*packets: BehaviourPacket) -> StateMachine:
    contents = [REPERTOIRE.bind(one, PROFILE) for one in packets]
    return schedule(script("me", *packets), contents)


def beside(one: BehaviourPacket, phase: Phase) -> set[Sensor]:
    return {action.sensor for action in machine(one)[one.id, phase].beside}


def test_a_sensor_action_runs_beside_the_actions_that_need_its_percept_and_no_others() -> None:
    assert BehaviourState(frozenset()).beside == ()
    needs = frozenset({Sensor.ULTRASONIC, Sensor.BUMPER})
    assert BehaviourState(needs).beside == tuple(
        SensorAction(sensor=one) for one in (Sensor.BUMPER, Sensor.ULTRASONIC)
    )


def test_every_packet_has_a_state_for_each_phase() -> None:
    assert machine(GO, DOCK).keys() == {(one.id, phase) for one in (GO, DOCK) for phase in Phase}


def test_whiskers_are_off_while_navigate_waits_and_on_while_it_drives() -> None:
    assert beside(GO, Phase.WAIT) == SIGHT_AND_GRIP
    assert beside(GO, Phase.ACT) == {*SIGHT_AND_GRIP, Sensor.ULTRASONIC}


def test_docking_does_without_whiskers_until_it_must_back_off() -> None:
    assert beside(DOCK, Phase.ACT) == SIGHT_AND_GRIP
    assert beside(DOCK, Phase.RETRY) == {*SIGHT_AND_GRIP, Sensor.ULTRASONIC}


def test_the_capture_head_is_read_while_something_is_carried() -> None:
    assert Sensor.CAPTURE_HEAD in beside(CARRY, Phase.ACT)
    assert Sensor.CAPTURE_HEAD not in beside(GO, Phase.ACT)


def test_no_packet_of_the_repertoire_runs_every_sensor() -> None:
    for spec in REPERTOIRE.specs.values():
        one = packet(spec.tag)
        states = schedule(script("me", one), [spec.bind({})])
        assert states[one.id, Phase.WAIT].needs < ALL_SENSORS, spec.tag
        assert states[one.id, Phase.ACT].needs < ALL_SENSORS, spec.tag


def test_two_packets_of_one_id_are_refused() -> None:
    with pytest.raises(RepertoireError, match="one id"):
        machine(GO, GO)
