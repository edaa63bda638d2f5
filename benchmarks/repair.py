"""Repair compared with replanning: `python -m benchmarks.repair [--sizes 2 8 32] [--seeds 3]`.

Plans of the store family, carried out for a third of their time as scheduled; then something happens. Both get the
facts as they are then, and both keep what is under way. For each mishap and size, medians over the seeds in which it
can happen and that are solved: seconds to plan, share of the remaining actions kept, makespan from then on.
"""

import argparse
import json
import random
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from math import nan
from statistics import median

from benchmarks.planner.instances import FAMILIES
from benchmarks.planner.scheduled_progress import as_scheduled
from planner import (
    Fact,
    KnowledgeBase,
    PlanNet,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    load_knowledge_base,
)
from planner.engines.registry import portfolio
from planner.repair import MissionProgress, Repair, compare, join, repair

Case = tuple[PlanningProblem, MissionProgress]
SHARE = 1 / 3


def _inside(sample: str, place: str) -> Fact:
    return Fact("object_position", (sample, "in", place))


def _free_bays(problem: PlanningProblem) -> list[str]:
    return sorted(f.args[0] for f in problem.facts if f.predicate == "vacant" and f.args[0].startswith("bay"))


def _unused(problem: PlanningProblem) -> list[str]:
    wanted = {goal.args[2] for goal in problem.goals}
    return [bay for bay in _free_bays(problem) if bay not in wanted]


def _waiting(problem: PlanningProblem) -> list[tuple[str, str]]:
    """Samples that still lie at a door, with it."""
    lying = (f.args for f in sorted(problem.facts) if f.predicate == "object_position")
    return [(sample, place) for sample, _, place in lying if place.startswith("door")]


def nothing(case: Case, old: PlanNet, chance: random.Random) -> Case | None:
    return case


def moved(case: Case, old: PlanNet, chance: random.Random) -> Case | None:
    """A sample that waits at a door is carried to a bay."""
    problem, progress = case
    if not (waiting := _waiting(problem)):
        return None
    (sample, door), bay = chance.choice(waiting), chance.choice(_unused(problem))
    gone = {_inside(sample, door), Fact("vacant", (bay,))}
    facts = problem.facts - gone | {_inside(sample, bay), Fact("vacant", (door,))}
    return replace(problem, facts=facts), progress


def occupied(case: Case, old: PlanNet, chance: random.Random) -> Case | None:
    """Something lies in a bay that a sample is to go to."""
    problem, progress = case
    bays = sorted({goal.args[2] for goal in problem.goals}.intersection(_free_bays(problem)))
    if not bays:
        return None
    bay = chance.choice(bays)
    facts = problem.facts - {Fact("vacant", (bay,))} | {_inside("stray", bay)}
    return replace(problem, facts=facts, objects={**problem.objects, "stray": "object"}), progress


def lost(case: Case, old: PlanNet, chance: random.Random) -> Case | None:
    """A robot of the yard with empty jaws and something left to do is lost."""
    problem, progress = case
    busy = {robot for action in old.actions if action.id not in progress.done for robot in action.agents}
    empty = {f.args[0] for f in problem.facts if f.predicate == "robot_attribute" and "empty" in f.args}
    robots = sorted(robot for robot in busy & empty if robot.startswith("yard"))
    return (problem, replace(progress, lost=frozenset({chance.choice(robots)}))) if robots else None


def added(case: Case, old: PlanNet, chance: random.Random) -> Case | None:
    """One more sample is to go from one bay to another."""
    problem, progress = case
    start, end = chance.sample(_unused(problem), 2)
    facts = problem.facts - {Fact("vacant", (start,))} | {_inside("extra", start)}
    objects = {**problem.objects, "extra": "object"}
    goals = (*problem.goals, _inside("extra", end))
    return replace(problem, facts=facts, objects=objects, goals=goals), progress


