"""Our planner beside others on eight planning domains: `python -m benchmarks.domains [--domains …] [--limit 10]`.

Each planner has each problem to itself, in a process of its own, and gives better plans until the limit. The first and
the best plan are validated by VAL or, if it is not installed, by unified-planning. Fast Downward takes no durations.
`partial-order`, a planner of UCPOP's kind, is run if it is named; it does for `--sizes 2 3`.
"""

import argparse
import json
import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import asdict

from benchmarks.domains.catalogue import DOMAINS, FIRST_SEED, SIZES
from benchmarks.domains.judge import val_binary
from benchmarks.domains.measure import Measure, Task, measured
from benchmarks.domains.model import Form
from benchmarks.domains.planners import OURS, PARTIAL_ORDER, PLANNERS
from benchmarks.domains.table import by_domain, faults, name, summary

OTHERS = [name for name in PLANNERS if name != PARTIAL_ORDER]
"""The planners that are run unless told otherwise."""


def tasks(given: argparse.Namespace) -> list[Task]:
    """All runs, the planners in turn on each problem."""
    return [
        Task(planner=planner, domain=domain, form=form, size=size, seed=seed, limit_s=given.limit)
        for domain in given.domains
        for form in map(Form, given.forms)
        for size in given.sizes or SIZES[domain]
        for seed in range(FIRST_SEED, FIRST_SEED + given.seeds)
        for planner in given.planners
        if form in PLANNERS[planner].forms
    ]


def told(measure: Measure) -> Measure:
    if measure.best is None:
        came = measure.status
    else:
        came = (
            f"{measure.first:g} after {measure.first_s:.2f} s, {measure.best:g} after {measure.best_s:.2f} s"
        )
    line = f"{name(measure.task)}: {came}, {measure.cpu_s:.1f} CPU-s {measure.fault or ''}"
    print(line, file=sys.stderr, flush=True)
    return measure


def options(words: Sequence[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.domains", description=__doc__)
    parser.add_argument("--domains", nargs="+", choices=DOMAINS, default=list(DOMAINS))
    parser.add_argument("--forms", nargs="+", choices=list(Form), default=list(Form))
    parser.add_argument("--planners", nargs="+", choices=PLANNERS, default=OTHERS)
    parser.add_argument(
        "--sizes", nargs="+", type=int, help="sizes of all domains (default: three, by domain)"
    )
    parser.add_argument("--seeds", type=int, default=1, help=f"problems of a size, from seed {FIRST_SEED}")
    parser.add_argument("--limit", type=float, default=10.0, help="seconds for each planner and problem")
    parser.add_argument("--json", action="store_true", help="print every run instead of the tables")
    return parser.parse_args(words)


def main() -> int:
    """Returns 1 if a plan of ours is wrong."""
    given = options()
    measures = [told(measured(task)) for task in tasks(given)]
    if given.json:
        print(json.dumps([asdict(one) for one in measures], indent=2))
    else:
        judge = "VAL" if val_binary() else "unified-planning's validator"
        print(
            f"{len({(m.task.domain, m.task.form, m.task.size, m.task.seed) for m in measures})} problems, seeds "
            f"{FIRST_SEED} to {FIRST_SEED + given.seeds - 1}, {given.limit:g} s each; {os.cpu_count()} cores, "
            f"{platform.machine()}, load {os.getloadavg()[1]:.1f}; plans judged by {judge}.",
            "",
            *summary(measures, given.planners),
            "",
            *by_domain(measures, given.planners),
            sep="\n",
        )
    wrong = faults(measures)
    print("\n".join(wrong or ["every plan is valid"]), file=sys.stderr)
    return int(any(one.fault for one in measures if one.task.planner == OURS))


if __name__ == "__main__":
    sys.exit(main())
