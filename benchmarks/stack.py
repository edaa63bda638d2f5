"""The whole stack flat out beside a bare PyBullet loop of the same bodies: `python -m benchmarks.stack`.

Whole: physics, sensing, synthesis and executive of robots that are all busy, three of four on tours, the others
fetching a sample. Bare: the same scene, every rover given its recorded velocity and every pose read at each tick; no
sensing, no agents. Rays: likewise, with the whiskers' rays in one batch of the physics engine at 20 Hz. The loops take
turns, a second of the world each, so that all run under the same load; figures are medians, CPU seconds a world second.
Whole adds up the processes over which the agents are spread. Path is the longest path through them: the world's own
process, with the slowest process's agents instead of its own; x real is the speed with a core for each.
"""

import argparse
import os
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import atan2, cos, sin
from statistics import median
from time import process_time
from typing import Any

import numpy as np
import pybullet

from app.planning.pool.process_tree import tree_of
from benchmarks.errands import Leg, script, tour
from benchmarks.processes import cpu_s
from robots.physical.body import RADIUS_M
from robots.wire import BehaviourScript, Message, Performative, ScriptRequest, ScriptState, Telemetry
from robots.world import WorldFile
from robots.world.generate import generate_world, store_shape
from sim.clock import TICKS_PER_CONTROL
from sim.physics.scene import SONAR_GROUPS
from sim.physics.sensors import WHISKER_HEIGHT_M
from sim.world.agent_group import processes_for
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation

SETTLE_S, TICKS_A_S = 2, 60
MEASURED_S, MANY_MEASURED_S, MANY = 5, 2, 100
"""Seconds of the world that are measured; fewer with `MANY` robots, so that a run takes a minute or two."""
STOPS = 8
Velocities = list[list[tuple[float, float]]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Figures:
    """CPU seconds a world second; `busy`: how many robots reported a running script."""

    robots: int
    busy: int
    bare: float
    rays: float
    whole: float
    path: float
    physics: float
    sensing: float
    agents: float

    def __str__(self) -> str:
        return (
            f"{self.robots:6d} {self.busy:5d} {self.bare:7.3f} {self.rays:7.3f} {self.whole:7.3f} {self.path:7.3f} "
            f"{self.whole / self.bare:6.1f} {self.whole / self.rays:6.1f} {1 / self.path:7.1f} "
            f"{self.physics:8.3f} {self.sensing:8.3f} {self.agents:7.3f} "
            f"{self.agents / self.robots / TICKS_A_S * TICKS_PER_CONTROL * 1e6:7.0f}"
        )


class Idle:
    def tick(self) -> None: ...


class Stopwatch:
    """Adds up the CPU time of calls, by name."""

    def __init__(self) -> None:
        self.spent_s: dict[str, float] = {}

    def time(self, name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*given: Any, **named: Any) -> Any:
            begin = process_time()
            try:
                return call(*given, **named)
            finally:
                self.spent_s[name] = self.spent_s.get(name, 0.0) + process_time() - begin

        return timed

    def take(self, name: str) -> float:
        return self.spent_s.pop(name, 0.0)


class Whole:
    """The simulation with its agents, timed by parts; keeps each rover's velocities."""

    def __init__(self, world: WorldFile) -> None:
        processes = processes_for(len(world.robots))
        before = {each.pid for each in tree_of(os.getpid())}
        self.simulation = Simulation(world, make_agent=behavioural_agent, seed=0, processes=processes)
        self._others = [each.pid for each in tree_of(os.getpid()) if each.pid not in before]
        self.busy: set[str] = set()
        self._watch = Stopwatch()
        for each in errands(world):
            self._request(each)
        for holder, method, part in (
            (self.simulation.scene, "step", "physics"),
            (self.simulation, "_sense", "sensing"),
            *((body, "drive", "physics") for body in self.simulation.bodies.values()),
            *((agent, "tick", "agents") for agent in self.simulation.agents.values()),
        ):
            setattr(holder, method, self._watch.time(part, getattr(holder, method)))

    def run(self) -> tuple[dict[str, float], Velocities]:
        """A second of the world: what it took, whole and in parts, and each tick's velocities."""
        driven: Velocities = []
        own = 0.0
        others = [-cpu_s(pid) for pid in self._others]
        for _ in range(TICKS_A_S):
            begin = process_time()
            self.simulation.step()
            own += process_time() - begin
            driven.append([body.driven for body in self.simulation.bodies.values()])
        for message in self.simulation.link.receive():
            if isinstance(message.body, Telemetry) and message.body.script_state is ScriptState.RUNNING:
                self.busy.add(message.sender)
        others = [spent + cpu_s(pid) for spent, pid in zip(others, self._others, strict=True)]
        mine = self._watch.take("agents")
        return {
            "whole": own + sum(others),
            "path": own - mine + max([mine, *others]),
            "physics": self._watch.take("physics"),
            "sensing": self._watch.take("sensing"),
            "agents": mine + sum(others),
        }, driven

    def _request(self, each: BehaviourScript) -> None:
        request = ScriptRequest(script=each)
        self.simulation.link.send(
            Message(
                performative=Performative.REQUEST,
                sender="service",
                receiver=each.robot,
                sent_at_s=0.0,
                body=request,
            )
        )


class Bare:
    """The same bodies in the same places, in a loop of nothing but PyBullet."""

    def __init__(self, world: WorldFile, *, rays: bool) -> None:
        self._scene = Simulation(world, make_agent=lambda _: Idle(), seed=0).scene  # ends if dropped
        self._client = self._scene.client
        self._rovers = list(self._scene._rovers.values())
        self._samples = list(self._scene._samples.values())
        self._specs, self._rays = world.robots, rays
        self._tick = 0

    def run(self, driven: Velocities) -> float:
        """A second of the world."""
        begin = process_time()
        poses = [self._pose(body) for body in self._rovers]
        for velocities in driven:
            if self._rays and self._tick % TICKS_PER_CONTROL == 0:
                self._cast(poses)
            self._tick += 1
            for body, pose, (linear, angular) in zip(self._rovers, poses, velocities, strict=True):
                ahead = [linear * cos(pose[2]), linear * sin(pose[2]), 0.0]
                pybullet.resetBaseVelocity(body, ahead, [0.0, 0.0, angular], physicsClientId=self._client)
            pybullet.stepSimulation(physicsClientId=self._client)
            poses = [self._pose(body) for body in self._rovers]
            for body in self._samples:
                self._pose(body)
        return process_time() - begin

    def _pose(self, body: int) -> tuple[float, float, float]:
        (x, y, _), turn = pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client)
        return x, y, 2 * atan2(turn[2], turn[3])

    def _cast(self, poses: list[tuple[float, float, float]]) -> None:
        starts, ends = [], []
        for (x, y, heading), spec in zip(poses, self._specs, strict=True):
            angles = heading + np.arange(spec.whiskers) * 2 * np.pi / spec.whiskers
            ways = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(spec.whiskers)])
            middle = np.array([x, y, WHISKER_HEIGHT_M])
            starts.append(middle + (RADIUS_M + 0.002) * ways)
            ends.append(middle + (RADIUS_M + spec.whisker_range_m) * ways)
        pybullet.rayTestBatch(
            np.concatenate(starts),
            np.concatenate(ends),
            collisionFilterMask=SONAR_GROUPS,
            physicsClientId=self._client,
        )