MISHAPS: Mapping[str, Callable[[Case, PlanNet, random.Random], Case | None]] = {
    "nothing": nothing,
    "sample moved": moved,
    "bay occupied": occupied,
    "robot lost": lost,
    "goal added": added,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One way's figures: medians over the seeds it solved."""

    mishap: str
    samples: int
    way: str
    solved: str
    seconds: float
    kept: float
    makespan_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Figures:
    """One run: how long it took, what share of the remaining actions it keeps, how long the rest takes."""

    seconds: float
    kept: float
    makespan_s: float


def _ways(
    engine: PlanningEngine, base: KnowledgeBase, old: PlanNet, case: Case, request: PlanningRequest
) -> dict[str, Callable[[], Repair]]:
    problem, progress = case
    ways = {
        "repair": lambda: repair(engine, base, old, problem, progress, request),
        # Without the rest of the old plan nothing but what is under way can be kept.
        "anew": lambda: repair(engine, base, _begun(old, progress), problem, progress, request),
    }
    if new := problem.goals[len(old.goals) :]:
        ways["join"] = lambda: join(engine, base, old, problem, progress, new, request)
    return ways


def _begun(plan_net: PlanNet, progress: MissionProgress) -> PlanNet:
    begun = {*progress.done, *progress.under_way}
    return replace(plan_net, actions=tuple(action for action in plan_net.actions if action.id in begun))


def _measured(way: Callable[[], Repair], old: PlanNet, progress: MissionProgress) -> Figures | None:
    started = time.perf_counter()
    plan_net = way().plan_net
    seconds = time.perf_counter() - started
    if plan_net is None:
        return None
    left = [action for action in old.actions if action.id not in progress.done]
    kept = compare(left, plan_net, elapsed_s=progress.elapsed_s).kept
    return Figures(seconds=seconds, kept=len(kept) / max(1, len(left)), makespan_s=plan_net.makespan_s)


def rows(samples: int, seeds: int, request: PlanningRequest) -> list[Row]:
    """Measure one size."""
    base = load_knowledge_base()
    engine = portfolio(base)
    engine.warm_up()
    made: dict[tuple[str, str], list[Figures | None]] = defaultdict(list)
    for seed in range(seeds):
        problem = FAMILIES["store"](samples, seed).problem(base)
        old = engine.plan(problem, request).plan_net
        if old is None:
            continue
        facts, progress = as_scheduled(old, problem.facts, round(SHARE * old.makespan_s, 1))
        for name, mishap in MISHAPS.items():
            chance = random.Random(f"{name}/{samples}/{seed}")
            case = mishap((replace(problem, facts=facts), progress), old, chance)
            if case is None:
                continue
            for way, run in _ways(engine, base, old, case, request).items():
                made[name, way].append(_measured(run, old, case[1]))
                print(
                    f"{samples} seed {seed}, {name}, {way}: {made[name, way][-1]}",
                    file=sys.stderr,
                    flush=True,
                )
    return [_row(name, samples, way, every) for (name, way), every in made.items()]


def _row(mishap: str, samples: int, way: str, every: Sequence[Figures | None]) -> Row:
    solved = [figures for figures in every if figures is not None]
    return Row(
        mishap=mishap,
        samples=samples,
        way=way,
        solved=f"{len(solved)}/{len(every)}",
        seconds=median(one.seconds for one in solved) if solved else nan,
        kept=median(one.kept for one in solved) if solved else nan,
        makespan_s=median(one.makespan_s for one in solved) if solved else nan,
    )


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.repair", description=__doc__)
    parser.add_argument("--sizes", nargs="+", type=int, default=[2, 8, 32], help="samples; 2 8 32")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--limit", type=float, default=60.0, help="seconds a plan may take; 60")
    parser.add_argument("--json", action="store_true", help="print one JSON document instead of the table")
    given = parser.parse_args()
    request = PlanningRequest(time_limit_s=given.limit)
    table = [row for size in given.sizes for row in rows(size, given.seeds, request)]
    if given.json:
        print(json.dumps([asdict(row) for row in table], indent=2))
        return
    print("| samples | what happened | way | solved | seconds | kept | makespan |")
    print("|---|---|---|---|---|---|---|")
    for row in table:
        figures = f"{row.seconds:.3f} | {row.kept:.0%} | {row.makespan_s:.1f} s"
        print(f"| {row.samples} | {row.mishap} | {row.way} | {row.solved} | {figures} |")


if __name__ == "__main__":
    main()
