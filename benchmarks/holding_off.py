"""Whole missions in the simulation, places held while used beside held from start to end.

`python -m benchmarks.holding_off`. In the pack `examples/holding_off` robots drive up while another is still at a
place, and hold off until it has left. Random stores with one interchange, three to five robots, samples that cross
each other there. Every mission is run twice: by robots that know DRIVE and HAUL, and by the same without. For each: the
plan's makespan, the time that the mission took, whether its goals became true, and how close two robots' middles came
(they touch at 0.44 m).
"""

import argparse
import random
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import hypot, inf
from pathlib import Path
from statistics import median

from app.cli.simulated_mission import MissionResult, simulate_mission
from app.cli.trials.offline_mission import goal_problem, plan_mission
from app.domain.world_model import initial_facts
from app.packs.find import load_packs
from planner import PlanningRequest
from planner.engines.registry import portfolio
from robots.physical.body import RADIUS_M
from robots.wire import SymbolicFact
from robots.world import Sample, WorldFile, generate_world, store_shape
from sim import Truth

PACK = Path(__file__).parents[1] / "examples" / "holding_off"
STORE_TAGS = ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2")
PHASE_TAGS = ("DRIVE_OFF", "DRIVE_UP", "DRIVE", "HAUL_OFF", "HAUL_UP", "HAUL")
TOUCHING_M = 2 * RADIUS_M


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """A mission, how it ended, and how close two robots came."""

    planned_s: float
    result: MissionResult
    closest_m: float

    @property
    def took_s(self) -> float:
        return self.result.truth.time_s

    def __str__(self) -> str:
        ended = (
            self.result.outcome.value
            if self.result.came_true
            else f"{self.result.packet}: {self.result.reason}"
        )
        return f"planned {self.planned_s:5.1f} s, took {self.took_s:5.1f} s, {self.closest_m:.2f} m, {ended}"


def crossing(seed: int) -> tuple[WorldFile, list[SymbolicFact]]:
    """A store with one interchange, and goals that take samples through it in both directions."""
    choose = random.Random(seed)
    yard_robots = choose.randint(2, 3)
    shape = store_shape(
        samples=0, aisles=1, store_robots=choose.randint(1, 2), yard_robots=yard_robots, doors=4, bays=6
    )
    world = generate_world(shape)
    doors, bays = (
        choose.sample(names, len(names))
        for names in ([p.name for p in world.locations if p.kind == kind] for kind in ("door", "bay"))
    )
    stored = choose.randint(1, 3)
    ways = [*zip(doors[:stored], bays[1:], strict=False), (bays[0], doors[stored])]
    samples = [
        Sample(name=f"sample_{n}", at=start).model_dump() for n, (start, _) in enumerate(ways, start=1)
    ]
    goals = [
        SymbolicFact(predicate="in", args=(f"sample_{n}", end)) for n, (_, end) in enumerate(ways, start=1)
    ]
    return WorldFile.model_validate({**world.model_dump(), "samples": samples}), goals


def run(world: WorldFile, goals: Sequence[SymbolicFact], *, seed: int, holding_off: bool) -> Run:
    """Plan the goals and carry them out in the simulation."""
    packs = load_packs([str(PACK)])
    base = packs.knowledge_base()
    tags = (*STORE_TAGS, *(PHASE_TAGS if holding_off else ()))
    robots = tuple(robot.model_copy(update={"repertoire": tags}) for robot in world.robots)
    world = world.model_copy(update={"robots": robots})
    problem = goal_problem(world, initial_facts(world, base), goals, base)
    request = PlanningRequest(time_limit_s=60, clock=time.process_time)
    mission = plan_mission(world, problem, portfolio(base), base, request, library=packs.library())
    closest_m = inf

    def watch(truth: Truth) -> None:
        nonlocal closest_m
        for one, other in combinations(truth.robots.values(), 2):
            closest_m = min(closest_m, hypot(one.x_m - other.x_m, one.y_m - other.y_m))

    result = simulate_mission(mission, seed=seed, packet_files=packs.packets, watch=watch)
    return Run(planned_s=mission.plan_net.makespan_s, result=result, closest_m=closest_m)


def pairs(seeds: Sequence[int]) -> Iterator[tuple[int, Run, Run]]:
    """For each seed the mission with places held while used, and held from start to end."""
    for seed in seeds:
        world, goals = crossing(seed)
        yield (
            seed,
            run(world, goals, seed=seed, holding_off=True),
            run(world, goals, seed=seed, holding_off=False),
        )


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="benchmarks.holding_off", description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    options = parser.parse_args(arguments)
    made: list[tuple[Run, Run]] = []
    for seed, held, plain in pairs(range(options.first, options.first + options.seeds)):
        print(f"seed {seed}: while used {held}\n{'':8}start to end {plain}", flush=True)
        made.append((held, plain))
    for name, of_kind in zip(("while used", "start to end"), zip(*made, strict=True), strict=True):
        true = sum(one.result.came_true for one in of_kind)
        touched = sum(one.closest_m < TOUCHING_M for one in of_kind)
        print(f"{name}: {true} of {len(of_kind)} came true, in {touched} two robots touched")
    print(f"median speed-up {median(plain.took_s / held.took_s for held, plain in made):.2f}")


if __name__ == "__main__":
    main()
