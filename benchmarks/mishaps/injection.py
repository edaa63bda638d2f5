"""Faults injected into a simulated world: rovers lifted or switched off, beacons hidden, sensors and jaws that fail.

A robot is not told; it must sense them.
"""

from cmath import phase, rect
from collections.abc import Callable
from dataclasses import replace
from math import nan
from typing import Any

import numpy as np

from robots.physical.body import READS, Body, Pose, Readings, Sensor
from robots.physical.geometry import wrap
from robots.physical.sightings import NONE_IN_VIEW, Sightings
from sim.trials.mishaps import set_down
from sim.world.agent import Agent, AgentSetup
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation

Fault = Callable[[Readings], Readings]
"""Changes the readings as a failing sensor would."""
WheelFault = Callable[[Pose], Pose]


def dead(sensor: Sensor) -> Fault:
    """It reads nothing."""
    nothing: dict[str, Any] = {READS[sensor]: None}
    return lambda readings: replace(readings, **nothing)


def frozen(sensor: Sensor) -> Fault:
    """It repeats its first reading exactly."""
    kept: dict[str, Any] = {}

    def fault(readings: Readings) -> Readings:
        value = getattr(readings, READS[sensor])
        if value is None:
            return readings
        kept.setdefault(READS[sensor], value)
        return replace(readings, **kept)

    return fault


def beams_read(value_m: float, *beams: int) -> Fault:
    """Some whiskers read a constant; all of them if none is named."""

    def fault(readings: Readings) -> Readings:
        if readings.ranges_m is None:
            return readings
        ranges_m = np.array(readings.ranges_m)
        ranges_m[list(beams) or slice(None)] = value_m
        return replace(readings, ranges_m=ranges_m)

    return fault


def sightings_read_nan(readings: Readings) -> Readings:
    """Infra-red reads names, but neither range nor bearing."""
    if readings.sightings is None:
        return readings
    read = readings.sightings.read * (nan, nan, 1.0)
    return replace(readings, sightings=Sightings(readings.sightings.names, read))


def head_reads_nan(readings: Readings) -> Readings:
    """The capture head reads no deflection."""
    return readings if readings.capture_head_m is None else replace(readings, capture_head_m=(nan, nan))


def sees_nothing(readings: Readings) -> Readings:
    """Infra-red runs and detects no beacon: a covered receiver."""
    return readings if readings.sightings is None else replace(readings, sightings=NONE_IN_VIEW)


class FaultyBody:
    """A body whose sensors may fail; otherwise the body it wraps."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self.faults: dict[str, Fault] = {}
        self.wheel_fault: WheelFault | None = None
        self.jaws_fail = False
        self._turned = 1 + 0j
        self._shifted = 0j

    def set_velocity(self, linear_m_s: float, angular_rad_s: float) -> None:
        self._body.set_velocity(linear_m_s, angular_rad_s)

    def set_gripper(self, *, closed: bool) -> None:
        if not self.jaws_fail:
            self._body.set_gripper(closed=closed)

    def get_position(self) -> Pose:
        counted = self._body.get_position()
        at = self._shifted + self._turned * complex(counted.x_m, counted.y_m)
        pose = Pose(x_m=at.real, y_m=at.imag, heading_rad=wrap(counted.heading_rad + phase(self._turned)))
        return pose if self.wheel_fault is None else self.wheel_fault(pose)

    def forget(self, before: Pose, after: Pose) -> None:
        """Discount a move of the inner body from one pose to another: the wheels did not turn."""
        turned = self._turned * rect(1.0, before.heading_rad - after.heading_rad)
        at = self._shifted + self._turned * complex(before.x_m, before.y_m)
        self._shifted = at - turned * complex(after.x_m, after.y_m)
        self._turned = turned

    def run_sensors(self, sensors: frozenset[str]) -> None:
        self._body.run_sensors(sensors)

    def sense(self) -> Readings:
        readings = self._body.sense()
        for fault in self.faults.values():
            readings = fault(readings)
        return readings


class SwitchableAgent:
    """An agent that can be switched off: it then stands still, and neither receives nor sends."""

    def __init__(self, agent: Agent, setup: AgentSetup) -> None:
        self._agent = agent
        self._body = setup.body
        self._link = setup.link
        self.on = True

    def tick(self) -> None:
        if self.on:
            self._agent.tick()
            return
        self._body.set_velocity(0.0, 0.0)
        self._link.receive()  # discarded


class FaultInjector:
    """Injects faults into one simulation. `make_agent` makes its agents, so that their sensors can be made to fail."""

    def __init__(self) -> None:
        self.bodies: dict[str, FaultyBody] = {}
        self._switches: dict[str, SwitchableAgent] = {}

    def make_agent(self, setup: AgentSetup) -> Agent:
        body = FaultyBody(setup.body)
        switched = SwitchableAgent(behavioural_agent(replace(setup, body=body)), setup)
        self.bodies[setup.spec.name] = body
        self._switches[setup.spec.name] = switched
        return switched

    def switch(self, rover: str, *, on: bool) -> None:
        self._switches[rover].on = on

    def break_sensor(self, rover: str, fault: Fault, name: str = "sensor") -> None:
        """Let a sensor fail until `mend`."""
        self.bodies[rover].faults[name] = fault

    def mend(self, rover: str, name: str = "sensor") -> None:
        self.bodies[rover].faults.pop(name, None)

    def lift(self, simulation: Simulation, rover: str, pose: Pose) -> None:
        """Lift a rover and set it down elsewhere, or turned: its wheels do not turn.

        :raises ValueError: if there is no room for it.
        """
        body = simulation.bodies[rover]
        body.update_odometry(simulation.scene.pose(rover))
        before = body.get_position()
        set_down(simulation, rover, pose)
        body.update_odometry(pose)
        self.bodies[rover].forget(before, body.get_position())

    def hide(self, identity: str) -> None:
        """No rover sees this beacon or tag until it is shown again."""
        for body in self.bodies.values():
            body.faults[f"hidden {identity}"] = lambda readings: _without(readings, identity)

    def show(self, identity: str) -> None:
        for body in self.bodies.values():
            body.faults.pop(f"hidden {identity}", None)


def _without(readings: Readings, identity: str) -> Readings:
    if readings.sightings is None:
        return readings
    return replace(readings, sightings=readings.sightings.only(readings.sightings.rows.keys() - {identity}))
