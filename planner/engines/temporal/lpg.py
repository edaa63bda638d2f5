"""LPG-td: local search on planning graphs (Gerevini, Saetti & Serina, JAIR 20, 2003).

Its licence is not stated, so it is optional and run beside us as it comes in the wheel `up-lpg`.
"""

import math
from importlib.util import find_spec
from pathlib import Path

from planner.engines.temporal.best_plan import BestPlan
from planner.engines.temporal.plan_files import PlanFiles
from planner.native_process import Limits, ProcessEnd, run

MANY = "10000"
"""Plans asked for, each better than the last: more than it finds before it is ended."""


class Lpg:
    """Runs the binary on the problem as temporal PDDL."""

    name = "lpg"

    @property
    def is_installed(self) -> bool:
        return binary() is not None

    def run(self, folder: Path, limits: Limits, seed: int, best: BestPlan) -> ProcessEnd:
        best.task.write(folder)
        found = PlanFiles(folder, best)
        command = [str(binary()), "-o", "domain.pddl", "-f", "problem.pddl", "-n", MANY, "-out", "plan"]
        command += ["-seed", str(seed + 1), "-cputime", str(math.ceil(max(1.0, limits.left_s))), "-v", "off"]
        ended = run(command, folder=folder, limits=limits, is_enough=found.is_enough)
        found.take(is_over=True)
        return ended


def binary() -> Path | None:
    """The executable, None if the wheel is not installed or has none for this system."""
    spec = find_spec("up_lpg")
    file = Path(spec.origin).parent / "lpg" if spec is not None and spec.origin else None
    return file if file is not None and file.is_file() else None
