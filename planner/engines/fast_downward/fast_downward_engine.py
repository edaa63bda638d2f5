"""Fast Downward behind the `PlanningEngine` seam: sequences from it, plan-nets made and checked by
ourselves."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from planner.engines.detours import without_detours
from planner.engines.fast_downward.goal_sequences import Search
from planner.engines.fast_downward.process import SequenceResult, find_programs
from planner.engines.optional import not_installed
from planner.engines.plan_net_completion import (
    Outcome,
    complete_plan_net,
    confirm,
    merit,
    timed_result,
    warm_up_validation,
)
from planner.explanation.diagnosis import why_unsolvable
from planner.knowledge import GroundAction, KnowledgeBase
from planner.native_process import Limits
from planner.plan_nets.plan_net import PlanNet
from planner.problem.interface import (
    UNOBSERVED,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    Progress,
)
from planner.problem.static_facts import StaticFacts


class FastDownwardEngine:
    """Plans with Fast Downward; every plan-net is validated.

    The first use imports unified-planning (1-2 s): a long-lived process calls `warm_up()` before it is
    needed.

    :param find_programs: finds the folder of its programs; without one every answer is `FAILED`.
    """

    name = "fast-downward"

    def __init__(
        self, knowledge_base: KnowledgeBase, find_programs: Callable[[], Path | None] = find_programs
    ) -> None:
        self._base = knowledge_base
        self._find_programs = find_programs

    def warm_up(self) -> None:
        """Import what is slow to import."""
        warm_up_validation(self._base)

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        """A plan-net, or why not; the processes started are ended at the time limit.

        With an effort the first plan is improved on for so long; without, the same problem has the same plan.
        """
        return timed_result(
            self.name, self._base, problem, request, lambda: self._plan(problem, request, observer)
        )

    def _plan(self, problem: PlanningProblem, request: PlanningRequest, observer: Observer) -> Outcome:
        programs = self._find_programs()
        if programs is None:
            return PlanningStatus.FAILED, None, not_installed([self.name])
        return _Run(programs, self._base, problem, request, observer).outcome()


class _Run:
    """The planning of one problem."""

    def __init__(
        self,
        programs: Path,
        knowledge_base: KnowledgeBase,
        problem: PlanningProblem,
        request: PlanningRequest,
        observer: Observer,
    ) -> None:
        self._base = knowledge_base
        self._problem = problem
        self._statics = StaticFacts(knowledge_base, problem)
        self._request = request
        self._observer = observer
        self._limits = Limits(request.time_limit_s, request.clock, memory_mb=request.memory_limit_mb)
        self._search = Search(programs, knowledge_base, self._limits, observer.should_stop)

    def outcome(self) -> Outcome:
        if all(goal in self._problem.facts for goal in self._problem.goals):
            return self._best([SequenceResult(status=PlanningStatus.SOLVED)])
        small = self._statics.without_bystanders(self._problem)
        status, plan_net, reason = self._first(small)
        if plan_net is None:
            unsolvable = status is PlanningStatus.UNSOLVABLE
            return status, None, why_unsolvable(self._base, self._problem) if unsolvable else reason
        self._tell(plan_net)
        if self._request.effort_s and not self._search.is_over:
            plan_net = self._improved(plan_net, small, self._request.effort_s)
        return status, plan_net, reason

    def _first(self, small: PlanningProblem) -> Outcome:
        """The first plan-net, else the outcome of the searches for all goals at once."""
        search = self._search
        problem = self._problem
        outcome = first = self._best(search.for_all_goals(small))
        if outcome[1] is None and len(problem.goals) > 1:
            outcome = self._best([search.goal_by_goal(problem, self._statics)])
        if outcome[1] is None and small.objects != problem.objects:
            # Bystanders are left out at first, but one of them may help.
            outcome = first = self._best(search.for_all_goals(problem))
        if outcome[1] is None and first[0] is PlanningStatus.TIMED_OUT and not search.is_over:
            outcome = first = self._best(search.for_all_goals(problem, patient=True))
        return outcome if outcome[1] is not None else first

    def _best(self, found: Iterable[SequenceResult]) -> Outcome:
        """The best plan-net of the sequences found; if there is none, the first failure."""
        plan_nets: list[PlanNet] = []
        failures: list[Outcome] = []
        for one in found:
            if one.status is not PlanningStatus.SOLVED:
                failures.append((one.status, None, one.reason))
                continue
            plan_net = self._finished(one.sequence)
            if isinstance(plan_net, str):
                failures.append((PlanningStatus.NOT_FOUND, None, f"no acceptable plan was found: {plan_net}"))
            else:
                plan_nets.append(plan_net)
        if not plan_nets:
            return failures[0]
        best = min(plan_nets, key=self._merit)
        confirm(best, self._problem, self._base)
        return PlanningStatus.SOLVED, best, ""

    def _improved(self, best: PlanNet, small: PlanningProblem, effort_s: float) -> PlanNet:
        """The best of the plan-net and those that are found with more effort."""

        def take(sequence: Sequence[GroundAction]) -> None:
            nonlocal best
            plan_net = self._finished(sequence)
            if not isinstance(plan_net, str) and self._merit(plan_net) < self._merit(best):
                best = plan_net
                self._tell(best)

        self._search.improve(small, effort_s, take)
        confirm(best, self._problem, self._base)
        return best

    def _merit(self, plan_net: PlanNet) -> tuple[float, ...]:
        return merit(plan_net, self._request.objective)

    def _finished(self, sequence: Sequence[GroundAction]) -> PlanNet | str:
        straight = without_detours(sequence, self._problem, self._base)
        return complete_plan_net(straight, self._problem, self._base, self._statics)

    def _tell(self, plan_net: PlanNet) -> None:
        self._observer.progress(
            Progress(
                engine=FastDownwardEngine.name,
                elapsed_s=self._limits.elapsed_s,
                makespan_s=plan_net.makespan_s,
            )
        )
