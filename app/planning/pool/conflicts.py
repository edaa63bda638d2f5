"""Work on a goal with constraints: without a plan, it finds out which of these leave none together."""

from dataclasses import dataclass, replace

from app.domain.goal_language.conflict_set import ConstraintConflict
from app.planning.pool.work import Solutions, Work, WorkResult
from planner import Observer, PlanningEngine, PlanningProblem, PlanningRequest
from planner.engines.wrapping import TimeProgress
from planner.explanation.conflict import WITHOUT_A_PLAN, Restriction, conflict_among

CONFLICT_LIMIT_S = 15.0
"""Time for finding out which constraints leave no plan (our choice); it comes after that for planning."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConflictSearch:
    """What the constraints of a goal without a plan are looked for in.

    :param problem: the goal's, without any of the restrictions.
    """

    problem: PlanningProblem
    restrictions: tuple[Restriction, ...]
    request: PlanningRequest


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkUnderConstraints:
    """Work that may have no plan because of a goal's constraints; the result then names those that leave none."""

    work: Work[Solutions]
    search: ConflictSearch

    def __call__(self, engine: PlanningEngine, observer: Observer) -> WorkResult[Solutions]:
        result = self.work(engine, observer)
        is_without = result.answer is None and not result.waits_for and not result.is_refused
        if not is_without or result.status not in WITHOUT_A_PLAN or observer.should_stop():
            return result
        found = conflict_among(
            self.search.problem,
            self.search.restrictions,
            result.status,
            engine,
            replace(self.search.request, time_limit_s=CONFLICT_LIMIT_S),
            TimeProgress(observer),
        )
        if found is None:
            return result
        conflict = ConstraintConflict(
            constraints=found.constraints, proven=found.is_proven, complete=found.is_complete
        )
        return replace(result, conflict=conflict)
