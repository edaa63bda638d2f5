"""The table of what Macta costs: `python -m benchmarks.costs [ROWS …] [--runs 5]`.

CPU seconds are those of all processes of a command. `before` is what was measured before the targets were set, on two
cores. PostgreSQL is the one at SERVER. `size` downloads what an installation needs and is left out by default.
"""

import argparse
from collections.abc import Callable, Iterator, Mapping

from benchmarks.costs.commands import calls, demo, size
from benchmarks.costs.service import goals, idle, posts, read, start
from benchmarks.costs.simulation import simulation
from benchmarks.costs.table import HEADING, Row

ROWS: Mapping[str, Callable[[int], Iterator[Row]]] = {
    "demo": demo,
    "calls": calls,
    "start": start,
    "idle": idle,
    "goals": goals,
    "posts": posts,
    "reads": read,
    "simulation": simulation,
    "size": size,
}
DEFAULT = [name for name in ROWS if name != "size"]


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("rows", nargs="*", metavar="ROWS", default=DEFAULT, help=" ".join(ROWS))
    options.add_argument("--runs", type=int, default=5)
    given = options.parse_args()
    if unknown := set(given.rows) - ROWS.keys():
        options.error(f"no rows {', '.join(sorted(unknown))}; there are {', '.join(ROWS)}")
    print(HEADING)
    for name in given.rows:
        for row in ROWS[name](given.runs):
            print(row, flush=True)


if __name__ == "__main__":
    main()
