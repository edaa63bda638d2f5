"""A short set of measurements on two revisions in turn: `python -m benchmarks.regression BASE [HEAD]`.

Each revision gets a work tree, an environment and a cache of compiled code of its own. The revisions take turns, after
one turn that is not counted. Prints the ratio of HEAD to BASE of each turn, median and spread: the machine's load acts
on both. Ratios below 1 are better for seconds, above 1 for figures a second. PostgreSQL runs at SERVER.
"""

import argparse
import re
import shutil
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from benchmarks.databases import SERVER
from benchmarks.processes import environment, run

PROJECT = Path(__file__).parents[1]
SYNC = ("uv", "sync", "--quiet", "--all-extras", "--group", "dev", "--compile-bytecode")


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """A command of the project's environment: what it prints, or without `prints` its CPU seconds.

    :param prints: a pattern of its output, with a group for each figure.
    """

    names: Sequence[str]
    command: Sequence[str]
    prints: str = ""

    def take(self, tree: "Tree") -> list[float]:
        """:raises RuntimeError: if it fails or does not print the figures."""
        command = (str(tree.folder / ".venv/bin" / self.command[0]), *self.command[1:])
        used = run(command, environment=tree.environment, folder=tree.folder)
        if not self.prints:
            return [used.cpu_s]
        found = re.findall(self.prints, used.said)
        figures = [
            float(one) for groups in found for one in ((groups,) if isinstance(groups, str) else groups)
        ]
        if len(figures) != len(self.names):
            raise RuntimeError(f"{' '.join(self.command)} printed {used.said[-1000:]}")
        return figures


SHORT_SET = (
    Measurement(names=("macta --help, CPU-s",), command=("macta", "--help")),
    Measurement(names=("demo, CPU-s",), command=("macta", "demo", "--flat-out")),
    Measurement(
        names=("planner, 8 samples, CPU-s",),
        command=(
            *("python", "-m", "benchmarks.planner", "--families", "store", "mixed", "--sizes", "8"),
            *("--engines", "--seeds", "1", "--exact", "0", "--no-http"),
        ),
    ),
    Measurement(
        names=tuple(
            f"{what} a second, {database}"
            for database in ("SQLite", "PostgreSQL")
            for what in ("goals proposed", "missions to their end")
        ),
        command=("python", "-m", "benchmarks.throughput", "2", SERVER),
        prints=r"([\d.]+) goals a second proposed, ([\d.]+) finished",
    ),
    Measurement(
        names=("simulation, 16 robots, CPU-s a second of the world",),
        command=("python", "-m", "benchmarks.stack", "16"),
        prints=r"(?m)^ +16 +\d+ +[\d.]+ +[\d.]+ +([\d.]+)",
    ),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Tree:
    """A revision's work tree, and the environment variables of its commands."""

    folder: Path
    environment: Mapping[str, str]


@contextmanager
def tree_of(revision: str) -> Iterator[Tree]:
    """A work tree of the revision with its environment."""
    with TemporaryDirectory() as place:
        folder = Path(place) / "tree"
        git = ("git", "-C", str(PROJECT), "worktree")
        subprocess.run([*git, "add", "--quiet", "--detach", str(folder), revision], check=True)
        try:
            if (lock := PROJECT / "uv.lock").exists():
                shutil.copy(lock, folder)
            run(SYNC, environment=environment(), folder=folder)
            yield Tree(folder=folder, environment=environment(Path(place) / "cache"))
        finally:
            subprocess.run([*git, "remove", "--force", str(folder)], check=True)


def compare(measurement: Measurement, base: Tree, head: Tree, turns: int) -> Iterator[str]:
    """Take turns; a line for each figure."""
    for tree in (base, head):
        measurement.take(tree)
    found = [(measurement.take(base), measurement.take(head)) for _ in range(turns)]
    for index, name in enumerate(measurement.names):
        before, after = ([both[side][index] for both in found] for side in (0, 1))
        ratios = [new / old for old, new in zip(before, after, strict=True)]
        yield (
            f"{name:52s} {median(before):9.2f} {median(after):9.2f}"
            f"  {median(ratios):5.2f}  {min(ratios):.2f} to {max(ratios):.2f}"
        )


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("base", metavar="BASE")
    options.add_argument("head", metavar="HEAD", nargs="?", default="HEAD")
    options.add_argument("--turns", type=int, default=5)
    options.add_argument("--only", default="", help="measurements whose command contains this")
    given = options.parse_args()
    with tree_of(given.base) as base, tree_of(given.head) as head:
        print(f"{'':52s} {'BASE':>9s} {'HEAD':>9s}  ratio  of the turns")
        for measurement in SHORT_SET:
            if given.only in " ".join(measurement.command):
                for line in compare(measurement, base, head, given.turns):
                    print(line, flush=True)


if __name__ == "__main__":
    main()
