"""How robots cope with mishaps: `python -m benchmarks.mishaps [--seeds 10] [--case WORDS]`.

A yard robot of the sample store carries a sample from a door to an interchange, or Fred and Ginger carry a long one
from the quarry to the lander between them; each case does something to a robot, to the sample or to a beacon while a
packet runs. Prints a line a case: how often the robots recovered (goal reached in the world itself), one reported a
failure, all finished without having reached the goal (wrong), or one did not end (silent), and the seconds from the
mishap to the last one's end. With --words also what they reported.
"""

import argparse
import time
from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np

from benchmarks.mishaps.cases import Case, cases
from benchmarks.mishaps.trial import OUTCOMES, Outcome, run
from sim.trials.parallel import run_parallel


def line(case: Case, outcomes: Sequence[Outcome]) -> str:
    counts = Counter(one.how for one in outcomes)
    spans = [one.took_s for one in outcomes if one.took_s is not None]
    how = "  ".join(f"{counts[how]:9d}" for how in OUTCOMES)
    longest = f"{np.median(spans):6.1f} {max(spans):6.1f}" if spans else "  no mishap"
    walled = f"  IN A WALL {sum(one.walled for one in outcomes)}" if any(o.walled for o in outcomes) else ""
    return f"{case!s:42}{how}  {longest}{walled}"


def said(outcomes: Sequence[Outcome]) -> Iterable[str]:
    for words, count in Counter(one.words for one in outcomes if one.words).most_common():
        yield f"      {count} x {words}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--case", default="", help="only cases whose name contains these words")
    parser.add_argument("--words", action="store_true", help="also what was reported")
    options = parser.parse_args()
    chosen = [(number, case) for number, case in enumerate(cases()) if options.case in str(case)]
    orders = [(number, seed) for number, _ in chosen for seed in range(options.seeds)]
    began_s, found = time.monotonic(), dict[int, list[Outcome]]()
    total: Counter[str] = Counter()
    print(f"{'':42}{'  '.join(f'{how:>9}' for how in OUTCOMES)}  median longest s")
    for (number, _), outcome in zip(orders, run_parallel(run, orders, workers=options.jobs), strict=True):
        found.setdefault(number, []).append(outcome)
        if len(found[number]) == options.seeds:
            print(line(dict(chosen)[number], found[number]), flush=True)
            total.update(one.how for one in found[number])
            for words in said(found[number]) if options.words else ():
                print(words)
    print(f"{'all':42}{'  '.join(f'{total[how]:9d}' for how in OUTCOMES)}")
    print(f"in {time.monotonic() - began_s:.0f} s")


if __name__ == "__main__":
    main()
