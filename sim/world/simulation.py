"""A simulated world: scene, bodies, agents, clock. Bit-identical for the same file, seed and messages, and for the same
snapshot and messages.
"""

import uuid
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import dist, hypot
from typing import Protocol, runtime_checkable

import numpy as np

from robots.clock import Clock
from robots.executive.memory import RobotMemory
from robots.link import InMemoryLink, Link
from robots.physical.body import Body, Pose, Readings, Sensor
from robots.world import Location, RobotSpec, WorldFile
from robots.world.walls import panels_of
from sim.bodies import FloorMap, make_bodies
from sim.physics.jaws import Jaws
from sim.physics.scene import TICK_S, Scene
from sim.physics.sensors import InfraRed, Whiskers, beacons_of
from sim.snapshot import RockState, SampleState, StreamState, WorldSnapshot, digest_of
from sim.truth import SampleTruth, Truth, place_at
from sim.world.hub import Hub
from sim.world.placement import Places
from sim.world.radio import radios_of

TICKS_A_CONTROL = 3  # agents sense and act at 20 Hz
CHARGES_M = 1.1
"""A rover that stands this near to its home's beacon can be charged: by its approach point."""


class Agent(Protocol):
    """A robot's on-board software, driven by the world's clock at 20 Hz."""

    def tick(self) -> None: ...


@runtime_checkable
class Remembering(Protocol):
    """An agent that can go on after a restart."""

    def memory(self) -> RobotMemory: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitting:
    """What an agent is fitted out with: spec, the locations of its reach, long objects, its told pose, its radio's
    round trip, its seams, and what it remembers.
    """

    spec: RobotSpec
    reach: tuple[Location, ...]
    others: tuple[str, ...]
    lengths_m: Mapping[str, float]
    told: Pose
    round_trip_s: float
    body: Body
    link: Link
    clock: Clock
    memory: RobotMemory | None = None


AgentMaker = Callable[[Fitting], Agent]


class WorldClock:
    """The world's clock: the number of ticks, in seconds."""

    def __init__(self) -> None:
        self.ticks = 0

    def now_s(self) -> float:
        return self.ticks * TICK_S


