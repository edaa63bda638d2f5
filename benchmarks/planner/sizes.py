"""How near to the optimum the planner comes at every size, and how long it takes: `python -m benchmarks.planner.sizes`.

Random worlds with 1 to 8 goals, 16 to 256 samples, and stores in which samples are in each other's way, with our engine
and its default effort. Its seeds begin at 1000: the search was tuned with smaller ones. All runs share a process; every
plan-net is checked again by `benchmarks.planner.check`.

The optimum lies between the proven bound and the best known plan. `--search 600` looks for a better plan for ten
minutes where the default's is more than 1 % over the bound.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from statistics import median

from benchmarks.planner.measure import OURS, Measure, Task, run
from planner import load_knowledge_base, warm_up
from planner.engines.registry import engine_named

FIRST_SEED = 1000
PROVEN = 0.01
"""No better plan is looked for within this share of the bound."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Instances of one family and size."""

    said: str
    family: str
    samples: int
    seeds: int


ROWS = (
    *(Row(said=f"random worlds, goals: {n}", family="random", samples=n, seeds=30) for n in (1, 2, 4, 8)),
    *(Row(said=f"{name}, 16", family=name, samples=16, seeds=3) for name in ("store", "mixed")),
    *(Row(said=f"{name}, 64", family=name, samples=64, seeds=3) for name in ("store", "mixed")),
    *(Row(said=f"{name}, 256", family=name, samples=256, seeds=1) for name in ("store", "mixed")),
    Row(said="64, 32 of them rearranged", family="rearranged", samples=64, seeds=3),
    Row(said="5 in 6 bays, all move", family="nearly_full", samples=5, seeds=20),
    Row(said="6 in 6 bays, all move", family="full", samples=6, seeds=20),
)
HEAD = (
    *("instances", "solved", "over bound: median", "worst", "over best known: median", "worst"),
    *("first plan s: median", "worst"),
    *("CPU s: median", "worst", "seconds: median", "worst"),
)


def line(said: str, measures: Sequence[Measure], searched: Sequence[Measure] | None = None) -> list[str]:
    """The cells of one row; the ratios leave out what was not solved or has no bound.

    :param searched: the long searches for some of the instances; None: there were none.
    """
    solved = [one for one in measures if one.is_solved]
    known = {one.task.seed: one.makespan_s for one in searched or () if one.is_solved}
    best = [
        one.makespan_s / min(one.makespan_s, known.get(one.task.seed) or one.makespan_s) - 1
        for one in solved
        if searched is not None and one.makespan_s and (one.task.seed in known or is_proven(one))
    ]
    over = [one.makespan_s / one.bound_s - 1 for one in solved if one.makespan_s and one.bound_s]
    firsts = [one.first_s for one in solved if one.first_s is not None]
    cpu = [one.cpu_s for one in measures if one.cpu_s is not None]
    finals = [one.final_s for one in measures if one.final_s is not None]
    return [
        said,
        f"{len(solved)}/{len(measures)}",
        *_median_and_worst(over, lambda share: f"{100 * share:.1f} %"),
        *_median_and_worst(best, lambda share: f"{100 * share:.1f} %"),
        *_median_and_worst(firsts, lambda seconds: f"{seconds:.2f}"),
        *_median_and_worst(cpu, lambda seconds: f"{seconds:.1f}"),
        *_median_and_worst(finals, lambda seconds: f"{seconds:.1f}"),
    ]


def longer(task: Task, effort_s: float) -> Task:
    """The task with so many more seconds to improve its plan."""
    return replace(task, effort_s=effort_s, limit_s=task.limit_s + effort_s)


def is_proven(measure: Measure) -> bool:
    """True if the plan is so near to the bound that no better one is looked for."""
    if not measure.is_solved or measure.makespan_s is None or measure.bound_s is None:
        return False
    return measure.makespan_s <= (1 + PROVEN) * measure.bound_s


def _median_and_worst(values: Sequence[float], told: Callable[[float], str]) -> tuple[str, str]:
    return (told(median(values)), told(max(values))) if values else ("–", "–")


def main(words: Sequence[str] | None = None) -> int:
    """Returns 1 if a plan-net is missing or wrong."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.planner.sizes", description=__doc__)
    parser.add_argument("--families", nargs="+", choices=sorted({row.family for row in ROWS}))
    parser.add_argument("--sizes", nargs="+", type=int)
    parser.add_argument("--seeds", type=int, help="instances a row, at most (default: by row)")
    parser.add_argument("--effort", type=float, help="seconds to improve a plan (default: by size)")
    parser.add_argument("--limit", type=float, default=60.0, help="seconds for a plan; 60")
    parser.add_argument("--search", type=float, help="seconds to look for a better plan than the default's")
    given = parser.parse_args(words)
    knowledge_base = load_knowledge_base()
    engine = engine_named(OURS, knowledge_base)
    warm_up(engine)
    wrong: list[str] = []
    print("| " + " | ".join(HEAD) + " |\n|" + "---|" * len(HEAD))
    for row in ROWS:
        if row.family not in (given.families or [row.family]) or row.samples not in (
            given.sizes or [row.samples]
        ):
            continue
        measures = [
            run(
                Task(
                    engine=OURS,
                    family=row.family,
                    samples=row.samples,
                    seed=seed,
                    limit_s=given.limit,
                    effort_s=given.effort,
                ),
                engine,
                knowledge_base,
            )
            for seed in range(FIRST_SEED, FIRST_SEED + min(row.seeds, given.seeds or row.seeds))
        ]
        searched = None
        if given.search:
            tasks = [longer(one.task, given.search) for one in measures if not is_proven(one)]
            searched = [run(task, engine, knowledge_base) for task in tasks]
        print("| " + " | ".join(line(row.said, measures, searched)) + " |", flush=True)
        wrong += [
            f"{row.said}, seed {one.task.seed}: {one.fault or f'{one.status}: {one.reason}'}"
            for one in measures
            if not one.is_solved
        ]
    print("\n".join(wrong), file=sys.stderr)
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