def errands(world: WorldFile) -> Iterator[BehaviourScript]:
    """A script a robot: every fourth fetches a sample of its reach, if there is one, the others tour their places."""
    rng = random.Random(0)
    wanted = {sample.at: sample.name for sample in world.samples}
    for number, spec in enumerate(world.robots):
        places = [place.name for place in world.reach_of(spec) if place.kind != "home"]
        near = [place for place in places if place in wanted]
        free = [place for place in places if place not in wanted]
        if number % 4 == 0 and near and free:
            leg = Leg(robot=spec.name, fetch=near[0], deposit=free[0])
            yield script(leg, wanted.pop(near[0]), handed_over=False)
        else:
            yield tour(spec.name, rng.sample(places, min(STOPS, len(places))))


def figures(robots: int) -> Figures:
    yard = max(2, robots // 4)
    world = generate_world(
        store_shape(samples=4 * robots, store_robots=robots - yard, yard_robots=yard), seed=0
    )
    whole, bare, rays = Whole(world), Bare(world, rays=False), Bare(world, rays=True)
    took: dict[str, list[float]] = {}
    for second in range(SETTLE_S + (MEASURED_S if robots < MANY else MANY_MEASURED_S)):
        parts, driven = whole.run()
        parts |= {"bare": bare.run(driven), "rays": rays.run(driven)}
        if second >= SETTLE_S:
            for name, took_s in parts.items():
                took.setdefault(name, []).append(took_s)
    return Figures(
        robots=len(world.robots),
        busy=len(whole.busy),
        **{name: median(all_s) for name, all_s in took.items()},
    )


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("robots", type=int, nargs="*", default=[4, 16, 64, 256])
    print(
        "robots  busy    bare   +rays   whole    path  ratio +rays  x real  physics  sensing  agents us/tick"
    )
    for robots in options.parse_args().robots:
        print(figures(robots), flush=True)


if __name__ == "__main__":
    main()
