"""A small kinematic world in the plane: unicycles, walls as segments, beacons, tagged samples. No physics.

It implements `Body` for on-robot software under test. What it knows of the truth, only tests may ask.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import atan2, cos, hypot, inf, pi, sin
from typing import Any

import numpy as np

from robots.clock import ManualClock
from robots.executive.agent import BehaviouralAgent
from robots.executive.deliberation import Deliberation
from robots.executive.hand_over import MindDocument
from robots.executive.society import Society
from robots.link import InMemoryLink, Link
from robots.physical.body import (
    ALL_SENSORS,
    GRIPPER_REACH_M,
    RADIUS_M,
    Gripper,
    Image,
    Pose,
    Readings,
    Sensor,
)
from robots.physical.geometry import wrap
from robots.physical.profile import BeaconSpec, RobotProfile
from robots.physical.sightings import Sighting, Sightings
from robots.repertoire import Repertoire

STEP_S = 0.05
WHISKERS = 16
WHISKER_RANGE_M = 2.5
SAMPLE_RADIUS_M = 0.06
BARRIER_M = 0.07

Segment = tuple[complex, complex]


@dataclass(slots=True)
class FakeWorld:
    """Rovers and samples on a floor with walls. `noise` scales the sensing errors; 0 is exact."""

    walls: Sequence[Segment]
    beacons: Mapping[str, BeaconSpec]
    samples: dict[str, complex]
    seed: int = 0
    noise: float = 1.0
    clock: ManualClock = field(default_factory=ManualClock)
    bodies: dict[str, "FakeBody"] = field(default_factory=dict)
    agents: dict[str, BehaviouralAgent] = field(default_factory=dict)
    links: dict[str, Link] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)

    rng: np.random.Generator = field(init=False)

    def add(
        self,
        name: str,
        pose: Pose,
        others: Sequence[str] = (),
        link: Link | None = None,
        packets: Repertoire | None = None,
        mind: Callable[[RobotProfile], Deliberation] | None = None,
        society: Society | None = None,
        **told: Any,
    ) -> InMemoryLink:
        """A rover with its agent; returns the service's end of its link.

        :param packets: its repertoire's; None: those that ship. :param mind: makes its deliberative level.
        :param society: its social level. :param told: more of its `RobotProfile`.
        """
        ours, theirs = InMemoryLink.pair()
        self.links[name] = link or theirs
        self.bodies[name] = FakeBody(self, name, pose)
        profile = RobotProfile(name=name, start=pose, beacons=self.beacons, others=tuple(others), **told)
        self.agents[name] = BehaviouralAgent(
            profile=profile,
            body=self.bodies[name],
            link=link or theirs,
            clock=self.clock,
            repertoire=packets,
            deliberation=None if mind is None else mind(profile),
            society=society,
        )
        return ours

    def take_over(self, name: str, document: MindDocument, society: Society | None) -> None:
        """Another program, on the same link and body, takes the rover's mind."""
        agent = BehaviouralAgent(
            profile=self.agents[name].profile,
            body=self.bodies[name],
            link=self.links[name],
            clock=self.clock,
            society=society,
        )
        body = self.agents[name].memory().body
        assert agent.take_over(document.model_copy(update={"fence": 1}), body=body) is None
        self.agents[name] = agent

    def tick(self) -> None:
        for agent in self.agents.values():
            agent.tick()
        for body in self.bodies.values():
            body.move()
        self.clock.advance(STEP_S)

    def blurred(self, value: float, sigma: float) -> float:
        return value + self.noise * sigma * float(self.rng.standard_normal())

    def in_sight(self, one: complex, other: complex) -> bool:
        return all(_ray(one, other - one, wall) >= 1 - 1e-9 for wall in self.walls)


