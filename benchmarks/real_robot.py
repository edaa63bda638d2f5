"""A robot outside of the simulation: its own program and a kinematic body, in the samples and places of a world.

The body has neither walls nor motors: it moves as it is told, sees beacons within their reach, tags that are near and
other robots, and grips the sample between its jaws. Its program is the one that a robot with rules and speech runs.
"""

from cmath import phase, rect
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf, radians

import numpy as np

from robots.clock import Clock
from robots.contract.memory_file import TextMemory
from robots.executive.agent import BehaviouralAgent
from robots.executive.memory import RobotMemory
from robots.executive.robot_program import RobotProgram
from robots.link import InMemoryLink, Link
from robots.physical.body import GRIPPER_REACH_M, Gripper, Pose, Readings
from robots.physical.sightings import Sighting, Sightings
from robots.wire import Message, Program
from robots.world import Location, WorldFile
from sim.world.agent import AgentSetup
from sim.world.agents import behavioural_agent

TAG_RANGE_M = 3.0
BETWEEN_M = 0.07
STEP_S = 0.05


class KinematicBody:
    """Implements `robots.physical.body.Body`. The world's state is given to it before each tick."""

    def __init__(self, start: Pose, reach: Sequence[Location], clock: Clock) -> None:
        self._reach = reach
        self._clock = clock
        self.at = complex(start.x_m, start.y_m)
        self.heading_rad = start.heading_rad
        self.held: str | None = None
        self.samples: dict[str, complex] = {}
        self.others: dict[str, complex] = {}
        self._closed = False
        self._velocity = (0.0, 0.0)
        self._running = frozenset[str]()

    def step(self) -> None:
        """Move for a control cycle."""
        linear_m_s, angular_rad_s = self._velocity
        self.heading_rad = phase(rect(1.0, self.heading_rad + angular_rad_s * STEP_S))
        self.at += rect(linear_m_s * STEP_S, self.heading_rad)

    def place(self, pose: Pose) -> None:
        """Carry it somewhere."""
        self.at = complex(pose.x_m, pose.y_m)
        self.heading_rad = pose.heading_rad

    def stop(self) -> None:
        """What its motors do when nobody commands them."""
        self._velocity = (0.0, 0.0)

    @property
    def jaws(self) -> complex:
        return self.at + rect(GRIPPER_REACH_M, self.heading_rad)

    def set_velocity(self, linear_m_s: float, angular_rad_s: float) -> None:
        self._velocity = (linear_m_s, angular_rad_s)

    def set_gripper(self, *, closed: bool) -> None:
        if closed is not self._closed:
            self._closed = closed
            self.held = self._between if closed else None

    def get_position(self) -> Pose:
        return Pose(x_m=self.at.real, y_m=self.at.imag, heading_rad=self.heading_rad)

    def run_sensors(self, sensors: frozenset[str]) -> None:
        self._running = sensors

    def sense(self) -> Readings:
        runs = self._running.__contains__
        return Readings(
            time_s=self._clock.now_s(),
            ranges_m=np.full(16, inf) if runs("ultrasonic") else None,
            bumper=False if runs("bumper") else None,
            sightings=Sightings.of(self._in_view()) if runs("infra_red") else None,
            gripper=Gripper(closed=self._closed, between_jaws=self._between) if runs("gripper") else None,
            capture_head_m=(0.0, 0.0) if runs("capture_head") else None,
        )

    @property
    def _between(self) -> str | None:
        if self.held is not None:
            return self.held
        near = (name for name, at in self.samples.items() if abs(at - self.jaws) < BETWEEN_M)
        return next(near, None)

    def _in_view(self) -> list[Sighting]:
        seen = [
            self._sighting(place.name, complex(*place.at), [radians(axis) for axis in place.approach_deg])
            for place in self._reach
        ]
        seen += [
            self._sighting(name, at)
            for name, at in self.samples.items()
            if name != self.held and abs(at - self.at) < TAG_RANGE_M
        ]
        return seen + [self._sighting(name, at) for name, at in self.others.items()]

    def _sighting(self, name: str, at: complex, axes_rad: list[float] | None = None) -> Sighting:
        ray = (at - self.at) * rect(1.0, -self.heading_rad)
        aspects = [phase((self.at - at) * rect(1.0, -axis)) for axis in axes_rad or ()]
        return Sighting(
            identity=name,
            range_m=abs(ray),
            bearing_rad=phase(ray),
            aspect_rad=min(aspects, key=abs, default=0.0),
        )


class RealRobot:
    """A body, and its program, which may be killed and started again. It begins without a mind."""

    def __init__(self, world: WorldFile, name: str, clock: Clock) -> None:
        spec = world.robot(name)
        x_m, y_m, heading_deg = spec.start
        told = Pose(x_m=x_m, y_m=y_m, heading_rad=radians(heading_deg))
        self.body = KinematicBody(told, world.reach_of(spec), clock)
        self._service, link = InMemoryLink.pair()
        self._setup = AgentSetup(
            spec=spec,
            reach=world.reach_of(spec),
            others=tuple(one.name for one in world.robots if one.name != name),
            samples=frozenset(one.name for one in world.samples),
            zones=world.zones,
            lengths_m=world.lengths_m,
            told=told,
            round_trip_s=world.link_of(spec).round_trip_s,
            body=self.body,
            link=link,
            clock=clock,
            speaks=world.has_social_level(spec),
            peer_round_trip_s=0.0 if world.peer_link is None else world.peer_link.round_trip_s,
            program=Program.OWN,
        )
        self.name = name
        self._clock = clock
        self.disk = TextMemory()
        self.kill()

    def kill(self) -> None:
        """End the program at once and start it again: what is on its disk is all that is left."""
        self._service, link = InMemoryLink.pair()
        self.body.stop()
        self.program = RobotProgram(
            self.name, make=self._make, link=link, clock=self._clock, store=self.disk, stands_by=True
        )

    def deliver(self, message: Message) -> None:
        self._service.send(message)

    def tick(self, samples: Mapping[str, complex], others: Mapping[str, complex]) -> list[Message]:
        """One control cycle; what the program says."""
        held = self.body.held
        self.body.samples = {**samples, **({held: self.body.jaws} if held else {})}
        self.body.others = dict(others)
        self.body.step()
        self.program.tick()
        return list(self._service.receive())

    def _make(self, link: Link, memory: RobotMemory | None) -> BehaviouralAgent:
        return behavioural_agent(replace(self._setup, link=link, memory=memory))
