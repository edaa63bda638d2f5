"""Simulated doors, hatches and lifts: their panels, what is in their way, and snapshots."""

import pytest

from robots.adapters.peripheral import CLOSED, OPEN
from robots.physical.body import Pose
from robots.world import load_world
from sim.world.agents import behavioural_agent
from sim.world.mechanisms import Fault
from sim.world.simulation import Simulation

WORLD = load_world("guarded_store")
BEFORE_GATE = Pose(x_m=4.9, y_m=6.3, heading_rad=0.0)


def simulated() -> Simulation:
    return Simulation(WORLD, make_agent=behavioural_agent, jitter_m=0.0)


def run_s(simulation: Simulation, seconds: float) -> None:
    for _ in range(round(20 * seconds)):
        simulation.step_control_cycle()


def driven_m(simulation: Simulation, seconds: float) -> float:
    """How far to the east a robot gets that is pushed from before the gate."""
    simulation.scene.put_rover("store_1", BEFORE_GATE)
    for _ in range(round(60 * seconds)):
        simulation.scene.drive("store_1", 0.5, 0.0)
        simulation.scene.step()
    return simulation.scene.pose("store_1").x_m - BEFORE_GATE.x_m


def test_a_closed_door_stops_a_robot_and_an_open_one_does_not() -> None:
    simulation = simulated()
    gate = simulation.peripherals.mechanisms["gate_1"]
    assert gate.state == CLOSED
    assert driven_m(simulation, 3.0) < 0.5
    gate.go_to(OPEN)
    for _ in range(20 * 5):
        gate.move(0.05)
    assert gate.state == OPEN
    assert driven_m(simulation, 3.0) > 1.2
    simulation.close()


def test_a_door_opens_in_its_time_and_closes_by_itself() -> None:
    simulation = simulated()
    gate = simulation.peripherals.mechanisms["gate_1"]
    gate.go_to(OPEN)
    run_s(simulation, 3.8)
    assert gate.state == ""
    run_s(simulation, 0.4)
    assert gate.state == OPEN
    run_s(simulation, 10.0)
    assert gate.state == CLOSED
    simulation.close()


def test_a_door_does_not_sink_on_a_robot() -> None:
    simulation = simulated()
    gate = simulation.peripherals.mechanisms["gate_1"]
    gate.go_to(OPEN)
    run_s(simulation, 4.2)
    simulation.scene.put_rover("store_1", Pose(x_m=5.5, y_m=6.3, heading_rad=0.0))
    gate.go_to(CLOSED)
    run_s(simulation, 10.0)
    assert gate.state != CLOSED
    assert gate.fault == "store_1 is in its way"
    simulation.scene.put_rover("store_1", BEFORE_GATE)
    run_s(simulation, 6.0)
    assert gate.state == CLOSED
    simulation.close()


def test_of_a_lift_one_door_is_open_at_a_time() -> None:
    simulation = simulated()
    lift = simulation.peripherals.mechanisms["lift_1"]
    assert lift.state == "ground"
    lift.go_to("upper")
    run_s(simulation, 10.9)
    assert lift.state == ""
    run_s(simulation, 3.4)
    assert lift.state == "upper"
    simulation.close()


@pytest.mark.parametrize(
    ("fault", "state", "words"),
    [(Fault.JAMMED, CLOSED, "its motor does not move"), (Fault.STICKS, "", "it is stuck half-way")],
)
def test_a_broken_door_says_what_is_wrong(fault: Fault, state: str, words: str) -> None:
    simulation = simulated()
    gate = simulation.peripherals.mechanisms["gate_1"]
    gate.broken = fault
    gate.go_to(OPEN)
    run_s(simulation, 9.8)
    assert (gate.state, gate.fault) == (state, words)
    simulation.close()


def test_a_door_goes_on_opening_from_a_snapshot() -> None:
    simulation = simulated()
    simulation.peripherals.mechanisms["gate_1"].go_to(OPEN)
    run_s(simulation, 2.0)
    resumed = Simulation(WORLD, make_agent=behavioural_agent, snapshot=simulation.snapshot())
    assert resumed.snapshot().peripherals == simulation.snapshot().peripherals
    run_s(resumed, 2.2)
    assert resumed.peripherals.mechanisms["gate_1"].state == OPEN
    simulation.close()
    resumed.close()


def test_a_door_that_shuts_spares_the_robot_under_it_and_says_that_it_does_not_stay_open() -> None:
    simulation = simulated()
    gate = simulation.peripherals.mechanisms["gate_1"]
    gate.go_to(OPEN)
    run_s(simulation, 4.2)
    simulation.scene.put_rover("store_1", Pose(x_m=5.5, y_m=6.3, heading_rad=0.0))
    gate.broken = Fault.SHUTS
    for _ in range(20 * 8):
        gate.move(0.05)
    assert (gate.state, gate.fault) == (OPEN, "")
    simulation.scene.put_rover("store_1", BEFORE_GATE)
    for _ in range(20 * 8):
        gate.move(0.05)
    assert (gate.state, gate.fault) == (CLOSED, "it does not stay open")
    gate.broken = Fault.NONE
    for _ in range(20 * 5):
        gate.move(0.05)
    assert (gate.state, gate.fault) == (OPEN, "")
    simulation.close()
