"""How missions cope with doors, hatches and lifts that fail: `python -m benchmarks.peripherals [--seeds 20]`.

The whole service and the simulated robots of `guarded_store` in one process, at up to 20 times real time; an operator
approves the plan and declares a silent peripheral lost after two minutes. Prints a line a case: how often the mission
came true (completed, and the goal is true in the world), ended with a reason, waits for the operator, is wrong
(completed, the goal is false) or did not end (silent); how often a working door was left open, how often the broken one
is out of service in the end; median and longest world seconds.
"""

import argparse
import statistics
from collections import Counter
from collections.abc import Sequence

from app.composition import make_engine
from app.planning.pool.pool import PlanningWorker
from benchmarks.peripherals.trial import CASES, OUTCOMES, Case, Outcome, Trial


def line(case: Case, outcomes: Sequence[Outcome]) -> str:
    counts = Counter(one.how for one in outcomes)
    spans = [one.took_s for one in outcomes]
    left_open = sum(bool(one.left_open) for one in outcomes)
    resting = sum(case.peripheral in one.out_of_service for one in outcomes)
    how = " | ".join(str(counts[how]) for how in OUTCOMES)
    return f"| {case} | {how} | {left_open} | {resting} | {statistics.median(spans):.0f} | {max(spans):.0f} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--case", default="", help="only cases whose name contains these words")
    parser.add_argument("--words", action="store_true", help="also what was said")
    options = parser.parse_args()
    worker = PlanningWorker(make_engine)
    worker.warm_up().result()
    print(f"| case | {' | '.join(OUTCOMES)} | left open | out of service | median s | longest s |")
    print(f"|---{'|---' * (len(OUTCOMES) + 4)}|", flush=True)
    try:
        for case in CASES:
            if options.case not in str(case):
                continue
            seeds = range(options.first, options.first + options.seeds)
            outcomes = [Trial(case, seed).run(worker) for seed in seeds]
            print(line(case, outcomes), flush=True)
            for one in outcomes if options.words else ():
                print(
                    f"    {one.how} by {', '.join(one.ways)} after {', '.join(one.measures) or 'no attempt'}"
                )
                print(f"    {one.reason}", flush=True)
    finally:
        worker.close()


if __name__ == "__main__":
    main()
