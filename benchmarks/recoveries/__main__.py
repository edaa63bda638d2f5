"""How missions cope with mishaps: `python -m benchmarks.recoveries [--seeds 3] [--case WORDS]`.

The whole service and simulated robots in one process, at up to 20 times real time; an operator approves the plan,
declares robots lost that stay silent for 100 s, and approves repairs (with `--policy ask`). Each case does something to
a robot, a sample or the way while a packet runs. Prints a line a case: how often the mission came true (completed, and
the goal is true in the world), ended with a reason, waits for the operator, is wrong (completed, the goal is false) or
did not end (silent); how often the final belief about the mission's sample is false, or robots are still at work for a
mission that has ended; median and longest seconds from the mishap to the end.
"""

import argparse
import statistics
import time
from collections import Counter
from collections.abc import Iterator, Sequence

from app.composition import make_engine
from app.planning.pool.pool import PlanningWorker
from benchmarks.recoveries.cases import Case, cases
from benchmarks.recoveries.trial import OUTCOMES, Outcome, Trial


def line(case: Case, outcomes: Sequence[Outcome]) -> str:
    counts = Counter(one.how for one in outcomes)
    spans = [one.took_s for one in outcomes if one.took_s is not None]
    false = sum(any(case.of.sample in belief for belief in one.beliefs) for one in outcomes)
    unsafe = sum(bool(one.unsafe) for one in outcomes)
    took = f"{statistics.median(spans):.0f} | {max(spans):.0f}" if spans else "no mishap |"
    how = " | ".join(str(counts[how]) for how in OUTCOMES)
    return f"| {case} | {how} | {false} | {unsafe} | {took} |"


def said(outcomes: Sequence[Outcome]) -> Iterator[str]:
    for seed, one in enumerate(outcomes):
        yield f"    {seed}: {one.state} after {', '.join(one.measures) or 'no attempt'}"
        for name in ("lost", "beliefs", "unsafe"):
            if words := getattr(one, name):
                yield f"       {name}: {'; '.join(words)}"
        yield f"       {one.reason}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--case", default="", help="only cases whose name contains these words")
    parser.add_argument("--policy", choices=("auto", "ask", "never"), default="auto")
    parser.add_argument("--words", action="store_true", help="also what was said")
    options = parser.parse_args()
    worker = PlanningWorker(make_engine)
    worker.warm_up().result()
    begun_s, total = time.monotonic(), Counter[str]()
    print(f"| case | {' | '.join(OUTCOMES)} | false belief | unsafe | median s | longest s |")
    print(f"|---{'|---' * (len(OUTCOMES) + 4)}|", flush=True)
    try:
        for case in cases():
            if options.case not in str(case):
                continue
            seeds = range(options.first, options.first + options.seeds)
            outcomes = [Trial(case, seed, policy=options.policy).run(worker) for seed in seeds]
            total.update(one.how for one in outcomes)
            print(line(case, outcomes), *(said(outcomes) if options.words else ()), sep="\n", flush=True)
    finally:
        worker.close()
    print(
        f"| all | {' | '.join(str(total[how]) for how in OUTCOMES)} | in {time.monotonic() - begun_s:.0f} s"
    )


if __name__ == "__main__":
    main()
