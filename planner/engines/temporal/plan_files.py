"""Plan files in LPG's format: `0.0003: (ACTION OBJECT …) [5.0000]`, a line a step, an empty one at the end."""

import re
from collections.abc import Iterable
from pathlib import Path

from planner.engines.temporal.best_plan import BestPlan, Step

_STEP = re.compile(r"^\s*([\d.]+):\s*\(([^)]*)\)\s*\[\s*([\d.]+)")


def plan_file(folder: Path, number: int) -> Path:
    """The file of an engine's plan, numbered from 1, each better than the one before."""
    return folder / f"plan_{number}.SOL"


def text_of(steps: Iterable[Step]) -> str:
    lines = (
        f"{step.start:.4f}: ({' '.join((step.operator, *step.objects))}) [{step.duration:.4f}]\n"
        for step in steps
    )
    return "".join(lines) + "\n"


def steps_of(text: str) -> tuple[Step, ...]:
    """The steps of a plan file. LPG spells names in capitals, ours have none."""
    matches = (_STEP.match(line) for line in text.lower().splitlines())
    return tuple(
        Step(
            start=float(match[1]),
            duration=float(match[3]),
            operator=match[2].split()[0],
            objects=tuple(match[2].split()[1:]),
        )
        for match in matches
        if match is not None
    )


class PlanFiles:
    """The plan files of a running engine, taken as they come."""

    def __init__(self, folder: Path, best: BestPlan) -> None:
        self._folder = folder
        self._best = best
        self._count = 0

    def is_enough(self) -> bool:
        self.take(is_over=False)
        return self._best.is_enough()

    def take(self, *, is_over: bool) -> None:
        """Take what is new. While the engine runs, the newest file may still be written to."""
        while (file := plan_file(self._folder, self._count + 1)).is_file():
            text = file.read_text()
            is_whole = text.endswith("\n\n") or plan_file(self._folder, self._count + 2).is_file()
            if not (is_over or is_whole):
                return
            self._best.take(steps_of(text))
            self._count += 1
