"""Explains plans, in a planning process: what constraints and robots cost is found by planning without them."""

import threading
from collections.abc import Mapping

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.errors import NotFound
from app.domain.explanation_document import ActionExplanationBody, ExplanationBody
from app.planning.limits import PlanningLimits, PlanningWish
from app.planning.pool.pool import PlanningWorker, WorkerClosed
from app.planning.pool.process import Deadline
from app.planning.pool.waiting_line import Job, Priority, is_large
from app.planning.pool.work import ExplainWork
from app.planning.problem_builder import ProblemBuilder
from app.planning.proposals import plan_row
from app.store import PlanRow
from planner.explanation import Explanation

TIME_LIMIT_S = 10.0
"""For an explanation with costs; one without them needs no planning."""
MAX_CONSTRAINTS = 8
"""So many of a goal's constraints are explained, the first ones."""
MAX_CONCURRENT = 8
"""Explanations with costs at a time: each holds one of the threads that requests are answered in."""


class Explanations:
    """Explains plans.

    While a plan is open to decision and its conditions hold, the explanation has the cost of each constraint and of
    omitting each robot, and is stored with the plan. Later these costs cannot be found and are left out unless stored.
    """

    def __init__(
        self,
        core: Core,
        *,
        problems: ProblemBuilder,
        worker: PlanningWorker,
        limits: PlanningLimits,
        clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        self._database = core.database
        self._knowledge_base = core.knowledge_base
        self._problems = problems
        self._worker = worker
        self._limits = limits
        self._clock = clock
        self._slots = threading.BoundedSemaphore(MAX_CONCURRENT)

    def explanation(self, plan_id: str) -> ExplanationBody:
        """:raises NotFound: if there is no such plan."""
        with self._database.read() as session:
            plan = plan_row(session, plan_id)
            if plan.explanation is not None:
                return ExplanationBody.model_validate(plan.explanation)
            work, is_current = self._work(session, plan)
            job = Job(
                world=plan.world,
                priority=Priority.EXPLANATION,
                is_large=is_large(goals=len(work.problem.goals), effort_s=work.request.effort_s),
            )
        explanation = self._with_costs(work, job) if is_current else None
        body = ExplanationBody.of(explanation or work.without_costs(), self._knowledge_base, plan_id=plan_id)
        if explanation is not None:
            with self._database.write() as session:
                session.get_one(PlanRow, plan_id).explanation = body.model_dump(mode="json")
        return body

    def of_action(self, plan_id: str, action_id: str) -> ActionExplanationBody:
        """:raises NotFound: if there is no such plan, or it has no such action; `choices` are its actions."""
        explained: Mapping[str, ActionExplanationBody] = {
            one.action: one for one in self.explanation(plan_id).actions
        }
        if action_id not in explained:
            raise NotFound(
                f"plan {plan_id} has no action {action_id!r}", code="unknown-action", choices=tuple(explained)
            )
        return explained[action_id]

    def _work(self, session: Session, plan: PlanRow) -> tuple[ExplainWork, bool]:
        """What is to be explained, and whether the plan is open to decision and its conditions still hold."""
        current = self._problems.current(session, plan)
        wish = PlanningWish.from_json({**current.goal.limits, "time_limit_s": TIME_LIMIT_S})
        work = ExplainWork(
            plan_net=current.plan_net,
            problem=current.problem,
            knowledge_base=self._knowledge_base,
            request=self._limits.request(wish),
            withheld=current.roles,
            without=self._problems.without_each_constraint(
                session, current.goal, current.plan_net, at_most=MAX_CONSTRAINTS
            )
            if current.is_current
            else {},
        )
        return work, current.is_current

    def _with_costs(self, work: ExplainWork, job: Job) -> Explanation | None:
        """The explanation with costs; None if too many are requested or no planning process is free in time."""
        if not self._slots.acquire(blocking=False):
            return None
        try:
            return self._worker.do(work, TIME_LIMIT_S, Deadline(self._clock, 2 * TIME_LIMIT_S), job).answer
        except WorkerClosed:
            return None
        finally:
            self._slots.release()
