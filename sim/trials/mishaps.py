"""What may befall a world, done to it from outside: rovers pushed, lifted or switched off, samples knocked, beacons
hidden, sensors and jaws that fail.

For benchmarks, tests and soaks only. A robot is not told; it must sense what has become of it.
"""

from cmath import phase, rect
from collections.abc import Callable
from dataclasses import replace
from math import cos, hypot, nan, sin
from typing import Any

import numpy as np

from robots.body import RADIUS_M, READS, Body, Pose, Readings, Sensor
from robots.geometry import wrap
from robots.sightings import NONE_IN_VIEW, Sightings
from robots.world.walls import clearance_m, panels_of
from sim.world.agents import behavioural_agent
from sim.world.simulation import Agent, Fitting, Simulation

Fault = Callable[[Readings], Readings]
"""What a failing sensor makes of what it would read."""
WheelFault = Callable[[Pose], Pose]

ROOM_M = RADIUS_M + 0.02
"""A rover is set down no nearer to a wall than this."""


def dead(sensor: Sensor) -> Fault:
    """It reads nothing at all."""
    nothing: dict[str, Any] = {READS[sensor]: None}
    return lambda readings: replace(readings, **nothing)


def frozen(sensor: Sensor) -> Fault:
    """It goes on telling what it read first, to the last bit."""
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
    """Infra-red tells names, but neither range nor bearing."""
    if readings.sightings is None:
        return readings
    read = readings.sightings.read * (nan, nan, 1.0)
    return replace(readings, sightings=Sightings(readings.sightings.names, read))


def head_reads_nan(readings: Readings) -> Readings:
    """The capture head tells no deflection."""
    return readings if readings.capture_head_m is None else replace(readings, capture_head_m=(nan, nan))


def sees_nothing(readings: Readings) -> Readings:
    """Infra-red runs and meets no beacon: a covered receiver."""
    return readings if readings.sightings is None else replace(readings, sightings=NONE_IN_VIEW)


class FaultyBody:
    """A body whose sensors may fail; else the body it is put around."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self.faults: dict[str, Fault] = {}
        self.wheel_fault: WheelFault | None = None
        self.jaws_fail = False
        self._turned, self._shifted = 1 + 0j, 0j

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
        """Its wheels have not felt a move that the body it is put around has counted, from one pose to another."""
        turned = self._turned * rect(1.0, before.heading_rad - after.heading_rad)
        at = self._shifted + self._turned * complex(before.x_m, before.y_m)
        self._shifted = at - turned * complex(after.x_m, after.y_m)
        self._turned = turned

    def run_sensors(self, sensors: frozenset[Sensor]) -> None:
        self._body.run_sensors(sensors)

    def sense(self) -> Readings:
        readings = self._body.sense()
        for fault in self.faults.values():
            readings = fault(readings)
        return readings


class Switched:
    """An agent that can be switched off: it stands still, hears nothing and says nothing. On again, it goes on."""

    def __init__(self, agent: Agent, fitting: Fitting) -> None:
        self._agent, self._body, self._link = agent, fitting.body, fitting.link
        self.on = True

    def tick(self) -> None:
        if self.on:
            self._agent.tick()
            return
        self._body.set_velocity(0.0, 0.0)
        self._link.receive()  # nobody is there to hear it


class Mishaps:
    """The hand from outside. `fit` makes a simulation's agents, so that their sensors can be made to fail."""

    def __init__(self) -> None:
        self.bodies: dict[str, FaultyBody] = {}
        self._switches: dict[str, Switched] = {}

    def fit(self, fitting: Fitting) -> Agent:
        body = FaultyBody(fitting.body)
        switched = Switched(behavioural_agent(replace(fitting, body=body)), fitting)
        self.bodies[fitting.spec.name], self._switches[fitting.spec.name] = body, switched
        return switched

    def switch(self, rover: str, *, on: bool) -> None:
        self._switches[rover].on = on

    def break_sensor(self, rover: str, fault: Fault, name: str = "sensor") -> None:
        """From now on, until `mend`, a sensor fails."""
        self.bodies[rover].faults[name] = fault

    def mend(self, rover: str, name: str = "sensor") -> None:
        self.bodies[rover].faults.pop(name, None)

    def lift(self, simulation: Simulation, rover: str, pose: Pose) -> None:
        """Take a rover up and set it down elsewhere, or turned: its wheels feel nothing.

        :raises ValueError: if there is no room for it.
        """
        body = simulation.bodies[rover]
        body.count_way(simulation.scene.pose(rover))
        before = body.get_position()
        _set_down(simulation, rover, pose)
        body.count_way(pose)
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


def push(simulation: Simulation, rover: str, *, ahead_m: float = 0.0, left_m: float = 0.0) -> None:
    """Push a rover over the floor: its wheels feel the part along its heading, not the part across.

    :raises ValueError: if there is no room for it.
    """
    pose = simulation.scene.pose(rover)
    ahead, left = cos(pose.heading_rad), sin(pose.heading_rad)
    x_m = pose.x_m + ahead_m * ahead - left_m * left
    y_m = pose.y_m + ahead_m * left + left_m * ahead
    _set_down(simulation, rover, replace(pose, x_m=x_m, y_m=y_m))


def has_room(simulation: Simulation, rover: str, pose: Pose) -> bool:
    """True if a rover can stand there without touching a wall or another rover."""
    others = [simulation.scene.pose(name) for name in simulation.bodies if name != rover]
    free = all(hypot(pose.x_m - other.x_m, pose.y_m - other.y_m) > 2 * ROOM_M for other in others)
    return free and clearance_m((pose.x_m, pose.y_m), panels_of(simulation.world.walls)) >= ROOM_M


def knock(simulation: Simulation, sample: str, point: tuple[float, float]) -> None:
    """Knock a sample that stands on the floor to a point of the world's frame."""
    simulation.scene.set_down(sample, point)


def _set_down(simulation: Simulation, rover: str, pose: Pose) -> None:
    if not has_room(simulation, rover, pose):
        raise ValueError(f"no room for {rover} at ({pose.x_m:.2f}, {pose.y_m:.2f})")
    simulation.scene.put_rover(rover, pose)
