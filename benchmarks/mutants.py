"""How many small defects the tests notice: samples mutants of the product code and runs the tests that reach them.

    uv run --group mutation python -m benchmarks.mutants --sample 200 --seed 1

Cosmic Ray makes the mutants: one operator, comparison, boolean, number, loop, decorator or exception is changed in one
place. Annotations, decorators and constants on a module's top level (limits and waiting times that are chosen, not
derived) are left as they are. Each mutant is tried in a copy of the checkout, first with the test files that import the
module most directly, then with the package's others that reach it; end-to-end scenarios are left out, so the printed
rate is a lower bound. A mutant that no test fails on survives and is printed with its change. One on which the nearest
test files do not end is killed, an endless loop say, provided that they soon end without the change; where only the
many others do not end in time, it counts as survived, for they may just be many.
"""

import argparse
import ast
import compileall
import os
import random
import signal
import subprocess
import sys
import tempfile
from collections import defaultdict, deque
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from difflib import unified_diff
from functools import cache
from pathlib import Path
from py_compile import PycInvalidationMode
from queue import SimpleQueue

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).parent.parent
PACKAGES = ("planner", "robots", "app")
LEFT_OUT = ("VariableInserter", "VariableReplacer", "NoOp", "Is_Eq", "IsNot_NotEq")
"""Operators that need settings, or change nothing: what is compared by identity is None or of an enumeration."""
NEAREST = 6
"""Test files that a mutant is tried with first."""
LIMIT_S = 300.0
"""Longest run of the nearest test files, and of the others."""
SOON_S = 100.0
"""Longest run of the nearest test files without the change, if that they do not end with it is to count."""
COMPILE = """
from robots.kernels import install
install()
from robots.compilation import compile_once
from app.planning.pool.work import PLANNER
from sim.process.first_calls import SIMULATION
for group in (SIMULATION, PLANNER):
    compile_once(group, print)
"""
Position = tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Mutant:
    """The `occurrence`-th place in a module where an operator applies."""

    path: Path
    operator: str
    occurrence: int
    at: Position

    def __str__(self) -> str:
        return f"{self.path}:{self.at[0]} {self.operator.partition('/')[2]}"

    def code(self, checkout: Path) -> str | None:
        """The module's source with the change; None if the operator makes none there."""
        source = (checkout / self.path).read_text()
        try:
            changed = mutate_code(source, get_operator(self.operator)(), self.occurrence)
        except AttributeError:  # Cosmic Ray replaces no dotted name of an exception
            return None
        return None if changed in (None, source) else str(changed)

    def difference(self, checkout: Path) -> str:
        before = (checkout / self.path).read_text().splitlines()
        lines = list(unified_diff(before, (self.code(checkout) or "").splitlines(), lineterm="", n=0))
        return "\n".join(f"    {line}" for line in lines[3:])


def tracked(*patterns: str) -> list[Path]:
    listed = subprocess.check_output(["git", "ls-files", *patterns], text=True, cwd=ROOT)
    return [Path(line) for line in listed.splitlines()]


def mutants_of(path: Path) -> Iterator[Mutant]:
    """Every mutant of a module but for those that are left out."""
    source = (ROOT / path).read_text()
    untouched = list(_untouched(ast.parse(source)))
    nodes = list(ast_nodes(get_ast(source)))
    for name in operator_names():
        if any(word in name for word in LEFT_OUT):
            continue
        operator, occurrence = get_operator(name)(), 0
        for node in nodes:
            for start, _ in operator.mutation_positions(node):
                if not any(first <= tuple(start) <= last for first, last in untouched):
                    yield Mutant(path=path, operator=name, occurrence=occurrence, at=tuple(start))
                occurrence += 1


def _untouched(tree: ast.Module) -> Iterator[tuple[Position, Position]]:
    """Spans of annotations, decorators and a module's constants."""
    for node in ast.walk(tree):
        if isinstance(node, ast.AnnAssign | ast.arg) and node.annotation is not None:
            yield _span(node.annotation)
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.returns is not None:
            yield _span(node.returns)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            for decorator in node.decorator_list:
                yield (decorator.lineno, 0), _span(decorator)[1]
    for statement in tree.body:
        if isinstance(statement, ast.Assign | ast.AnnAssign):
            yield _span(statement)


def _span(node: ast.expr | ast.stmt) -> tuple[Position, Position]:
    return (node.lineno, node.col_offset), (node.end_lineno or node.lineno, node.end_col_offset or 0)


def sample(count: int, seed: int, packages: Sequence[str]) -> list[Mutant]:
    """Mutants drawn place by place, so that an operator with many replacements counts no more than one with few."""
    places: dict[tuple[Path, Position], list[Mutant]] = defaultdict(list)
    for path in tracked(*(f"{package}/*.py" for package in packages)):
        if "migrations" not in path.parts:
            for mutant in mutants_of(path):
                places[path, mutant.at].append(mutant)
    dice = random.Random(seed)
    drawn = dice.sample(sorted(places), k=len(places))
    found: list[Mutant] = []
    for place in drawn:
        mutant = dice.choice(places[place])
        if mutant.code(ROOT) is not None:
            found.append(mutant)
        if len(found) == count:
            break
    return found


@cache
def imports(path: Path) -> frozenset[Path]:
    """The files of the checkout that a file imports."""
    found: set[Path] = set()
    for node in ast.walk(ast.parse((ROOT / path).read_text())):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        for name in names:
            module = Path(*name.split("."))
            found |= {p for p in (module.with_suffix(".py"), module / "__init__.py") if (ROOT / p).is_file()}
    return frozenset(found)


