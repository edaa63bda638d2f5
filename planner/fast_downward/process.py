"""Fast Downward as separate, killable processes (it is GPL: run beside us, never linked or imported).

The wheel's own driver is a third process and costs a further 0.1 s, so translator and search are called
directly.
"""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from planner.engine import PlanningStatus

GREEDY = (
    "let(hlm,eval_modify_costs(landmark_sum(lm_factory=lm_reasonable_orders_hps(lm_rhw()),pref=false),cost_type=one),"
    "let(hff,eval_modify_costs(ff(),cost_type=one),"
    "lazy_greedy([hff,hlm],preferred=[hff,hlm],cost_type=one,reopen_closed=false,max_time={max_time_s})))"
)
"""As the alias lama-first: quick, blind to costs."""
CHEAP = (
    "let(hlm,landmark_sum(lm_factory=lm_reasonable_orders_hps(lm_rhw()),pref=false),"
    "let(hff,ff(),lazy_wastar([hff,hlm],preferred=[hff,hlm],w=1,max_time={max_time_s})))"
)
"""Lazy A* on the costs: mostly shorter; for one goal as cheap as the optimum wherever that was found."""

_EXHAUSTED = "Completely explored state space"
_SEARCHED_ENOUGH = "Time limit reached"
_OUT_OF_MEMORY = frozenset({20, 22, 24})
_OUT_OF_TIME = frozenset({21, 23, -int(signal.SIGXCPU)})
_UNSOLVABLE = frozenset({10, 11})
_STEP = re.compile(r"^\(([^)]*)\)")


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """What a search said: the steps (operator and objects) if solved, else why not."""

    status: PlanningStatus
    steps: tuple[tuple[str, tuple[str, ...]], ...] = ()
    reason: str = ""


def binaries() -> Path | None:
    """The folder of the translator package and the search binary, None if the wheel is not installed."""
    spec = find_spec("up_fast_downward")
    if spec is None or spec.origin is None:
        return None
    folder = Path(spec.origin).parent / "downward" / "builds" / "release" / "bin"
    return folder if (folder / "downward").is_file() else None


class FastDownwardProcess:
    """Translator and search on files of one folder, all ended at `deadline` (monotonic seconds)."""

    def __init__(self, folder: Path, deadline: float, *, memory_limit_mb: int = 2048) -> None:
        self._folder, self._deadline, self._memory_kb = folder, deadline, memory_limit_mb * 1024

    def translate(self, domain: str, problem: str) -> Answer | None:
        """Ground the task; None if that went well."""
        (self._folder / "domain.pddl").write_text(domain)
        (self._folder / "problem.pddl").write_text(problem)
        command = [sys.executable, "-S", "-m", "fast_downward.translate", "domain.pddl", "problem.pddl"]
        code, output = self._run(command)
        return None if code == 0 else _failure(code, output)

    def search(self, configuration: str, max_time_s: float) -> Answer:
        """Search the translated task for at most so long."""
        plan = self._folder / "plan"
        plan.unlink(missing_ok=True)
        folder = binaries()
        if folder is None:
            return Answer(status=PlanningStatus.FAILED, reason="Fast Downward is not installed")
        command = [
            str(folder / "downward"),
            "--internal-plan-file",
            str(plan),
            "--search",
            configuration.format(max_time_s=max_time_s),
        ]
        code, output = self._run(command, stdin=self._folder / "output.sas")
        if plan.is_file():
            return Answer(status=PlanningStatus.SOLVED, steps=_steps(plan.read_text()))
        return _failure(code, output)

    def _run(self, command: Sequence[str], stdin: Path | None = None) -> tuple[int | None, str]:
        """Exit code and output; code None if it was ended at the deadline."""
        # A shell sets the memory limit: setting it between fork and exec is not safe in a process with
        # threads.
        limited = ["/bin/sh", "-c", f'ulimit -v {self._memory_kb} 2>/dev/null; exec "$@"', "sh", *command]
        environment = {**os.environ, "PYTHONPATH": str(binaries() or ""), "PYTHONHASHSEED": "0"}
        with open(stdin or os.devnull, "rb") as source:
            process = subprocess.Popen(
                limited,
                cwd=self._folder,
                env=environment,
                stdin=source,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        try:
            output, _ = process.communicate(timeout=max(0.01, self._deadline - time.monotonic()))
            return process.returncode, output.decode(errors="replace")
        except subprocess.TimeoutExpired:
            return None, ""
        finally:
            _end(process)


def _end(process: "subprocess.Popen[bytes]") -> None:
    """End the whole process group, if it still runs."""
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def _failure(code: int | None, output: str) -> Answer:
    last = output.strip().splitlines()[-1:] or ["no output"]
    if code is None or code in _OUT_OF_TIME or _SEARCHED_ENOUGH in output:
        return Answer(status=PlanningStatus.TIMED_OUT, reason="the time limit was reached")
    if code in _OUT_OF_MEMORY or "MemoryError" in output:
        return Answer(status=PlanningStatus.OUT_OF_MEMORY, reason="the memory limit was reached")
    # NOTE: both configurations are complete, so an exhausted state space is a proof.
    if code in _UNSOLVABLE or _EXHAUSTED in output:
        return Answer(status=PlanningStatus.UNSOLVABLE, reason="no plan exists from the present facts")
    return Answer(status=PlanningStatus.FAILED, reason=f"Fast Downward ended with code {code}: {last[0]}")


def _steps(text: str) -> tuple[tuple[str, tuple[str, ...]], ...]:
    steps = []
    for line in text.splitlines():
        if (match := _STEP.match(line.strip())) is not None:
            operator, *objects = match[1].split()
            steps.append((operator, tuple(objects)))
    return tuple(steps)
