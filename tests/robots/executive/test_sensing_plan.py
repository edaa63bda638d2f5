"""A script becomes a plan, and the plan a machine whose states run just the sensors they need (P-SMPA, algorithm 2)."""

import pytest

from robots.errors import RepertoireError
from robots.executive.actions import CYCLIC_ACTIONS, ActuatorAction, Mode, SensorAction, TaskPlan, superseded
from robots.executive.plans import task_plan
from robots.executive.sensing_plan import StateMachine, schedule
from robots.physical.body import ALL_SENSORS, Sensor
from robots.repertoire import load_repertoire
from robots.wire import BehaviourPacket
from tests.robots.sensed import PROFILE
from tests.robots.stories import fact, packet, script

REPERTOIRE = load_repertoire()
GO = packet("NAVIGATE", ref2="bay")
DOCK = packet("DOCK", object="sample", ref1="bay")
CARRY = packet("TRANSPORT", object="sample", ref1="bay", ref2="bay")
SIGHT_AND_GRIP = {Sensor.INFRA_RED, Sensor.GRIPPER}


def machine(*packets: BehaviourPacket) -> StateMachine:
    contents = [REPERTOIRE.bind(one, PROFILE) for one in packets]
    return schedule(task_plan(script("me", *packets), contents), CYCLIC_ACTIONS)


def beside(one: BehaviourPacket, phase: str) -> set[Sensor]:
    return {sensor.sensor for sensor in machine(one).states[f"{one.id}/{phase}"].beside}


def action(name: str, *percepts: Sensor) -> ActuatorAction:
    return ActuatorAction(name=name, percepts=frozenset(percepts))


def test_a_sensor_action_runs_beside_the_actions_that_need_its_percept_and_no_others() -> None:
    plan = TaskPlan(invocation="go", context=(), body=(action("rest"), action("go", Sensor.ULTRASONIC)))
    states = schedule(plan, CYCLIC_ACTIONS).states
    assert states["rest"].beside == ()
    assert states["go"].beside == (SensorAction(sensor=Sensor.ULTRASONIC),)


def test_states_follow_each_other_in_the_bodys_order_and_recoveries_go_there_and_back() -> None:
    plan = TaskPlan(
        invocation="go", context=(), body=(action("a"), action("b")), recoveries={"b": action("shake")}
    )
    assert schedule(plan, ()).transitions == {("a", "b"), ("b", "shake"), ("shake", "b")}


def test_only_sensor_actions_that_are_offered_are_scheduled() -> None:
    look = SensorAction(sensor=Sensor.INFRA_RED, mode=Mode.ONE_SHOT)
    plan = TaskPlan(invocation="go", context=(), body=(action("a", Sensor.INFRA_RED, Sensor.BUMPER),))
    assert schedule(plan, [look]).states["a"].beside == (look,)


def test_whiskers_are_off_while_navigate_waits_and_on_while_it_drives() -> None:
    assert beside(GO, "wait") == SIGHT_AND_GRIP
    assert beside(GO, "act") == {*SIGHT_AND_GRIP, Sensor.ULTRASONIC}


def test_docking_does_without_whiskers_until_it_must_back_off() -> None:
    assert beside(DOCK, "act") == SIGHT_AND_GRIP
    assert beside(DOCK, "retry") == {*SIGHT_AND_GRIP, Sensor.ULTRASONIC}


def test_the_capture_head_is_read_while_something_is_carried() -> None:
    assert Sensor.CAPTURE_HEAD in beside(CARRY, "act")
    assert Sensor.CAPTURE_HEAD not in beside(GO, "act")


def test_no_packet_of_the_repertoire_runs_every_sensor() -> None:
    for spec in REPERTOIRE.specs.values():
        content = spec.bind({})
        plan = task_plan(script("me", packet(spec.tag)), [content])
        assert all(one.percepts < ALL_SENSORS for one in plan.body), spec.tag


def test_two_packets_of_one_id_are_refused() -> None:
    with pytest.raises(RepertoireError, match="one id"):
        machine(GO, GO)


def test_an_action_changes_the_state_by_what_it_adds_and_deletes() -> None:
    requires = [fact("in(sample, door)"), fact("near(me, door)")]
    achieves = [fact("in(sample, me)")]
    deleted = superseded(requires, achieves)
    assert deleted == {fact("in(sample, door)")}
    dock = ActuatorAction(name="dock", percepts=frozenset(), add=frozenset(achieves), delete=deleted)
    assert dock.apply(frozenset(requires)) == {fact("near(me, door)"), fact("in(sample, me)")}


def test_a_fact_that_stays_true_is_not_deleted() -> None:
    kept = fact("in(sample, door)")
    assert superseded([kept], [kept]) == frozenset()
