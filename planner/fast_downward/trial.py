"""One trial: search under a restriction, make plan-nets of what is found, check them, keep the best."""

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from planner.assembly import assemble
from planner.compilation import CompiledProblem, compile_problem
from planner.engine import PlanningProblem, PlanningStatus
from planner.errors import InvalidPlan
from planner.execution import Violation, first_violation
from planner.extraction import extract
from planner.fast_downward.pddl import write_pddl
from planner.fast_downward.process import CHEAP, GREEDY, Answer, FastDownwardProcess
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_net import PlanNet
from planner.recruitment import recruitment_of
from planner.statics import Restriction, Statics
from planner.up_validation import up_fault
from planner.validation import faults_of, unintended


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """What the search came to, the best plan-net of it, and what the scripts could do wrong with that one."""

    answer: Answer
    plan_net: PlanNet | None = None
    violation: Violation | None = None

    @property
    def is_good(self) -> bool:
        return self.plan_net is not None and self.violation is None

    @property
    def badness(self) -> tuple[bool, float]:
        """Safe before unsafe, then soonest over."""
        return not self.is_good, self.plan_net.makespan_s if self.plan_net else 0.0


class Trials:
    """Trials of one problem until a deadline (monotonic seconds)."""

    def __init__(
        self,
        knowledge_base: KnowledgeBase,
        problem: PlanningProblem,
        statics: Statics,
        deadline: float,
        *,
        memory_limit_mb: int,
    ) -> None:
        self._base, self._problem, self._statics = knowledge_base, problem, statics
        self._deadline, self._memory_limit_mb = deadline, memory_limit_mb

    def run(self, restriction: Restriction) -> Trial:
        """Search under the restriction: first without bystanders, with them if that has no plan."""
        restricted = self._statics.restricted(restriction)
        lean = self._statics.lean(restricted)
        trial = self._search(lean)
        if trial.answer.status is PlanningStatus.UNSOLVABLE and lean.objects != restricted.objects:
            trial = self._search(restricted)
        return trial

    def _search(self, restricted: PlanningProblem) -> Trial:
        compiled = compile_problem(self._base, restricted)
        answer = Answer(status=PlanningStatus.FAILED, reason="no search was run")
        trials: list[Trial] = []
        for answer in self._answers(compiled):
            if answer.status is not PlanningStatus.SOLVED:
                break
            steps = [compiled.ground(operator, objects) for operator, objects in answer.steps]
            trials.append(self._checked(answer, steps))
        if not trials:
            return Trial(answer=answer)
        best = min(trials, key=lambda trial: trial.badness)
        if (
            best.plan_net is not None
            and best.is_good
            and (fault := up_fault(compiled, best.plan_net)) is not None
        ):
            raise InvalidPlan(f"unified-planning rejects the plan: {fault}")
        return best

    def _answers(self, compiled: CompiledProblem) -> Iterator[Answer]:
        with tempfile.TemporaryDirectory(prefix="macta-fd-") as folder:
            process = FastDownwardProcess(Path(folder), self._deadline, memory_limit_mb=self._memory_limit_mb)
            failure = process.translate(*write_pddl(compiled))
            if failure is not None:
                yield failure
                return
            for configuration in (GREEDY, CHEAP):
                yield process.search(configuration)

    def _checked(self, answer: Answer, sequence: list[GroundAction]) -> Trial:
        """The sequence's plan-net and the first thing wrong with it.

        :raises InvalidPlan: if the plan-net itself is faulty: that would be our own mistake.
        """
        problem = self._problem
        order = extract(sequence, problem.facts, problem.goals)
        plan_net = assemble(order, problem.goals, self._base, recruitment_of(order.actions, self._statics))
        if idle := unintended(plan_net, self._base):
            return Trial(answer=answer, plan_net=plan_net, violation=Violation(reason=idle[0]))
        if faults := faults_of(plan_net, problem.facts, self._base):
            raise InvalidPlan("; ".join(faults))
        violation = first_violation(plan_net, problem.facts, problem.objects, self._base)
        return Trial(answer=answer, plan_net=plan_net, violation=violation)
