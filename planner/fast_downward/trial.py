"""One trial: search under a restriction, make plan-nets of what is found, check them, keep the best."""

from dataclasses import dataclass

from planner.assembly import assemble
from planner.compilation import compile_problem
from planner.engine import PlanningProblem, PlanningStatus
from planner.errors import InvalidPlan
from planner.execution import Violation, first_violation
from planner.extraction import extract
from planner.fast_downward.search import Found, Search
from planner.knowledge import KnowledgeBase
from planner.plan_net import PlanNet
from planner.recruitment import recruitment_of
from planner.statics import Restriction, Statics
from planner.up_validation import up_fault
from planner.validation import faults_of, unintended


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """What the search came to, the best plan-net of it, and what the scripts could do wrong with that one."""

    found: Found
    plan_net: PlanNet | None = None
    violation: Violation | None = None

    @property
    def is_good(self) -> bool:
        return self.plan_net is not None and self.violation is None

    @property
    def badness(self) -> tuple[bool, bool, float, float]:
        """Safe before unsafe, unsafe in a way one can learn from before others, soonest over, then least work."""
        teaches_nothing = self.violation is not None and self.violation.fact is None
        actions = self.plan_net.actions if self.plan_net else ()
        makespan_s = self.plan_net.makespan_s if self.plan_net else 0.0
        return not self.is_good, teaches_nothing, makespan_s, sum(action.duration_s for action in actions)


class Trials:
    """Trials of one problem with one source of sequences."""

    def __init__(
        self, knowledge_base: KnowledgeBase, problem: PlanningProblem, statics: Statics, search: Search
    ) -> None:
        self._base, self._problem, self._statics, self._search = knowledge_base, problem, statics, search

    def run(self, restriction: Restriction) -> Trial:
        """The best of what is found under the restriction.

        First without bystanders, all goals at once and one after the other; with bystanders if there is no
        such plan.
        """
        restricted = self._statics.restricted(restriction)
        lean = self._statics.lean(restricted)
        trials = [self._checked(found) for found in self._search.at_once(lean)]
        if len(lean.goals) > 1 and not any(trial.is_good for trial in trials):
            trials.append(self._checked(self._search.one_by_one(restricted, self._statics)))
        solved = [trial for trial in trials if trial.plan_net is not None]
        if not solved and lean.objects != restricted.objects:
            trials = [self._checked(found) for found in self._search.at_once(restricted)]
            solved = [trial for trial in trials if trial.plan_net is not None]
        if not solved:
            return trials[0]
        best = min(solved, key=lambda trial: trial.badness)
        if best.plan_net is not None and best.is_good:
            compiled = compile_problem(self._base, restricted)
            if (fault := up_fault(compiled, best.plan_net)) is not None:
                raise InvalidPlan(f"unified-planning rejects the plan: {fault}")
        return best

    def _checked(self, found: Found) -> Trial:
        """The sequence's plan-net and the first thing wrong with it.

        :raises InvalidPlan: if the plan-net itself is faulty: that would be our own mistake.
        """
        if found.status is not PlanningStatus.SOLVED:
            return Trial(found=found)
        problem = self._problem
        order = extract(found.sequence, problem.facts, problem.goals)
        plan_net = assemble(order, problem.goals, self._base, recruitment_of(order.actions, self._statics))
        if idle := unintended(plan_net, self._base):
            return Trial(found=found, plan_net=plan_net, violation=Violation(reason=idle[0]))
        if faults := faults_of(plan_net, problem.facts, self._base):
            raise InvalidPlan("; ".join(faults))
        violation = first_violation(plan_net, problem.facts, problem.objects, self._base)
        return Trial(found=found, plan_net=plan_net, violation=violation)
