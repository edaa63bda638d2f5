"""Whole missions in the simulation, places held while used beside held from start to end.

`python -m benchmarks.holding_off crossing --runs 100`: two to six robots in a random store with one interchange, and
samples that cross each other there. `python -m benchmarks.holding_off stored --runs 4 --beside`: 16 samples that four
robots bring from the doors to the bays through one interchange, in `stored_apart` through two. Robots drive up while
another is still at a place, and hold off until it has left; with `--beside` every mission is also run by robots that
cannot. For each: the plan's makespan, the time that the mission took, whether its goals became true, and how close two
robots' middles came (they touch at 0.44 m).
"""

import argparse
import random
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from math import hypot, inf
from statistics import median

from app.cli.simulated_mission import MissionResult, simulate_mission
from app.cli.trials.offline_mission import goal_problem, plan_mission
from app.cli.trials.sweep_results import Outcome
from app.domain.world_model import initial_facts
from planner import PlanningRequest, load_knowledge_base
from planner.engines.registry import portfolio
from robots.physical.body import RADIUS_M
from robots.wire import SymbolicFact
from robots.world import Sample, WorldFile, generate_world, store_shape
from robots.world.parts import STORE_TAGS
from sim import Truth

TOUCHING_M = 2 * RADIUS_M
Task = tuple[WorldFile, list[SymbolicFact]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """A mission, how it ended, and how close two robots came."""

    planned_s: float
    result: MissionResult
    closest_m: float

    @property
    def took_s(self) -> float:
        return self.result.truth.time_s

    @property
    def has_touched(self) -> bool:
        return self.closest_m < TOUCHING_M

    def __str__(self) -> str:
        ended = (
            self.result.outcome.value
            if self.result.came_true
            else f"{self.result.packet}: {self.result.reason}"
        )
        return f"planned {self.planned_s:5.1f} s, took {self.took_s:5.1f} s, {self.closest_m:.2f} m, {ended}"


def crossing(seed: int) -> Task:
    """A store with one interchange, and goals that take samples through it in both directions."""
    choose = random.Random(seed)
    yard_robots = choose.randint(1, 3)
    store_robots = choose.randint(1, 3)
    shape = store_shape(
        samples=0, aisles=1, store_robots=store_robots, yard_robots=yard_robots, doors=4, bays=6
    )
    world = generate_world(shape, in_phases=True)
    doors, bays = (
        choose.sample(names, len(names))
        for names in ([p.name for p in world.locations if p.kind == kind] for kind in ("door", "bay"))
    )
    stored = choose.randint(1, 3)
    ways = [*zip(doors[:stored], bays[1:], strict=False), (bays[0], doors[stored])]
    return _task(world, ways)


def stored(seed: int, *, aisles: int = 1) -> Task:
    """Sixteen samples at the doors that four robots bring into the store, through an interchange an aisle."""
    shape = store_shape(
        samples=0,
        aisles=aisles,
        interchanges=aisles,
        store_robots=2,
        yard_robots=2,
        doors=16,
        bays=16,
    )
    world = generate_world(shape, in_phases=True)
    doors, bays = ([p.name for p in world.locations if p.kind == kind] for kind in ("door", "bay"))
    random.Random(seed).shuffle(bays)
    return _task(world, list(zip(doors, bays, strict=True)))


def _task(world: WorldFile, ways: Sequence[tuple[str, str]]) -> Task:
    samples = [
        Sample(name=f"sample_{n}", at=start).model_dump() for n, (start, _) in enumerate(ways, start=1)
    ]
    goals = [
        SymbolicFact(predicate="in", args=(f"sample_{n}", end)) for n, (_, end) in enumerate(ways, start=1)
    ]
    return WorldFile.model_validate({**world.model_dump(), "samples": samples}), goals


def run(task: Task, *, seed: int, in_phases: bool) -> Run:
    """Plan the goals and carry them out in the simulation."""
    world, goals = task
    base = load_knowledge_base()
    if not in_phases:
        robots = tuple(robot.model_copy(update={"repertoire": STORE_TAGS}) for robot in world.robots)
        world = world.model_copy(update={"robots": robots})
    problem = goal_problem(world, initial_facts(world, base), goals, base)
    request = PlanningRequest(time_limit_s=60, clock=time.process_time)
    mission = plan_mission(world, problem, portfolio(base), base, request)
    closest_m = inf

    def watch(truth: Truth) -> None:
        nonlocal closest_m
        for one, other in combinations(truth.robots.values(), 2):
            closest_m = min(closest_m, hypot(one.x_m - other.x_m, one.y_m - other.y_m))

    result = simulate_mission(mission, seed=seed, watch=watch)
    return Run(planned_s=mission.plan_net.makespan_s, result=result, closest_m=closest_m)


KINDS: dict[str, Callable[[int], Task]] = {
    "crossing": crossing,
    "stored": stored,
    "stored_apart": partial(stored, aisles=2),
}
NAMES = {True: "while used", False: "start to end"}


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="benchmarks.holding_off", description=__doc__)
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    parser.add_argument("--beside", action="store_true", help="run each mission also without phases")
    options = parser.parse_args(arguments)
    made: dict[bool, list[Run]] = {name: [] for name in ((True, False) if options.beside else (True,))}
    for seed in range(options.first, options.first + options.runs):
        task = KINDS[options.kind](seed)
        for in_phases, runs in made.items():
            runs.append(run(task, seed=seed, in_phases=in_phases))
            robots = len(task[0].robots)
            print(f"seed {seed}, {robots} robots, {NAMES[in_phases]:12}: {runs[-1]}", flush=True)
    for in_phases, runs in made.items():
        true = sum(one.result.came_true for one in runs)
        touched = sum(one.has_touched for one in runs)
        unended = sum(one.result.outcome is Outcome.UNENDED for one in runs)
        counts = f"{true} of {len(runs)} came true, in {touched} two robots touched, {unended} did not end"
        print(f"{NAMES[in_phases]}: {counts}")
    if options.beside:
        both = [
            pair for pair in zip(*made.values(), strict=True) if all(one.result.came_true for one in pair)
        ]
        ratios = sorted(plain.took_s / held.took_s for held, plain in both)
        planned = sorted(plain.planned_s / held.planned_s for held, plain in both)
        print(
            f"both came true in {len(both)}: missions {median(ratios):.2f} times faster in the median "
            f"({ratios[0]:.2f} to {ratios[-1]:.2f}), plans {median(planned):.2f} times"
        )


if __name__ == "__main__":
    main()