class Simulation:
    """A world in this process. `step` advances it by 1/60 s. `run` names it from its building on, however often it is
    resumed.

    :param hub: sorts the service's messages; without one, `link` is the service's end of an in-memory link.
    :param jitter_m: how far start places may be from the world file's; headings are then random, too.
    :param snapshot: what to go on from; then `seed` and `jitter_m` do not count. Its run, its places, its clock.
    """

    def __init__(
        self,
        world: WorldFile,
        *,
        make_agent: AgentMaker,
        seed: int = 0,
        jitter_m: float = 0.4,
        hub: Hub | None = None,
        snapshot: WorldSnapshot | None = None,
    ) -> None:
        self.run, self._seed = (snapshot.run, snapshot.seed) if snapshot else (uuid.uuid4().hex, seed)
        placing, *streams = [
            np.random.default_rng(s) for s in np.random.SeedSequence(self._seed).spawn(len(world.robots) + 1)
        ]
        self.world, self.clock, self._digest = world, WorldClock(), digest_of(world)
        self.link, robots_end = InMemoryLink.pair()
        self.hub = hub or Hub(
            robots_end, [spec.name for spec in world.robots], radios=radios_of(world, self._seed)
        )
        self._rngs = {spec.name: rng for spec, rng in zip(world.robots, streams, strict=True)}
        panels = panels_of(world.walls)
        places = Places.kept(world, snapshot) if snapshot else Places.drawn(world, panels, placing, jitter_m)
        self._places = places
        self.scene = Scene(panels, places.rovers, places.samples)
        for rock in places.rocks:
            self.scene.put_rock(rock.point, radius_m=rock.radius_m)
        self._jaws = Jaws(self.scene, list(places.rovers), places.samples)
        self._whiskers = Whiskers(world.robots)
        reach = {spec.name: {place.name for place in world.reach_of(spec)} for spec in world.robots}
        self._infra_red = InfraRed(beacons_of(world), reach, world.samples)
        self.bodies = make_bodies(
            world.robots,
            scene=self.scene,
            floor=FloorMap(panels, places.rocks),
            jaws=self._jaws,
            told=places.told,
            rngs=self._rngs,
        )
        self._homes = {spec.name: world.location(spec.home) for spec in world.robots if spec.home}
        self._touched: set[str] = set()
        if snapshot is not None:
            self._recall(snapshot)
        self._sense()
        memories = snapshot.robots if snapshot else {}
        self.agents = {
            spec.name: make_agent(self._fitting(spec, memories.get(spec.name))) for spec in world.robots
        }

    def snapshot(self) -> WorldSnapshot:
        """All it takes to go on from here; to be taken between two steps."""
        return WorldSnapshot(
            run=self.run,
            digest=self._digest,
            seed=self._seed,
            ticks=self.clock.ticks,
            rovers=self._poses(),
            told=dict(self._places.told),
            samples={
                one.name: SampleState(
                    point=self.scene.sample_point(one.name)[:2],
                    heading_rad=self.scene.sample_heading(one.name),
                )
                for one in self.world.samples
            },
            rocks=tuple(RockState(point=rock.point, radius_m=rock.radius_m) for rock in self._places.rocks),
            jaws=self._jaws.snapshot(),
            bodies={name: body.state() for name, body in self.bodies.items()},
            streams={name: StreamState.of(rng) for name, rng in self._rngs.items()},
            touched=frozenset(self._touched),
            robots={n: agent.memory() for n, agent in self.agents.items() if isinstance(agent, Remembering)},
        )

    def _recall(self, snapshot: WorldSnapshot) -> None:
        """What the places do not tell: time, grips, bodies, random streams."""
        self.clock.ticks, self._touched = snapshot.ticks, set(snapshot.touched)
        self._jaws.recall(snapshot.jaws)
        for name, body in self.bodies.items():
            body.recall(snapshot.bodies[name])
            snapshot.streams[name].restore(self._rngs[name])

    def step(self) -> None:
        """One tick of 1/60 s; every third begins with the agents' sensing and acting.

        :raises LinkClosed: if the service is gone.
        """
        if self.clock.ticks % TICKS_A_CONTROL == 0:
            self.hub.fetch(self.clock.now_s())
            self._spend()
            self._sense()
            for agent in self.agents.values():
                agent.tick()
            self.hub.flush(self.clock.now_s())
        for body in self.bodies.values():
            body.drive()
        self.scene.step()
        self._feel()
        self._jaws.carry()
        self.clock.ticks += 1

    def run_until(self, done: Callable[[], bool], *, timeout_s: float) -> bool:
        """Step until `done`, asked at 20 Hz, or the timeout in world time; True if done."""
        end_s = self.clock.now_s() + timeout_s
        while not done():
            if self.clock.now_s() >= end_s:
                return False
            for _ in range(TICKS_A_CONTROL):
                self.step()
        return True

    def truth(self) -> Truth:
        """The world as it is; never for an agent."""
        return Truth(
            time_s=self.clock.now_s(),
            robots=self._poses(),
            samples=self._sample_truths(),
            deflections_m={name: hypot(*self._jaws.deflection_m(name)) for name in self.bodies},
            slipped=self._jaws.slipped,
        )

    def drop(self, sample: str) -> None:
        """A sample slips out of all jaws that hold it."""
        self._jaws.drop(sample)

    def close(self) -> None:
        self.scene.close()

    def _fitting(self, spec: RobotSpec, memory: RobotMemory | None) -> Fitting:
        return Fitting(
            spec=spec,
            reach=self.world.reach_of(spec),
            others=tuple(other for other in self.bodies if other != spec.name),
            lengths_m={one.name: one.length_m for one in self.world.samples if one.length_m},
            told=self._places.told[spec.name],
            round_trip_s=self.world.link_of(spec).round_trip_s,
            body=self.bodies[spec.name],
            link=self.hub.end_of(spec.name),
            clock=self.clock,
            memory=memory,
        )

    def _spend(self) -> None:
        """The batteries pay for the time since the last control tick."""
        for name, body in self.bodies.items():
            home = self._homes.get(name)
            pose = self.scene.pose(name) if home else None
            at_home = bool(home and pose and dist(home.at, (pose.x_m, pose.y_m)) <= CHARGES_M)
            body.spend(TICKS_A_CONTROL * TICK_S, at_home=at_home)

    def _feel(self) -> None:
        """Bumpers keep a touch until they are read."""
        for name in self._running(Sensor.BUMPER):
            if name not in self._touched and self.bodies[name].touches():
                self._touched.add(name)

    def _running(self, sensor: Sensor) -> Mapping[str, Body]:
        """The bodies by name whose sensor runs."""
        return {name: body for name, body in self.bodies.items() if sensor in body.running}

    def _sense(self) -> None:
        """Only what runs senses: for the others no ray is cast and nothing is looked up."""
        poses = self._poses()
        for name, body in self.bodies.items():
            body.count_way(poses[name])
        ranges = self._whiskers.read(self.scene, poses, self._rngs, self._running(Sensor.ULTRASONIC))
        seen = self._infra_red.read(
            self.scene, poses, self._rngs, self._running(Sensor.INFRA_RED), self._jaws.hidden()
        )
        for name, body in self.bodies.items():
            runs = body.running.__contains__
            body.refresh(
                Readings(
                    time_s=self.clock.now_s(),
                    ranges_m=ranges.get(name),
                    bumper=name in self._touched if runs(Sensor.BUMPER) else None,
                    sightings=seen.get(name),
                    gripper=self._jaws.state(name) if runs(Sensor.GRIPPER) else None,
                    capture_head_m=self._jaws.deflection_m(name) if runs(Sensor.CAPTURE_HEAD) else None,
                    battery=body.battery.level,
                    charging=body.battery.charging,
                )
            )
        self._touched.clear()

    def _poses(self) -> dict[str, Pose]:
        return {name: self.scene.pose(name) for name in self.bodies}

    def _sample_truths(self) -> dict[str, SampleTruth]:
        found = {}
        for sample in self.world.samples:
            x, y, _ = self.scene.sample_point(sample.name)
            holders = self._jaws.holders(sample.name)
            place = None if holders else place_at(self.world, (x, y))
            heading_rad = self.scene.sample_heading(sample.name) if sample.length_m else 0.0
            found[sample.name] = SampleTruth(
                x_m=x, y_m=y, heading_rad=heading_rad, place=place, holders=holders
            )
        return found
