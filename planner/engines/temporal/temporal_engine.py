"""A temporal planner behind the `PlanningEngine` seam: schedules from it, plan-nets made and checked by
ourselves."""

import signal
import tempfile
from pathlib import Path
from typing import Protocol

from planner.engines.optional import not_installed
from planner.engines.plan_net_completion import Outcome, confirm, timed_result, warm_up_validation
from planner.engines.temporal.best_plan import BestPlan
from planner.explanation.diagnosis import why_unsolvable
from planner.interchange.pddl import Form, PddlTask
from planner.knowledge import KnowledgeBase
from planner.native_process import Limits, ProcessEnd
from planner.problem.interface import (
    UNOBSERVED,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.problem.static_facts import StaticFacts
from planner.relaxation import is_relaxed_reachable


class Solver(Protocol):
    """A planner as a separate process that finds one schedule, then better ones."""

    name: str

    @property
    def is_installed(self) -> bool: ...

    def run(self, folder: Path, limits: Limits, seed: int, best: BestPlan) -> ProcessEnd:
        """Hand every schedule found to `best`, until that is enough or the time is over."""
        ...


class TemporalEngine:
    """Plans with a solver; every plan-net is validated.

    It is stopped by the clock: the same seed gives the same schedules, but not always as many of them.
    """

    def __init__(self, knowledge_base: KnowledgeBase, solver: Solver) -> None:
        self.name = solver.name
        self._base = knowledge_base
        self._solver = solver

    def warm_up(self) -> None:
        """Import what is slow to import."""
        warm_up_validation(self._base)

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        """A plan-net, or why not; the processes started are ended at the time limit."""
        return timed_result(
            self.name, self._base, problem, request, lambda: self._plan(problem, request, observer)
        )

    def _plan(self, problem: PlanningProblem, request: PlanningRequest, observer: Observer) -> Outcome:
        if not self._solver.is_installed:
            return PlanningStatus.FAILED, None, not_installed([self.name])
        if not is_relaxed_reachable(self._base, problem):
            return PlanningStatus.UNSOLVABLE, None, why_unsolvable(self._base, problem)
        timer = request.timer()
        small = StaticFacts(self._base, problem).without_bystanders(problem)
        # Bystanders are left out at first, but one of them may help.
        if small.objects == problem.objects:
            return self._search(problem, problem, request, observer, timer.left_s)
        outcome = self._search(problem, small, request, observer, timer.left_s / 2)
        if outcome[1] is None and not observer.should_stop():
            outcome = self._search(problem, problem, request, observer, timer.left_s)
        return outcome

    def _search(
        self,
        problem: PlanningProblem,
        searched: PlanningProblem,
        request: PlanningRequest,
        observer: Observer,
        limit_s: float,
    ) -> Outcome:
        task = PddlTask(self._base, searched, Form.TEMPORAL, is_simplified=True)
        best = BestPlan(self.name, problem, task, request, observer)
        limits = Limits(limit_s, request.clock, memory_mb=request.memory_limit_mb)
        with tempfile.TemporaryDirectory(prefix=f"macta-{self.name}-") as folder:
            ended = self._solver.run(Path(folder), limits, request.seed, best)
        if best.plan_net is None:
            return _without_plan(ended, best)
        confirm(best.plan_net, problem, self._base)
        return PlanningStatus.SOLVED, best.plan_net, ""


def _without_plan(ended: ProcessEnd, best: BestPlan) -> Outcome:
    last = (ended.output.strip().splitlines() or ["no output"])[-1]
    if "memory" in ended.output.lower():
        status = PlanningStatus.OUT_OF_MEMORY
        reason = "the memory limit was reached"
    elif best.is_enough():
        status = PlanningStatus.NOT_FOUND
        reason = "it was stopped before it found a plan"
    elif ended.code is None:
        status = PlanningStatus.TIMED_OUT
        reason = "the time limit was reached"
    elif best.rejected:
        status = PlanningStatus.NOT_FOUND
        reason = f"no acceptable plan was found: {best.rejected}"
    elif ended.code < 0:
        name = signal.Signals(-ended.code).name
        status = PlanningStatus.FAILED
        reason = f"it crashed ({name}), as it does on larger problems"
    elif ended.code > 0:
        status = PlanningStatus.FAILED
        reason = f"ended with code {ended.code}: {last}"
    else:
        status = PlanningStatus.NOT_FOUND
        reason = "the search ended without a plan"
    return status, None, reason
