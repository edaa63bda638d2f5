"""Runs packets on one robot in a PyBullet room and keeps what truly happened: for benchmarks and tests."""

import itertools
from collections.abc import Callable, Iterable
from math import dist
from typing import Any

from robots.physical.body import Pose
from robots.repertoire import Repertoire
from robots.wire import BehaviourPacket, BehaviourScript, PacketReport, ScriptReport
from robots.world import WorldFile
from sim.trials.script_runner import ScriptRunner
from sim.world.agent import Agent, AgentSetup
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation

SCRIPT = "script"
Box = tuple[float, float, float, float]
"""West, south, east, north, metres."""


def packet(tag: str, *, timeout_s: float = 60, **arguments: object) -> BehaviourPacket:
    return BehaviourPacket(
        id=tag.lower(),
        tag=tag,
        arguments={name: str(value) for name, value in arguments.items()},
        expected_start_s=0,
        expected_duration_s=10,
        timeout_s=timeout_s,
        wait_timeout_s=20,
    )


def room(
    *,
    size: tuple[float, float] = (6, 6),
    boxes: Iterable[Box] = (),
    start: tuple[float, float, float] = (3, 3, 0),
    other: tuple[float, float, float] | None = None,
    ball: tuple[float, float] | None = None,
) -> WorldFile:
    """A walled room; `fred` in it, if wanted `ginger` and a sample named `ball`; boxes are solid."""
    east, north = size
    walls = [wall for box in ((0, 0, east, north), *boxes) for wall in _sides(box)]
    robots: list[dict[str, Any]] = [{"name": "fred", "compartment": "room", "start": start}]
    if other is not None:
        robots.append({"name": "ginger", "compartment": "room", "start": other})
    places = [{"name": "post", "kind": "place", "at": (0.3, 0.3), "approach_deg": (45,)}]
    if ball is not None:
        places.append({"name": "spot", "kind": "place", "at": ball, "approach_deg": (0,)})
    return WorldFile.model_validate(
        {
            "name": "suite_room",
            "compartments": [{"name": "room", "x": (0, east), "y": (0, north)}],
            "walls": walls,
            "locations": places,
            "robots": robots,
            "samples": [{"name": "ball", "at": "spot"}] if ball is not None else [],
        }
    )


def _sides(box: Box) -> list[dict[str, Any]]:
    west, south, east, north = box
    corners = [(west, south), (east, south), (east, north), (west, north)]
    return [
        {"start": one, "end": other} for one, other in zip(corners, corners[1:] + corners[:1], strict=True)
    ]


class Refused(Exception):
    """Raised when the robot refuses the script; says why."""


class Driven:
    """An agent whose velocity is a function of time: a moving obstacle."""

    def __init__(self, setup: AgentSetup, velocity: Callable[[float], tuple[float, float]]) -> None:
        self._fitting, self._velocity = setup, velocity

    def tick(self) -> None:
        self._fitting.body.set_velocity(*self._velocity(self._fitting.clock.now_s()))


class Trial:
    """Runs one script of `fred`'s in a world, and keeps what it reported and what truly happened."""

    def __init__(
        self,
        world: WorldFile,
        *packets: BehaviourPacket,
        seed: int = 0,
        jitter_m: float = 0.0,
        other: Callable[[float], tuple[float, float]] = lambda _: (0.0, 0.0),
        repertoire: Repertoire | None = None,
    ) -> None:
        def agent(setup: AgentSetup) -> Agent:
            if setup.spec.name != "fred":
                return Driven(setup, other)
            return behavioural_agent(setup, repertoire)

        self._runner = ScriptRunner(world, make_agent=agent, seed=seed, jitter_m=jitter_m)
        self.touched = False
        self.path: list[Pose] = [self.pose]
        self._runner.send([BehaviourScript(id=SCRIPT, mission_id="suite", robot="fred", packets=packets)])

    @property
    def simulation(self) -> Simulation:
        return self._runner.simulation

    @property
    def reports(self) -> list[PacketReport]:
        return self._runner.reports

    @property
    def ended(self) -> ScriptReport | None:
        return self._runner.ended.get(SCRIPT)

    @property
    def pose(self) -> Pose:
        return self.simulation.truth().robots["fred"]

    @property
    def other(self) -> Pose:
        return self.simulation.truth().robots["ginger"]

    @property
    def events(self) -> list[str]:
        return [event for report in self.reports for event in report.events]

    @property
    def driven_m(self) -> float:
        points = [(pose.x_m, pose.y_m) for pose in self.path]
        return sum(dist(one, other) for one, other in itertools.pairwise(points))

    def run(self, *, limit_s: float = 120.0, each: Callable[[], None] = lambda: None) -> "Trial":
        """Run until the script has ended; `each` is called at 20 Hz.

        :raises Refused: if the robot refuses it.
        :raises TimeoutError: if it does not end.
        """

        def over() -> bool:
            self._listen()
            each()
            return self.ended is not None

        if not self.simulation.run_until(over, timeout_s=limit_s):
            raise TimeoutError(f"the script did not end within {limit_s} s: {self.reports}")
        return self

    def run_for(self, seconds: float) -> None:
        """Run the world for a time."""
        self.simulation.run_until(lambda: False, timeout_s=seconds)

    def _listen(self) -> None:
        self.touched |= self.simulation.bodies["fred"].touches()
        self.path.append(self.pose)
        self._runner.receive()
        if SCRIPT in self._runner.refused:
            raise Refused(self._runner.refused[SCRIPT].reason)