@cache
def distances(test: Path) -> dict[Path, int]:
    """How many imports lead from a test file to each file that it reaches; its folders' conftest files are near."""
    near = [folder / "conftest.py" for folder in test.parents if (ROOT / folder / "conftest.py").is_file()]
    known = {test: 0}
    queue = deque([test, *near])
    known |= dict.fromkeys(near, 1)
    while queue:
        path = queue.popleft()
        for target in imports(path):
            if target not in known:
                known[target] = known[path] + 1
                queue.append(target)
    return known


def tests_for(path: Path) -> list[Path]:
    """The test files of the package that reach the module, the nearest first.

    Of those that are as near, those that name it most often: all tests of the API import the same.
    """
    tests = tracked(f"tests/{path.parts[0]}/*test_*.py")
    reach = [
        (distances(test)[path], _kinship(path, test) > 0, -_mentions(path, test), _kinship(path, test), test)
        for test in tests
        if path in distances(test)
    ]
    return [test for *_, test in sorted(reach)]


def _mentions(path: Path, test: Path) -> int:
    """How often the test file has the module's name, in words or as one."""
    text = (ROOT / test).read_text().lower().replace(" ", "_")
    return text.count(path.stem.removesuffix("s"))


def _kinship(path: Path, test: Path) -> int:
    """0 for the test file that mirrors the module, else less the more folders they share."""
    if test.stem == f"test_{path.stem}":
        return 0
    shared = sum(one == other for one, other in zip(path.parts[1:-1], test.parts[2:-1], strict=False))
    return 10 - shared


def is_killed(mutant: Mutant, checkout: Path, files: int | None = None) -> bool:
    """True if a test fails on the mutant, or the nearest do not end but soon end without it.

    :param files: how many of the test files that reach it are tried, the nearest first; None for all.
    """
    place = checkout / mutant.path
    original = place.read_text()
    place.write_text(mutant.code(checkout) or original)
    try:
        tests = tests_for(mutant.path)[:files]
        if not tests:
            return False
        nearest = _fails(tests[:NEAREST], checkout)
        if nearest is None:
            place.write_text(original)
            return _fails(tests[:NEAREST], checkout, SOON_S) is False
        return nearest or (len(tests) > NEAREST and _fails(tests[NEAREST:], checkout) is True)
    finally:
        place.write_text(original)


def _fails(tests: Sequence[Path | str], checkout: Path, limit_s: float = LIMIT_S) -> bool | None:
    """True if a test fails, None if they do not end in time."""
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-x",
        "-q",
        "-n",
        "0",
        "-p",
        "no:cacheprovider",
        *map(str, tests),
    ]
    process = subprocess.Popen(
        command,
        cwd=checkout,
        env=_environment(checkout),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        return process.wait(timeout=limit_s) not in (0, 5)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        return None


def _environment(checkout: Path) -> dict[str, str]:
    """No bytecode is written but what `copy_checkout` writes, and machine code only inside the copy."""
    no_bytecode = {"PYTHONDONTWRITEBYTECODE": "1", "MACTA_TESTS_BYTECODE": "off"}
    return {
        **os.environ,
        **no_bytecode,
        "PYTHONPATH": str(checkout),
        "NUMBA_CACHE_DIR": str(checkout / ".kernels"),
    }


def copy_checkout(folder: Path) -> Path:
    """The last commit, so that the checkout may be worked on meanwhile."""
    folder.mkdir(parents=True)
    archive = subprocess.check_output(["git", "archive", "HEAD"], cwd=ROOT)
    subprocess.run(["tar", "-x", "-C", str(folder)], input=archive, check=True)
    # By the sources' content: a mutant's file may have the size and the second of the one before.
    by_content = PycInvalidationMode.CHECKED_HASH
    for package in (*PACKAGES, "sim", "web", "benchmarks"):
        compileall.compile_dir(folder / package, quiet=2, invalidation_mode=by_content)
    subprocess.run([sys.executable, "-c", COMPILE], cwd=folder, env=_environment(folder), check=True)
    return folder


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("--sample", type=int, default=200, help="number of mutants")
    options.add_argument("--seed", type=int, default=1)
    options.add_argument(
        "--from", type=int, default=1, dest="first", metavar="N", help="number in the sample to begin at"
    )
    options.add_argument("--jobs", type=int, default=2, help="mutants tried at the same time")
    options.add_argument(
        "--files", type=int, help="test files tried on each, the nearest first (default: all)"
    )
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
        for job in range(given.jobs):
            checkouts.put(copy_checkout(Path(folder) / str(job)))
        if _fails(["--collect-only", "tests"], Path(folder) / "0") is not False:
            sys.exit("the tests cannot be collected without a mutant; see `pytest --collect-only`")

        def tried(mutant: Mutant) -> tuple[Mutant, bool, str]:
            checkout = checkouts.get()
            try:
                return mutant, is_killed(mutant, checkout, given.files), mutant.difference(checkout)
            finally:
                checkouts.put(checkout)

        with ThreadPoolExecutor(given.jobs) as pool:
            for count, (mutant, killed, difference) in enumerate(pool.map(tried, mutants), given.first):
                print(f"{count:4} {'killed  ' if killed else 'SURVIVED'} {mutant}", flush=True)
                if not killed:
                    survivors.append(mutant)
                    print(difference, flush=True)
    rate = 1 - len(survivors) / len(mutants)
    print(
        f"\n{len(mutants) - len(survivors)} of {len(mutants)} mutants killed: {rate:.0%} (seed {given.seed})"
    )


if __name__ == "__main__":
    main()
