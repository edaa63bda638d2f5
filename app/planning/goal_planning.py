"""A goal's planning as a durable workflow: plan it, propose the plan, or say why there is none."""

from dataclasses import replace
from functools import partial

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles.goal import GoalState
from app.domain.plan_document import RepairsBody
from app.planning.approval import AUTOMATIC, PlanApproval
from app.planning.limits import PlanningLimits, PlanningWish
from app.planning.pool.pool import PlanningWorker, WorkerClosed
from app.planning.pool.process import Watch, WorkFailed
from app.planning.problem_builder import GoalProblem, ProblemBuilder
from app.planning.progress_watch import GoalWatch
from app.planning.proposals import Proposals
from app.planning.repairs import RepairWork, ReplacedPlan, overtaken
from app.planning.waiting_goals import WaitingGoals
from app.store import GoalRow
from app.workflows import or_give_up, step
from planner import PlanningRequest, PlanningResult, PlanningStatus
from planner.repair import Repair


class Planning:
    """Plans goals one step each; a goal without a plan waits while missions or resting robots may be why."""

    def __init__(
        self,
        core: Core,
        *,
        posing: ProblemBuilder,
        proposing: Proposals,
        waiting: WaitingGoals,
        worker: PlanningWorker,
        limits: PlanningLimits,
        approval: PlanApproval,
    ) -> None:
        self._database, self._events = core.database, core.events
        self._knowledge_base, self._waiting = core.knowledge_base, waiting
        self._posing, self._proposing = posing, proposing
        self._worker, self._limits = worker, limits
        self._approval = approval

    def run(self, goal_id: str) -> None:
        """The workflow. A step that keeps failing ends the goal, so that it is not planned for ever."""
        or_give_up(lambda: step("plan", lambda: self._plan(goal_id)), partial(self._give_up, goal_id))

    def _give_up(self, goal_id: str, reason: str) -> None:
        with self._database.write() as session:
            goal = session.get_one(GoalRow, goal_id, with_for_update=True)
            if goal.state in goal_lifecycle.TO_BE_PLANNED:
                self._unsolvable(session, goal, PlanningStatus.FAILED, reason)

    def _unsolvable(self, session: Session, goal: GoalRow, status: PlanningStatus, reason: str) -> None:
        goal_lifecycle.give_up(goal, outcome=status.value, reason=reason)
        self._events.append(session, "goal.unsolvable", goal.id, reason=reason, status=status.value)

    def _plan(self, goal_id: str) -> str:
        with self._database.write() as session:
            goal = session.get_one(GoalRow, goal_id, with_for_update=True)
            if goal.state not in goal_lifecycle.TO_BE_PLANNED:
                return goal.state
            goal_lifecycle.begin_planning(goal)
            self._events.append(session, "goal.planning", goal.id)
            posed = self._posing.pose(session, goal)
            goal.releases_seen = posed.releases
            turn = _turn(goal)
            request = self._limits.request(PlanningWish.from_json(goal.limits))
            old = overtaken(session, goal, self._knowledge_base)
        watch = GoalWatch(self._database, self._events, goal_id)
        try:
            result, repairs = self._solved(posed, old, request, watch)
        except WorkerClosed:  # the service ends; the goal is planned when it is back
            return GoalState.PLANNING
        if result.plan_net is None and posed.waits_for:
            if never := posed.why_never(self._knowledge_base):
                result, posed = _refusal(never), replace(posed, held=(), resting={})
            else:
                posed = posed.narrowed(self._knowledge_base)
        with self._database.write() as session:
            goal = session.get_one(GoalRow, goal_id, with_for_update=True)
            goal.planning = None
            if goal.state == GoalState.PLANNING and _turn(goal) == turn:
                self._conclude(session, goal, result, posed, repairs)
            return goal.state

    def _solved(
        self, posed: GoalProblem, old: ReplacedPlan | None, request: PlanningRequest, watch: Watch
    ) -> tuple[PlanningResult, RepairsBody | None]:
        """The problem planned, or the overtaken plan repaired, with how the new one differs from it."""
        if posed.refusal:
            return _refusal(posed.refusal), None
        if old is None:
            return self._worker.plan(posed.problem, request, watch), None
        work = RepairWork(
            knowledge_base=self._knowledge_base, plan_net=old.plan_net, problem=posed.problem, request=request
        )
        try:
            repair: Repair = self._worker.do(work, request.time_limit_s, watch)
        except WorkFailed as failure:
            return failure.result, None
        return repair.result, old.repaired_by(repair)

    def _conclude(
        self,
        session: Session,
        goal: GoalRow,
        result: PlanningResult,
        posed: GoalProblem,
        repairs: RepairsBody | None,
    ) -> None:
        if result.plan_net is not None:
            self._propose(session, goal, result, posed, repairs)
        elif posed.waits_for:
            goal_lifecycle.wait(goal, f"waits for {posed.waits_for}")
            self._events.append(session, "goal.waiting", goal.id, reason=goal.reason)
            self._waiting.look_again(session, goal)
        else:
            self._unsolvable(session, goal, result.status, result.reason or result.status.value)

    def _propose(
        self,
        session: Session,
        goal: GoalRow,
        result: PlanningResult,
        posed: GoalProblem,
        repairs: RepairsBody | None,
    ) -> None:
        plan = self._proposing.propose(session, goal, result, posed, repairs)
        goal_lifecycle.propose(goal, plan.id, plan.reason)
        if goal.auto_approve:
            session.flush()
            self._approval.approve_or_expire(session, plan, goal, actor=AUTOMATIC, comment="")


def _turn(goal: GoalRow) -> tuple[int, int]:
    """What tells one planning of a goal from the next, should it be planned again before the first has an answer: by
    the other process that took it over, say. The first was of a world that is no more.
    """
    return goal.attempts, goal.releases_seen


def _refusal(reason: str) -> PlanningResult:
    return PlanningResult(
        status=PlanningStatus.UNSOLVABLE, engine="goal check", planning_s=0.0, reason=reason
    )
