"""A small world and agents that do as they are told, for tests of the simulation alone."""

from collections.abc import Mapping
from typing import Any

from robots.physical.body import Pose
from robots.world import WorldFile
from sim.world.agent import AgentSetup
from sim.world.simulation import Simulation


class Puppet:
    """An agent that keeps the velocity it is given."""

    def __init__(self, setup: AgentSetup) -> None:
        self.setup = setup
        self.body = setup.body
        self.velocity = (0.0, 0.0)
        self.ticks = 0

    def tick(self) -> None:
        self.ticks += 1
        self.body.set_velocity(*self.velocity)


def two_rooms(
    start: tuple[float, float, float] = (1, 1, 0),
    *,
    kind: str = "hatch",
    width_m: float = 0.4,
    second: tuple[float, float, float] | None = None,
    samples: Mapping[str, str] | None = None,
    whiskers: int = 16,
) -> WorldFile:
    """Two rooms, west and east of a wall at x = 2 one opening at y = 1, where `pass` lies."""
    robots: list[dict[str, Any]] = [
        {"name": "fred", "compartment": "west", "start": start, "whiskers": whiskers},
    ]
    if second is not None:
        robots.append({"name": "ginger", "compartment": "west", "start": second})
    walls: list[dict[str, Any]] = [
        {"start": a, "end": b}
        for a, b in [((0, 0), (4, 0)), ((0, 2), (4, 2)), ((0, 0), (0, 2)), ((4, 0), (4, 2))]
    ]
    walls.append(
        {"start": (2, 0), "end": (2, 2), "openings": [{"kind": kind, "at_m": 1, "width_m": width_m}]}
    )
    return WorldFile.model_validate(
        {
            "name": "two_rooms",
            "compartments": [
                {"name": "west", "x": (0, 2), "y": (0, 2)},
                {"name": "east", "x": (2, 4), "y": (0, 2)},
            ],
            "walls": walls,
            "locations": [
                {"name": "pass", "kind": "interchange", "at": (2, 1), "approach_deg": (0, 180)},
                {"name": "corner", "kind": "bay", "at": (0.5, 1.5), "approach_deg": (0,)},
                {"name": "east_bay", "kind": "bay", "at": (3.5, 1), "approach_deg": (180,)},
            ],
            "robots": robots,
            "samples": [{"name": name, "at": at} for name, at in (samples or {}).items()],
        }
    )


def with_only(world: WorldFile, *robots: str) -> WorldFile:
    """The world without its other robots."""
    file = world.model_dump()
    file["robots"] = [robot for robot in file["robots"] if robot["name"] in robots]
    return WorldFile.model_validate(file)


def simulate(
    world: WorldFile, *, seed: int = 0, jitter_m: float = 0.0
) -> tuple[Simulation, dict[str, Puppet]]:
    simulation = Simulation(world, make_agent=Puppet, seed=seed, jitter_m=jitter_m)
    puppets = {name: agent for name, agent in simulation.agents.items() if isinstance(agent, Puppet)}
    return simulation, puppets


def run_s(simulation: Simulation, seconds: float) -> None:
    for _ in range(round(seconds * 60)):
        simulation.step()


def fred(simulation: Simulation) -> Pose:
    return simulation.truth().robots["fred"]
