"""Fast Downward as separate, killable processes (it is GPL: run beside us, never linked or imported).

The wheel's own driver is a third process and costs a further 0.1 s, so translator and search are called
directly.
"""

import re
import signal
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from planner.interchange.pddl import PddlTask
from planner.knowledge import GroundAction
from planner.native_process import Limits, ProcessEnd, never, run
from planner.problem.interface import PlanningStatus

GREEDY = (
    "let(hlm,eval_modify_costs(landmark_sum(lm_factory=lm_reasonable_orders_hps(lm_rhw()),pref=false),cost_type=one),"
    "let(hff,eval_modify_costs(ff(),cost_type=one),"
    "lazy_greedy([hff,hlm],preferred=[hff,hlm],cost_type=one,reopen_closed=false,max_time={max_time_s})))"
)
"""As the alias lama-first: quick, ignores costs."""
CHEAP = (
    "let(hlm,landmark_sum(lm_factory=lm_reasonable_orders_hps(lm_rhw()),pref=false),"
    "let(hff,ff(),lazy_wastar([hff,hlm],preferred=[hff,hlm],w=1,max_time={max_time_s})))"
)
"""Lazy A* on the costs: mostly shorter; for one goal as cheap as the optimum wherever that was found."""

_WEIGHTED = ",".join(f"lazy_wastar([hff,hlm],preferred=[hff,hlm],w={weight})" for weight in (5, 3, 2, 1))
ANYTIME = (
    "let(hlm,landmark_sum(lm_factory=lm_reasonable_orders_hps(lm_rhw()),pref=false),"
    f"let(hff,ff(),iterated([{_WEIGHTED}],repeat_last=true)))"
)
"""As the alias lama from its third search on: one plan after the other, each cheaper than the last."""

_EXHAUSTED = "Completely explored state space"
_SEARCHED_ENOUGH = "Time limit reached"
_OUT_OF_MEMORY = frozenset({20, 22, 24})
_OUT_OF_TIME = frozenset({21, 23, -int(signal.SIGXCPU)})
_UNSOLVABLE = frozenset({10, 11})
_STEP = re.compile(r"^\(([^)]*)\)")


@dataclass(frozen=True, slots=True, kw_only=True)
class SequenceResult:
    """A sequence that reaches the goals if solved, else why there is none."""

    status: PlanningStatus
    sequence: tuple[GroundAction, ...] = ()
    reason: str = ""


def find_programs() -> Path | None:
    """The folder of the translator package and the search binary, None if the wheel is not installed."""
    spec = find_spec("up_fast_downward")
    if spec is None or spec.origin is None:
        return None
    folder = Path(spec.origin).parent / "downward" / "builds" / "release" / "bin"
    return folder if (folder / "downward").is_file() else None


class FastDownwardProcess:
    """Translator and search of one task on files of one folder, all ended at their limits or when it is enough."""

    def __init__(
        self,
        programs: Path,
        folder: Path,
        task: PddlTask,
        limits: Limits,
        is_enough: Callable[[], bool] = never,
    ) -> None:
        self._programs = programs
        self._folder = folder
        self._task = task
        self._limits = limits
        self._is_enough = is_enough

    def translate(self) -> SequenceResult | None:
        """Ground the task; None on success."""
        self._task.write(self._folder)
        command = [sys.executable, "-S", "-m", "fast_downward.translate", "domain.pddl", "problem.pddl"]
        ended = self._run(command, self._is_enough)
        return None if ended.code == 0 else _failure(ended)

    def search(self, configuration: str, max_time_s: float) -> SequenceResult:
        """Search the translated task for at most so long."""
        plan = self._folder / "plan"
        plan.unlink(missing_ok=True)
        ended = self._search(configuration.format(max_time_s=max_time_s), self._is_enough)
        if plan.is_file():
            return SequenceResult(status=PlanningStatus.SOLVED, sequence=self._sequence(plan.read_text()))
        return _failure(ended)

    def improve(self, take: Callable[[Sequence[GroundAction]], None]) -> None:
        """Search the translated task for ever cheaper sequences, each taken as soon as it is found."""
        count = 0

        def is_enough() -> bool:
            nonlocal count
            # A plan file ends with its cost.
            while "; cost" in (text := _text(self._folder / f"plan.{count + 1}")):
                count += 1
                take(self._sequence(text))
            return self._is_enough()

        self._search(ANYTIME, is_enough)
        is_enough()

    def _search(self, configuration: str, is_enough: Callable[[], bool]) -> ProcessEnd:
        plan = str(self._folder / "plan")
        command = [str(self._programs / "downward"), "--internal-plan-file", plan, "--search", configuration]
        return self._run(command, is_enough, stdin=self._folder / "output.sas")

    def _run(
        self, command: Sequence[str], is_enough: Callable[[], bool], stdin: Path | None = None
    ) -> ProcessEnd:
        return run(
            command,
            folder=self._folder,
            limits=self._limits,
            stdin=stdin,
            environment={"PYTHONPATH": str(self._programs), "PYTHONHASHSEED": "0"},
            is_enough=is_enough,
        )

    def _sequence(self, text: str) -> tuple[GroundAction, ...]:
        """The actions of a plan file."""
        steps = [match[1].split() for line in text.splitlines() if (match := _STEP.match(line.strip()))]
        return tuple(self._task.ground(operator, objects) for operator, *objects in steps)


def _failure(ended: ProcessEnd) -> SequenceResult:
    code = ended.code
    output = ended.output
    last = output.strip().splitlines()[-1:] or ["no output"]
    if code is None or code in _OUT_OF_TIME or _SEARCHED_ENOUGH in output:
        return SequenceResult(status=PlanningStatus.TIMED_OUT, reason="the time limit was reached")
    if code in _OUT_OF_MEMORY or "MemoryError" in output:
        return SequenceResult(status=PlanningStatus.OUT_OF_MEMORY, reason="the memory limit was reached")
    # NOTE: both configurations are complete, so an exhausted state space is a proof.
    if code in _UNSOLVABLE or _EXHAUSTED in output:
        return SequenceResult(
            status=PlanningStatus.UNSOLVABLE, reason="no plan exists from the present facts"
        )
    return SequenceResult(
        status=PlanningStatus.FAILED, reason=f"Fast Downward ended with code {code}: {last[0]}"
    )


def _text(file: Path) -> str:
    return file.read_text() if file.is_file() else ""
