"""What rule files that take the place of code do: `python -m benchmarks.rule_files regrip [--seeds 10] [--words]`.

Each case is run by the software alone, with the rule file that ships, and with a file of its name that is empty. A line
has the trials in which the goal was reached, those that one reported as failed, any others, and the seconds from the
mishap to the end.
"""

import argparse
from collections import Counter
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from benchmarks.mishaps.acts import (
    SENSOR_FAULTS,
    hidden,
    jaws_fail,
    jaws_mended,
    knocked,
    mended,
    sensor,
    shown,
)
from benchmarks.mishaps.cases import Case
from benchmarks.mishaps.trial import OUTCOMES, Outcome, Trial
from benchmarks.mishaps.undertakings import errand
from robots.world.rule_files import shipped_rules
from sim.trials.parallel import run_parallel

VARIANTS = ("software", "rules", "empty")
LASTS_S = 15.0
"""A passing fault, longer than a packet takes to notice that it gets nowhere."""


def regrip_cases() -> Sequence[Case]:
    barrier = sensor(SENSOR_FAULTS["gripper frozen"])
    return (
        Case(name="jaws jammed 15 s", during="DOCK", do=jaws_fail, undo=jaws_mended, undo_s=LASTS_S),
        Case(name="jaws jammed 25 s", during="DOCK", do=jaws_fail, undo=jaws_mended, undo_s=25.0),
        Case(name="jaws jammed for good", during="DOCK", do=jaws_fail),
        Case(name="barrier frozen 15 s", during="DOCK", do=barrier, undo=mended, undo_s=LASTS_S),
        Case(name="barrier frozen for good", during="DOCK", do=barrier),
        Case(name="sample knocked 0.15 m", during="DOCK", do=knocked(0.15), after_s=2.0),
    )


def search_cases() -> Sequence[Case]:
    work = errand()
    return (
        Case(name="sample knocked 1 m", during="NAVIGATE", do=knocked(1.0)),
        Case(name="sample hidden for good", during="NAVIGATE", do=hidden(work.sample)),
        Case(
            name="sample hidden 10 s",
            during="DOCK",
            do=hidden(work.sample),
            undo=shown(work.sample),
            undo_s=10.0,
        ),
    )


CASES: Mapping[str, Callable[[], Sequence[Case]]] = {"regrip": regrip_cases, "search": search_cases}


def rules_of(name: str, variant: str) -> Mapping[str, str] | None:
    if variant == "software":
        return None
    return {
        name: shipped_rules()[name].read_text(encoding="utf-8") if variant == "rules" else f"AGENT {name};"
    }


def run(order: tuple[str, int, str, int]) -> Outcome:
    """One trial. :param order: the rule file, the case's number, the variant, the seed."""
    name, number, variant, seed = order
    return Trial(CASES[name]()[number], seed, rules_of(name, variant)).run()


def line(case: Case, variant: str, outcomes: Sequence[Outcome]) -> str:
    counts = Counter(one.how for one in outcomes)
    spans_s = [one.took_s for one in outcomes if one.took_s is not None]
    how = "  ".join(f"{counts[how]:9d}" for how in OUTCOMES)
    longest = f"{np.median(spans_s):6.1f} {max(spans_s):6.1f}" if spans_s else "  no mishap"
    return f"{case!s:36}{variant:10}{how}  {longest}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=sorted(CASES))
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--case", default="", help="only cases whose name contains these words")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--words", action="store_true", help="also what was reported")
    options = parser.parse_args()
    cases = CASES[options.name]()
    orders = [
        (options.name, number, variant, seed)
        for number, case in enumerate(cases)
        if options.case in str(case)
        for variant in VARIANTS
        for seed in range(options.seeds)
    ]
    print(f"{'':46}{'  '.join(f'{how:>9}' for how in OUTCOMES)}  median longest s")
    found: list[Outcome] = []
    for (_, number, variant, _), outcome in zip(
        orders, run_parallel(run, orders, workers=options.jobs), strict=True
    ):
        found.append(outcome)
        if len(found) == options.seeds:
            print(line(cases[number], variant, found), flush=True)
            if options.words:
                for words, count in Counter(one.words for one in found if one.words).most_common(3):
                    print(f"      {count} x {words}")
            found = []


if __name__ == "__main__":
    main()
