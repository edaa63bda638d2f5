"""Runs tests on a mutant in a copy of the checkout."""

import compileall
import os
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from py_compile import PycInvalidationMode

from benchmarks.mutants.mutation import PACKAGES, ROOT, Mutant
from benchmarks.mutants.reach import MOST_S
from benchmarks.mutants.recording import FOLDER, MODULES, TESTS

LIMIT_S = 5 * MOST_S
"""Longest run of a mutant's tests."""
SOON_S = LIMIT_S / 2
"""Longest run of these tests without the change, if that they do not end with it is to count."""
COMPILE = """
from robots.kernels import install
install()
from robots.compilation import compile_once
from app.planning.pool.work import PLANNER
from sim.process.first_calls import SIMULATION
for group in (SIMULATION, PLANNER):
    compile_once(group, print)
"""


def is_killed(mutant: Mutant, tests: Sequence[str], checkout: Path) -> bool:
    """True if a test fails on the mutant, or they do not end but soon end without it."""
    place = checkout / mutant.path
    original = place.read_text()
    place.write_text(mutant.code(checkout) or original)
    try:
        fails = _fails(tests, checkout)
        if fails is None:
            place.write_text(original)
            return _fails(tests, checkout, SOON_S) is False
        return fails
    finally:
        place.write_text(original)


def _fails(tests: Sequence[str], checkout: Path, limit_s: float = LIMIT_S) -> bool | None:
    """True if a test fails, None if they do not end in time."""
    chosen = checkout / ".tests"
    chosen.write_text("\n".join(tests))
    process = _pytest(checkout, "-x", "-n", "0", f"@{chosen}")
    try:
        return process.wait(timeout=limit_s) not in (0, 5)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        return None


def record(folder: Path, checkout: Path, modules: Sequence[Path]) -> None:
    """Run the tests once without a change and record which of them execute which lines of these modules.

    Those of the page are left out: they test JavaScript. What pytest prints is shown.
    """
    (folder / TESTS).mkdir(parents=True)
    (folder / MODULES).write_text("\n".join(str(checkout / module) for module in modules))
    options = ("-p", "benchmarks.mutants.recording", "-m", "not browser", "--ignore", "tests/web")
    _pytest(checkout, *options, stdout=None, **{FOLDER: str(folder)}).wait()


def _pytest(
    checkout: Path, *options: str, stdout: int | None = subprocess.DEVNULL, **variables: str
) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *options],
        cwd=checkout,
        env={**_environment(checkout), **variables},
        stdout=stdout,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )


def _environment(checkout: Path) -> Mapping[str, str]:
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