class FakeBody:
    """A unicycle with a gripper. `faulty` replaces what its sensors say."""

    def __init__(self, world: FakeWorld, name: str, pose: Pose) -> None:
        self.world, self.name, self.pose = world, name, pose
        self.odometry = pose
        self.closed = False
        self.held: str | None = None
        self.velocity = (0.0, 0.0)
        self.faulty: Readings | None = None
        self.stuck = False
        self.jammed = False
        self.bumped = False
        self.battery = 1.0
        self.charging = False
        self.running: frozenset[str] = ALL_SENSORS
        self.measured: dict[str, float] = {}
        self.cameras: dict[str, Image] = {}
        self.images_taken = 0

    @property
    def at(self) -> complex:
        return complex(self.pose.x_m, self.pose.y_m)

    @property
    def jaws(self) -> complex:
        return self.at + GRIPPER_REACH_M * complex(cos(self.pose.heading_rad), sin(self.pose.heading_rad))

    def set_velocity(self, linear_m_s: float, angular_rad_s: float) -> None:
        self.velocity = (linear_m_s, angular_rad_s)

    def set_gripper(self, *, closed: bool) -> None:
        if self.jammed:
            return
        if closed and not self.closed:
            self.held = self._between()
        elif not closed:
            self.held = None
        self.closed = closed

    def get_position(self) -> Pose:
        return self.odometry

    def sense(self) -> Readings:
        if self.faulty is not None:
            return self.faulty
        between = self.held if self.closed else self._between()
        beams = [2 * pi * beam / WHISKERS for beam in range(WHISKERS)]
        runs = self.running.__contains__
        images = {name: image for name, image in self.cameras.items() if runs(name)}
        self.images_taken += len(images)
        return Readings(
            time_s=self.world.clock.now_s(),
            ranges_m=np.array([self._range(beam) for beam in beams]) if runs(Sensor.ULTRASONIC) else None,
            bumper=self.bumped if runs(Sensor.BUMPER) else None,
            sightings=Sightings.of(self._sightings()) if runs(Sensor.INFRA_RED) else None,
            gripper=Gripper(closed=self.closed, between_jaws=between) if runs(Sensor.GRIPPER) else None,
            capture_head_m=(0.0, 0.0) if runs(Sensor.CAPTURE_HEAD) else None,
            battery=self.battery,
            charging=self.charging,
            measured=self.measured,
            images=images,
        )

    def run_sensors(self, sensors: frozenset[str]) -> None:
        self.running = sensors

    def move(self) -> None:
        """One step; whoever would touch a wall or another rover stays where he is."""
        linear, angular = self.velocity
        step_m, turn = (0.0, 0.0) if self.stuck else (linear * STEP_S, angular * STEP_S)
        moved = _moved(self.pose, step_m, turn)
        if not self._touches(complex(moved.x_m, moved.y_m)):
            self.pose = moved
        else:
            step_m = 0.0
        self.odometry = _moved(
            self.odometry,
            self.world.blurred(step_m, 0.05 * abs(step_m)),
            self.world.blurred(turn, 0.05 * abs(turn)),
        )
        if self.held is not None:
            self.world.samples[self.held] = self.jaws

    def _touches(self, at: complex) -> bool:
        others = [body.at for body in self.world.bodies.values() if body is not self]
        return any(abs(at - other) < 2 * RADIUS_M for other in others) or any(
            _distance(at, wall) < RADIUS_M for wall in self.world.walls
        )

    def _between(self) -> str | None:
        near = {tag: abs(point - self.jaws) for tag, point in self.world.samples.items()}
        tag = min(near, key=near.__getitem__, default=None)
        return tag if tag is not None and near[tag] <= BARRIER_M else None

    def _range(self, angle: float) -> float:
        way = complex(cos(self.pose.heading_rad + angle), sin(self.pose.heading_rad + angle))
        far = [_ray(self.at, way, wall) for wall in self.world.walls]
        far += [
            _disc(self.at, way, body.at, RADIUS_M) for body in self.world.bodies.values() if body is not self
        ]
        lifted = {body.held for body in self.world.bodies.values()}
        far += [
            _disc(self.at, way, at, SAMPLE_RADIUS_M)
            for tag, at in self.world.samples.items()
            if tag not in lifted
        ]
        range_m = min(far, default=inf) - RADIUS_M
        return max(0.0, self.world.blurred(range_m, 0.01)) if range_m < WHISKER_RANGE_M else inf

    def _sightings(self) -> list[Sighting]:
        world = self.world
        seen = {name: spec.point for name, spec in world.beacons.items()}
        seen |= {name: body.at for name, body in world.bodies.items() if body is not self}
        seen |= {tag: at for tag, at in world.samples.items() if tag != self.held}
        return [self._sighting(name, at) for name, at in seen.items() if world.in_sight(self.at, at)]

    def _sighting(self, name: str, at: complex) -> Sighting:
        world, way = self.world, at - self.at
        spec = world.beacons.get(name)
        around = atan2(-way.imag, -way.real)
        aspect = min((wrap(around - axis) for axis in spec.approach_rad), key=abs) if spec else 0.0
        return Sighting(
            identity=name,
            range_m=max(0.0, world.blurred(abs(way), 0.01)),
            bearing_rad=wrap(world.blurred(atan2(way.imag, way.real) - self.pose.heading_rad, 0.01)),
            aspect_rad=wrap(world.blurred(aspect, 0.02)) if spec else 0.0,
        )


def _moved(pose: Pose, step_m: float, turn: float) -> Pose:
    heading = pose.heading_rad + turn / 2
    return replace(
        pose,
        x_m=pose.x_m + step_m * cos(heading),
        y_m=pose.y_m + step_m * sin(heading),
        heading_rad=wrap(pose.heading_rad + turn),
    )


def _ray(start: complex, way: complex, wall: Segment) -> float:
    """How many times `way` from `start` to the wall; inf if it is not met."""
    along, off = wall[1] - wall[0], wall[0] - start
    cross = (way.conjugate() * along).imag
    if abs(cross) < 1e-12:
        return inf
    t, u = (off.conjugate() * along).imag / cross, (off.conjugate() * way).imag / cross
    return t if t >= 0 and 0 <= u <= 1 else inf


def _disc(start: complex, way: complex, middle: complex, radius_m: float) -> float:
    off = (middle - start) * way.conjugate()
    if off.real <= 0 or abs(off.imag) > radius_m:
        return inf
    return off.real - (radius_m**2 - off.imag**2) ** 0.5


def _distance(point: complex, wall: Segment) -> float:
    along = wall[1] - wall[0]
    share = max(0.0, min(1.0, ((point - wall[0]) * along.conjugate()).real / abs(along) ** 2))
    gap = point - wall[0] - share * along
    return hypot(gap.real, gap.imag)
