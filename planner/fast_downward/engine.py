"""Fast Downward behind the `PlanningEngine` seam: sequences from it, plan-nets made and checked by
ourselves."""

import time

from planner.assembly import assemble
from planner.compilation import compile_problem
from planner.diagnosis import why_unsolvable
from planner.engine import PlanningProblem, PlanningResult, PlanningStatus
from planner.errors import InvalidPlan, KnowledgeBaseError
from planner.extraction import extract
from planner.fast_downward.pddl import write_pddl
from planner.fast_downward.restrictions import Restrictions
from planner.fast_downward.search import Search
from planner.fast_downward.trial import Trial, Trials
from planner.knowledge import KnowledgeBase
from planner.plan_net import PlanNet
from planner.statics import Statics


class FastDownwardEngine:
    """Plans with Fast Downward; every plan-net is validated and safe in every order its scripts allow.

    The first use imports unified-planning (1-2 s): a long-lived process calls `warm_up()` before it is
    needed.
    """

    name = "fast-downward"

    def __init__(
        self, knowledge_base: KnowledgeBase, *, memory_limit_mb: int = 2048, max_trials: int = 16
    ) -> None:
        self._base = knowledge_base
        self._memory_limit_mb, self._max_trials = memory_limit_mb, max_trials

    def warm_up(self) -> None:
        """Import what is slow to import, by compiling an empty problem."""
        write_pddl(compile_problem(self._base, PlanningProblem(objects={}, facts=frozenset(), goals=())))

    def plan(self, problem: PlanningProblem, *, time_limit_s: float) -> PlanningResult:
        """A plan-net, or why not; the processes started are ended at the time limit."""
        begun = time.monotonic()
        plan_net: PlanNet | None = None
        try:
            for fact in (*sorted(problem.facts), *problem.goals):
                self._base.check(fact, problem.objects)
            status, plan_net, reason = self._plan(problem, begun + time_limit_s)
        except (KnowledgeBaseError, InvalidPlan) as error:
            status, reason = PlanningStatus.FAILED, str(error)
        return PlanningResult(
            status=status,
            engine=self.name,
            planning_s=round(time.monotonic() - begun, 3),
            plan_net=plan_net,
            reason=reason,
        )

    def _plan(self, problem: PlanningProblem, deadline: float) -> tuple[PlanningStatus, PlanNet | None, str]:
        if all(goal in problem.facts for goal in problem.goals):
            order = extract((), problem.facts, problem.goals)
            return PlanningStatus.SOLVED, assemble(order, problem.goals, self._base, {}), ""
        statics = Statics(self._base, problem)
        restrictions = Restrictions(statics)
        search = Search(self._base, deadline, memory_limit_mb=self._memory_limit_mb)
        trials = Trials(self._base, problem, statics, search)
        unsafe = ""
        for count, restriction in enumerate(restrictions, start=1):
            trial = trials.run(restriction)
            if trial.is_good:
                return PlanningStatus.SOLVED, trial.plan_net, ""
            if trial.plan_net is not None and trial.violation is not None:
                unsafe = unsafe or trial.violation.reason
                restrictions.learn(restriction, trial.violation, trial.plan_net)
            elif not unsafe:
                return self._no_plan(problem, trial, search)
            if count >= self._max_trials or search.is_over:
                break
        return PlanningStatus.NOT_FOUND, None, f"no plan was found that is safe to carry out: {unsafe}"

    def _no_plan(
        self, problem: PlanningProblem, trial: Trial, search: Search
    ) -> tuple[PlanningStatus, PlanNet | None, str]:
        """The answer when there is no plan even without a restriction."""
        status, reason = trial.found.status, trial.found.reason
        if status is PlanningStatus.UNSOLVABLE:
            return status, None, why_unsolvable(self._base, problem)
        if status is PlanningStatus.TIMED_OUT and not search.is_over:
            return PlanningStatus.NOT_FOUND, None, why_unsolvable(self._base, problem)
        return status, None, reason
