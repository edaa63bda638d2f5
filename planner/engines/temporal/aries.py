"""Aries: planning as constraint solving with optional activities (Bit-Monnot, ECAI 2023); the wheel `up-aries`.

It is a server that unified-planning calls by gRPC. Both run in a process of their own, for it overruns its limits
and needs a real standard output.
"""

import pickle
import sys
from importlib.util import find_spec
from pathlib import Path

from planner.engines.temporal.best_plan import BestPlan
from planner.engines.temporal.plan_files import PlanFiles
from planner.native_process import Limits, ProcessEnd, run

PROBLEM = "problem.pickle"


class Aries:
    """Runs `planner.engines.temporal.aries_process` on the problem."""

    name = "aries"

    @property
    def is_installed(self) -> bool:
        return find_spec("up_aries") is not None and find_spec("grpc") is not None

    def run(self, folder: Path, limits: Limits, seed: int, best: BestPlan) -> ProcessEnd:
        """`seed` is ignored."""
        task = best.task
        (folder / PROBLEM).write_bytes(pickle.dumps((task.knowledge_base.file, task.problem)))
        found = PlanFiles(folder, best)
        ended = run(
            [sys.executable, "-m", "planner.engines.temporal.aries_process", str(limits.left_s)],
            folder=folder,
            limits=limits,
            # It writes its log to the folder for temporary files.
            environment={"PYTHONPATH": str(Path(__file__).parents[3]), "TMPDIR": str(folder)},
            is_enough=found.is_enough,
        )
        found.take(is_over=True)
        return ended
