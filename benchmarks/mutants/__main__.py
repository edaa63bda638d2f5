"""How many small defects the tests notice: samples mutants of the product code and runs the tests that execute them.

    uv run --group mutation python -m benchmarks.mutants --sample 200 --seed 1

All tests but those of the page run once without a change, and which of them execute which lines is recorded, which
takes half as long again as the tests do. Each mutant is tried in a copy of the checkout with the tests that execute its
line, at most two minutes' worth of them: those of its room first, then the shortest. What longer ones would notice
counts as survived, so the printed rate is a lower bound. A mutant that no test fails on survives and is printed with
its change. One on which the tests do not end is killed, an endless loop say, provided that they soon end without it.
"""

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue

from benchmarks.mutants.mutation import PACKAGES, ROOT, Mutant, sample
from benchmarks.mutants.reach import Reach
from benchmarks.mutants.trial import copy_checkout, is_killed, record


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawTextHelpFormatter,
        prog="python -m benchmarks.mutants",
    )
    options.add_argument("--sample", type=int, default=200, help="number of mutants")
    options.add_argument("--seed", type=int, default=1)
    options.add_argument(
        "--from", type=int, default=1, dest="first", metavar="N", help="number in the sample to begin at"
    )
    options.add_argument("--jobs", type=int, default=2, help="mutants tried at the same time")
    options.add_argument("--package", choices=PACKAGES, action="append", help="default: all three")
    given = options.parse_args()
    if subprocess.check_output(["git", "status", "--porcelain", *PACKAGES], cwd=ROOT):
        sys.exit("commit what is changed first: the mutants are of the last commit")
    mutants = sample(given.sample, given.seed, given.package or PACKAGES)
    if not 1 <= given.first <= len(mutants):
        options.error(f"--from {given.first}: the sample's mutants are numbered from 1 to {len(mutants)}")
    mutants = mutants[given.first - 1 :]
    survivors: list[Mutant] = []
    with tempfile.TemporaryDirectory() as folder:
        checkouts: SimpleQueue[Path] = SimpleQueue()
        copies = [copy_checkout(Path(folder) / str(job)) for job in range(given.jobs)]
        for copy in copies:
            checkouts.put(copy)
        print("recording which tests execute which lines", flush=True)
        record(Path(folder) / "reach", copies[0], sorted({mutant.path for mutant in mutants}))
        reach = Reach(Path(folder) / "reach", copies[0])
        if not reach.tests:
            sys.exit("no test passes without a mutant; see `pytest`")
        print(f"{reach.tests} tests pass without a mutant", flush=True)
        chosen = [reach.tests_for(mutant) for mutant in mutants]

        def tried(mutant: Mutant, tests: Sequence[str]) -> tuple[bool, str]:
            checkout = checkouts.get()
            try:
                return bool(tests) and is_killed(mutant, tests, checkout), mutant.difference(checkout)
            finally:
                checkouts.put(checkout)

        with ThreadPoolExecutor(given.jobs) as pool:
            found = zip(mutants, chosen, pool.map(tried, mutants, chosen), strict=True)
            for count, (mutant, tests, (killed, difference)) in enumerate(found, given.first):
                print(f"{count:4} {'killed  ' if killed else 'SURVIVED'} {mutant}", flush=True)
                if not killed:
                    survivors.append(mutant)
                    print(f"    {len(tests)} tests execute it\n{difference}", flush=True)
    rate = 1 - len(survivors) / len(mutants)
    print(
        f"\n{len(mutants) - len(survivors)} of {len(mutants)} mutants killed: {rate:.0%} (seed {given.seed})"
    )


if __name__ == "__main__":
    main()
