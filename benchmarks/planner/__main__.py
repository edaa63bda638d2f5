"""Our engine, the other engines and the optimum, side by side: `python -m benchmarks.planner [--quick] [--json]`.

Instances by seed, every run in a process of its own with a warm engine, every plan-net checked again here. An engine
that solved nothing of one size is not asked for the larger ones of that family. A full run takes about two hours.
"""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

from benchmarks.planner.http import proposals
from benchmarks.planner.instances import FAMILIES
from benchmarks.planner.legs import NotModelled
from benchmarks.planner.measure import OURS, Measure, Task, measured
from benchmarks.planner.optimum import optimum
from benchmarks.planner.table import GROWTH_FROM, GROWTH_TO, Row, faults, growth, lines
from planner import load_knowledge_base
from planner.engines.registry import ENGINES

SIZES: Mapping[str, Sequence[int]] = {
    **dict.fromkeys(("store", "mixed", "retrieve"), (1, 2, 4, 8, 16, 32, 64, 128, 256)),
    "paper": (1, 2, 4, 8, 16, 32),
    "blocked": (1, 2),
    "swap": (2, 4),
    "relocation": (2, 4),
    "full": (6, 8),
    "nearly_full": (5,),
    "random": (1, 2, 4, 8),
    "rearranged": (16, 64),
}
QUICK = (1, 2, 4, 16, 64)
EXACT_UP_TO = 8
CARRIED = ("store", "mixed", "retrieve", "paper")
"""The families that the exact model supports."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    families: Sequence[str]
    sizes: Sequence[int]
    engines: Sequence[str]
    seeds: int
    limit_s: float
    effort_s: float | None
    exact_up_to: int


def rows(options: Options) -> list[Row]:
    """Measure everything; reports progress on standard error."""
    made: list[Row] = []
    beaten: set[tuple[str, str]] = set()
    for family in options.families:
        for samples in (size for size in SIZES[family] if size in options.sizes):
            row = Row(family=family, samples=samples)
            for engine in (OURS, *options.engines):
                if (engine, family) in beaten:
                    continue
                effort_s = options.effort_s if engine == OURS else options.limit_s
                # One seed for the others: each takes all of its time.
                for seed in range(options.seeds if engine == OURS else 1):
                    task = Task(
                        engine=engine,
                        family=family,
                        samples=samples,
                        seed=seed,
                        limit_s=options.limit_s,
                        effort_s=effort_s,
                    )
                    row.by_engine.setdefault(engine, []).append(told(measured(task)))
                if engine != OURS and not any(measure.is_solved for measure in row.by_engine[engine]):
                    beaten.add((engine, family))
            if samples <= options.exact_up_to and family in CARRIED:
                row.best = {
                    seed: exact(family, samples, seed, options.limit_s) for seed in range(options.seeds)
                }
            made.append(row)
    return made


def told(measure: Measure) -> Measure:
    task = measure.task
    made = measure.makespan_s
    came = f"{made:.1f} s, first after {measure.first_s:.3f} s" if made is not None else measure.reason[:100]
    what = f"{task.family} {task.samples} seed {task.seed} {task.engine}"
    print(f"{what}: {measure.status} {came} {measure.fault or ''}", file=sys.stderr, flush=True)
    return measure


def exact(family: str, samples: int, seed: int, limit_s: float) -> tuple[float | None, float]:
    """The best makespan the exact model finds and its bound; equal if it is the optimum."""
    base = load_knowledge_base()
    try:
        best = optimum(base, FAMILIES[family](samples, seed).problem(base), time_limit_s=2 * limit_s)
    except NotModelled as error:
        print(f"{family} {samples} seed {seed}: no optimum: {error}", file=sys.stderr, flush=True)
        return None, 0.0
    made = f"{best.makespan_s:.1f}" if best.makespan_s is not None else "none"
    said = "optimum" if best.is_proven else f"bound {best.bound_s:.1f}, schedule {made}"
    print(f"{family} {samples} seed {seed} exact: {said} {best.bound_s:.1f} s", file=sys.stderr, flush=True)
    return best.makespan_s, best.bound_s


def options_from(words: Sequence[str] | None = None) -> tuple[Options, argparse.Namespace]:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.planner", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer sizes, one seed, ten seconds an engine")
    parser.add_argument("--json", action="store_true", help="print one JSON document instead of the table")
    parser.add_argument("--families", nargs="+", choices=FAMILIES, default=list(FAMILIES))
    parser.add_argument("--sizes", nargs="+", type=int)
    parser.add_argument("--engines", nargs="*", choices=[name for name in ENGINES if name != OURS])
    parser.add_argument("--seeds", type=int)
    parser.add_argument("--limit", type=float, help="seconds an engine may take; 60")
    parser.add_argument("--effort", type=float, help="seconds ours may improve (default: by size)")
    parser.add_argument("--exact", type=int, help="samples up to which the optimum is proven; 8, 4 if quick")
    parser.add_argument("--no-http", action="store_true", help="leave the service out")
    given = parser.parse_args(words)
    quick = given.quick
    rivals = [name for name in ENGINES if name != OURS]
    return Options(
        families=given.families,
        sizes=given.sizes
        or (QUICK if quick else sorted({size for sizes in SIZES.values() for size in sizes})),
        engines=given.engines if given.engines is not None else rivals,
        seeds=given.seeds or (1 if quick else 3),
        limit_s=given.limit or (10.0 if quick else 60.0),
        effort_s=given.effort,
        exact_up_to=given.exact if given.exact is not None else (4 if quick else EXACT_UP_TO),
    ), given


def main() -> int:
    """Returns 1 if any plan-net of ours is wrong or missing."""
    options, given = options_from()
    table = rows(options)
    wrong = [line for row in table for line in faults(row.by_engine)]
    http = {} if given.no_http else proposals(runs=10)
    if given.json:
        body = {"rows": [asdict(row) for row in table], "http_s": http, "faults": wrong}
        body["growth"] = {family: growth(table, family) for family in options.families}
        print(json.dumps(body, indent=2))
        return bool(wrong)
    print("\n".join(lines(table, options.engines)))
    for family in options.families:
        if (exponent := growth(table, family)) is not None:
            print(f"first plan of {family}, {GROWTH_FROM} to {GROWTH_TO} samples: time ~ N^{exponent:.2f}")
    for goals, seconds in http.items():
        print(f"over HTTP, {goals} goals at paper size: proposed in {1000 * seconds:.0f} ms (median)")
    print("\n".join(wrong or ["every plan-net is valid"]))
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
