"""Alternatives to a goal's proposed plan, as a durable workflow: plans of their own, any of which may be approved."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import partial

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.errors import Conflict, unrecorded
from app.domain.ids import new_id
from app.domain.plan_document import PlanBody
from app.domain.states import GoalState, PlanState
from app.planning.limits import PlanningLimits, PlanningWish
from app.planning.pool.pool import PlanningWorker, WorkerClosed
from app.planning.pool.process import WorkFailed
from app.planning.problem_builder import GoalProblem, ProblemBuilder
from app.planning.progress_watch import GoalWatch
from app.planning.proposals import Proposals, open_plans
from app.store import GoalRow, PlanRow
from app.store.records import lock_goal
from app.workflows import FIND_ALTERNATIVES, PLANNING, or_give_up, step
from planner import (
    KnowledgeBase,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.alternatives import Alternative, alternatives

FIRST = "proposed first"
"""The label of a plan that is best at nothing among the alternatives."""


class Search(StrEnum):
    """How the search for a goal's alternatives stands."""

    SEEKING = "seeking"
    FOUND = "found"
    FAILED = "failed"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Sought:
    """The work of finding alternatives."""

    knowledge_base: KnowledgeBase
    problem: PlanningProblem
    request: PlanningRequest
    count: int
    proposed: PlanningResult

    def __call__(self, engine: PlanningEngine, observer: Observer) -> tuple[Alternative, ...]:
        return alternatives(
            engine,
            self.knowledge_base,
            self.problem,
            self.request,
            observer,
            k=self.count,
            proposed=self.proposed,
        )


class Alternatives:
    """Has alternatives to a proposed plan found, and answers them side by side."""

    def __init__(
        self,
        core: Core,
        *,
        posing: ProblemBuilder,
        proposing: Proposals,
        worker: PlanningWorker,
        limits: PlanningLimits,
    ) -> None:
        self._database, self._events, self._workflows = core.database, core.events, core.workflows
        self._knowledge_base, self._posing, self._proposing = core.knowledge_base, posing, proposing
        self._worker, self._limits = worker, limits

    def seek(self, goal_id: str, count: int, *, actor: str) -> GoalRow:
        """Have alternatives found; while they are being sought, asking again changes nothing.

        :raises Conflict: if the goal has no plan that is open to decision.
        """
        with self._database.write() as session:
            goal = lock_goal(session, goal_id)
            if goal.state != GoalState.PLANNED:
                raise Conflict(
                    f"goal {goal.id} is {goal.state}; only a plan that waits for a decision has alternatives",
                    code="no-open-plan",
                )
            if not _is_sought(goal):
                goal.alternatives = {"state": Search.SEEKING.value, "count": count, "reason": ""}
                goal.stop_requested = False
                self._events.append(session, "goal.alternatives_sought", goal.id, actor=actor, count=count)
                self._workflows.start(session, PLANNING, FIND_ALTERNATIVES, new_id("alternatives"), goal.id)
            return goal

    def plans(self, goal_id: str) -> Sequence[PlanRow]:
        """The goal's plans that are open to decision, shortest first; without one, the plan decided on."""
        with self._database.read() as session:
            goal = session.get(GoalRow, goal_id)
            if goal is None:
                raise unrecorded("goal", goal_id)
            rows = list(open_plans(session, goal_id))
            if not rows and goal.plan_id:
                rows = [session.get_one(PlanRow, goal.plan_id)]
        return sorted(rows, key=lambda row: float(row.body["makespan_s"]))

    def run(self, goal_id: str) -> None:
        """The workflow."""
        or_give_up(
            lambda: step("find alternatives", lambda: self._find(goal_id)), partial(self._give_up, goal_id)
        )

    def _give_up(self, goal_id: str, reason: str) -> None:
        with self._database.write() as session:
            goal = lock_goal(session, goal_id)
            if _is_sought(goal):
                self._end(session, goal, Search.FAILED, reason)

    def _find(self, goal_id: str) -> None:
        with self._database.write() as session:
            goal = lock_goal(session, goal_id)
            if not _is_sought(goal):
                return
            posed, first = self._posing.pose(session, goal), goal.plan_id
            work = self._sought(session, goal, posed)
        watch = GoalWatch(self._database, self._events, goal_id, during=GoalState.PLANNED)
        try:
            found: Sequence[Alternative] = self._worker.do(work, work.request.time_limit_s, watch)
            reason = posed.refusal or "no plan was found as the world is by now"
        except WorkFailed as failure:
            found, reason = (), failure.reason
        except WorkerClosed:  # the service ends; what is sought is sought anew when it is asked for again
            return
        with self._database.write() as session:
            goal = lock_goal(session, goal_id)
            goal.planning = None
            if not _is_sought(goal) or goal.plan_id != first:
                return
            if found:
                self._take(session, goal, found, posed)
            self._end(session, goal, Search.FOUND if found else Search.FAILED, "" if found else reason)

    def _sought(self, session: Session, goal: GoalRow, posed: GoalProblem) -> _Sought:
        plan = session.get_one(PlanRow, goal.plan_id)
        body = PlanBody.model_validate(plan.body)
        return _Sought(
            knowledge_base=self._knowledge_base,
            problem=posed.problem,
            request=self._limits.request(PlanningWish.from_json(goal.limits)),
            count=(goal.alternatives or {})["count"],
            proposed=PlanningResult(
                status=PlanningStatus.SOLVED,
                engine=body.engine,
                planning_s=body.planning_s,
                plan_net=body.to_plan_net(self._knowledge_base),
                lower_bound_s=body.lower_bound_s,
            ),
        )

    def _take(
        self, session: Session, goal: GoalRow, found: Iterable[Alternative], posed: GoalProblem
    ) -> None:
        """Propose what is new, say of each what it is best at; earlier alternatives not found again are closed."""
        known = {
            row.id: PlanBody.model_validate(row.body).to_plan_net(self._knowledge_base)
            for row in open_plans(session, goal.id)
        }
        left = set(known) - {goal.plan_id}
        session.get_one(PlanRow, goal.plan_id).label = FIRST
        for one in found:
            plan_id = next((row for row, net in known.items() if net == one.plan_net), None)
            if plan_id is None:
                plan = self._proposing.propose(session, goal, one.result, posed)
            else:
                plan = session.get_one(PlanRow, plan_id)
                left.discard(plan_id)
            plan.label, plan.comparison = one.label, one.words
        for plan_id in left:
            plan = session.get_one(PlanRow, plan_id)
            plan.state, plan.reason = PlanState.SUPERSEDED, "newer alternatives were found"
            self._events.append(session, "plan.superseded", plan.id, goal=goal.id, reason=plan.reason)

    def _end(self, session: Session, goal: GoalRow, state: Search, reason: str) -> None:
        goal.alternatives = {**(goal.alternatives or {}), "state": state.value, "reason": reason}
        plans = [plan.id for plan in open_plans(session, goal.id)]
        self._events.append(session, f"goal.alternatives_{state.value}", goal.id, plans=plans, reason=reason)


def _is_sought(goal: GoalRow) -> bool:
    return goal.state == GoalState.PLANNED and (goal.alternatives or {}).get("state") == Search.SEEKING
