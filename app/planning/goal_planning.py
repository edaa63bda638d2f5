"""A goal's planning as a durable workflow: propose a plan, wait until there may be one, or say why there is none."""

from collections.abc import Hashable
from dataclasses import replace

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.blockers import Blockers
from app.domain.events import (
    GoalFinished,
    GoalPlanned,
    GoalPlanningBegan,
    GoalUnsolvable,
    GoalWaiting,
    GoalWithdrawn,
)
from app.domain.goal_language.terms import GoalTerms
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles import tender as tender_lifecycle
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import OPEN, MissionState
from app.domain.lifecycles.plan import PlanState
from app.domain.lifecycles.tender import TenderState
from app.domain.plan_document import PlanBody
from app.domain.tender_document import Allocation, TenderBody
from app.planning.approval import AUTOMATIC, PlanApproval
from app.planning.job import PlanningJob, PlanningTask, ReplacedPlan
from app.planning.limits import PlanningLimits, PlanningWish
from app.planning.pool.conflicts import CONFLICT_LIMIT_S, ConflictSearch
from app.planning.pool.pool import PlanningWorker
from app.planning.pool.waiting_line import Priority
from app.planning.pool.work import PlanWork, RepairWork, Solution, Solutions, WorkResult
from app.planning.problem_builder import GoalProblem, ProblemBuilder
from app.planning.proposals import Proposals
from app.planning.requests import PlanningRequests
from app.planning.tenders import Tenders, tender_of
from app.planning.waiting_goals import STATED_BY, WaitingGoals, have_wait
from app.store import GoalRow, MissionRow, PlanRow
from app.store.event_log import EventLog
from app.store.records import joint_goal_of
from app.workflows import current_workflow
from planner import KnowledgeBaseError, PlanningRequest, PlanningStatus

TRUE_ALREADY = "nothing to carry out; it is true already"


class GoalPlanningJob(PlanningJob[GoalRow, PlanningTask]):
    """Plans goals. If a goal's last plan has expired, it is repaired."""

    step_name = "plan"
    priority = Priority.GOAL

    def __init__(
        self,
        core: Core,
        *,
        problems: ProblemBuilder,
        proposals: Proposals,
        waiting: WaitingGoals,
        worker: PlanningWorker,
        limits: PlanningLimits,
        approval: PlanApproval,
        tenders: Tenders | None = None,
        requests: PlanningRequests | None = None,
    ) -> None:
        """:param tenders, requests: None: robots are not called for bids, whatever goals ask for."""
        super().__init__(core, worker=worker)
        self._facts = core.facts
        self._problems = problems
        self._proposals = proposals
        self._waiting = waiting
        self._limits = limits
        self._approval = approval
        self._tenders = tenders
        self._requests = requests

    def load(self, session: Session, subject_id: str, *, lock: bool) -> GoalRow:
        return session.get_one(GoalRow, subject_id, with_for_update=lock or None)

    def attempt_key(self, subject: GoalRow) -> Hashable:
        if subject.state != GoalState.PLANNING:
            return None
        tender = tender_of(subject)
        return subject.attempts, subject.releases_seen, None if tender is None else tender.state

    def begin(self, session: Session, subject: GoalRow) -> PlanningTask | None:
        goal = subject
        if goal.state not in goal_lifecycle.TO_BE_PLANNED or self._is_left_to_another(session, goal):
            return None
        if goal.state != GoalState.PLANNING:
            self._forget_tender(session, goal)
        tender = tender_of(goal)
        is_called = tender is not None and tender.state == TenderState.CALLED
        if self._tenders is not None and is_called and not self._tenders.is_answered(session, goal):
            return None  # it is planned once all have answered
        if missions := self._still_open(session, goal):
            goal.releases_seen = self._facts.lock(session, goal.world).releases
            have_wait(session, self._events, goal, Blockers(missions=missions))
            return None
        built = self._problems.build(session, goal)
        if is_called and self._tenders is not None:
            tender, blockers = self._tenders.close(session, goal, built)
            goal.tender = tender.model_dump(mode="json")
            if blockers is not None:
                goal.releases_seen = built.releases
                self._tenders.release(session, goal)
                self._wait(session, goal, blockers)
                return None
        task = self._task(session, goal, built, self._expired(session, goal))
        goal_lifecycle.begin_planning(goal)
        goal.planned_by = current_workflow()
        self._events.append(session, GoalPlanningBegan(subject=goal.id))
        return task

    def _is_left_to_another(self, session: Session, goal: GoalRow) -> bool:
        """Whether the goal's joint goal carries it out, has done so, or was cancelled; then this one has ended with it.

        What a joint goal has brought about counts though it may have been undone since, as for any mission.
        """
        joint = joint_goal_of(session, goal)
        if joint is None or joint.state in goal_lifecycle.OPEN:
            return joint is not None
        mission = None if joint.mission_id is None else session.get(MissionRow, joint.mission_id)
        if mission is None or goal.id not in mission.joined_goals:
            goal.joint_goal = None  # it ended before it was planned for this goal, too
            return False
        if joint.outcome == MissionState.COMPLETED:
            finish_with_others(session, self._events, goal, joint)
        elif joint.outcome == MissionState.CANCELLED and joint.created_by == STATED_BY:
            reason = f"{joint.id}, which carried it out together with others, was cancelled"
            goal_lifecycle.withdraw(goal, outcome=joint.outcome, reason=reason)
            self._events.append(session, GoalWithdrawn(subject=goal.id, reason=reason))
        else:
            return False
        return True

    def _still_open(self, session: Session, goal: GoalRow) -> tuple[str, ...]:
        """The missions that are to end before the goal is planned, and have not."""
        ended_first = GoalTerms.from_json(goal.terms).constraints.after
        if not ended_first:
            return ()
        query = select(MissionRow.id).where(MissionRow.id.in_(ended_first), MissionRow.state.in_(OPEN))
        return tuple(f"the end of mission {one}" for one in session.scalars(query.order_by(MissionRow.id)))

    def binds(self, subject: GoalRow) -> bool:
        return subject.auto_approve

    def renew(self, session: Session, subject: GoalRow, task: PlanningTask) -> PlanningTask:
        return self._task(session, subject, self._problems.build(session, subject), task.replaces)

    def _task(
        self, session: Session, goal: GoalRow, built: GoalProblem, expired: ReplacedPlan | None
    ) -> PlanningTask:
        goal.releases_seen = built.releases
        request = self._limits.request(PlanningWish.from_json(goal.limits))
        if self._tenders is not None and goal.allocation == Allocation.CONTRACT_NET:
            return self._tendered(goal, built, request, self._tenders)
        is_edited = expired is not None and bool(expired.edits)
        if built.problem.values or (built.problem.preferences and not is_edited):
            expired = None  # which goals are worth it, and which preferences, is decided again
        if expired is not None:
            built = self._problems.pinned(built, expired.edits)
        if expired is None:
            work: PlanWork | RepairWork = PlanWork(problem=built.problem, request=request)
        else:
            work = RepairWork(
                knowledge_base=self._knowledge_base,
                plan_net=expired.plan_net,
                problem=built.problem,
                request=request,
            )
        search = self._search(session, goal, built, request)
        limit_s = request.time_limit_s + (0.0 if search is None else CONFLICT_LIMIT_S)
        return PlanningTask(problem=built, work=work, time_limit_s=limit_s, replaces=expired, search=search)

    def _search(
        self, session: Session, goal: GoalRow, built: GoalProblem, request: PlanningRequest
    ) -> ConflictSearch | None:
        """Where the constraints are looked for that leave no plan; None if the goal has none to look for."""
        if built.refusal:
            return None
        restricted = self._problems.restrictions(session, goal, built)
        if restricted is None:
            return None
        problem, restrictions = restricted
        return ConflictSearch(problem=problem, restrictions=restrictions, request=request)

    @staticmethod
    def _tendered(
        goal: GoalRow, built: GoalProblem, request: PlanningRequest, tenders: Tenders
    ) -> PlanningTask:
        """The goal's first plan, which is not improved, or the plan with what robots have bid."""
        tender = tender_of(goal)
        if tender is None:
            request = replace(request, effort_s=0.0)
        else:
            built = replace(
                built, problem=replace(built.problem, recruits=tenders.recruits(tender, goal.world, built))
            )
        work = PlanWork(problem=built.problem, request=request)
        return PlanningTask(problem=built, work=work, time_limit_s=request.time_limit_s)

    def _forget_tender(self, session: Session, goal: GoalRow) -> None:
        is_postponed = goal.tender is not None and goal.tender["state"] == TenderState.POSTPONED
        if self._tenders is not None and goal.tender is not None and not is_postponed:
            self._tenders.release(session, goal)
            goal.tender = None

    def conclude(
        self, session: Session, subject: GoalRow, task: PlanningTask, result: WorkResult[Solutions]
    ) -> None:
        goal = subject
        goal.planned_by = None
        is_true = result.answer is not None and _is_true(result.answer[0])
        if not is_true and self._goes_on(session, goal, task, result):
            return
        tender = tender_of(goal)
        if is_true:
            self._finish(session, goal)
        elif result.answer is not None:
            self._propose(session, goal, task, result.answer[0])
        elif blockers := result.waits_for or self._declining(goal, tender, result.status):
            self._forget_tender(session, goal)
            self._wait(session, goal, blockers)
        else:
            declines = () if tender is None else tender.declines
            why = "; ".join((result.why, *declines))
            conflict = task.problem.conflict if result.is_refused else result.conflict
            if not result.is_refused:
                blamed = () if conflict is None else conflict.constraints
                why = task.problem.constraints.explaining(why, blamed)
            if conflict is not None:
                known = GoalTerms.from_json(goal.terms)
                goal.terms = known.model_copy(update={"conflict": conflict}).model_dump(mode="json")
            self._unsolvable(session, goal, result.status, why)

    def _wait(self, session: Session, goal: GoalRow, blockers: Blockers) -> None:
        goal_lifecycle.wait_for(goal, blockers)
        self._events.append(session, GoalWaiting(subject=goal.id, reason=goal.reason))
        self._waiting.look_again(session, goal)

    def _declining(self, goal: GoalRow, tender: TenderBody | None, status: PlanningStatus) -> Blockers | None:
        """The robots without whom no plan was found, and which may bid later."""
        if self._tenders is None or tender is None or status is PlanningStatus.FAILED:
            return None
        return self._tenders.passing(tender, goal.world)

    def _goes_on(
        self, session: Session, goal: GoalRow, task: PlanningTask, result: WorkResult[Solutions]
    ) -> bool:
        """True if the goal is planned once more: with the bids for its first plan, or without awards that have none."""
        tenders, requests = self._tenders, self._requests
        if tenders is None or requests is None or goal.allocation != Allocation.CONTRACT_NET:
            return False
        tender = tender_of(goal)
        if tender is None and result.answer is not None:
            net = result.answer[0].result.plan_net
            assert net is not None
            tender = tenders.call(session, goal, net, task.problem)
            goal_lifecycle.await_bids(goal)
            if tender.state == TenderState.CENTRAL:
                requests.plan_with_bids(session, goal)
        elif tender is not None and tender.state == TenderState.AWARDED and result.answer is None:
            tender = tender.without_awards()
            tender_lifecycle.plan_centrally(tender, f"no plan keeps to the awards: {result.why}")
            requests.plan_with_bids(session, goal)
        else:
            return False
        goal.tender = tender.model_dump(mode="json")
        return True

    def give_up(self, session: Session, subject: GoalRow, reason: str) -> None:
        if subject.state in goal_lifecycle.TO_BE_PLANNED:
            self._unsolvable(session, subject, PlanningStatus.FAILED, reason)

    def _unsolvable(self, session: Session, goal: GoalRow, status: PlanningStatus, reason: str) -> None:
        self._forget_tender(session, goal)
        goal_lifecycle.give_up(goal, outcome=status.value, reason=reason)
        self._events.append(session, GoalUnsolvable(subject=goal.id, reason=reason, status=status.value))

    def _finish(self, session: Session, goal: GoalRow) -> None:
        self._forget_tender(session, goal)
        finish_without_mission(session, self._events, goal, TRUE_ALREADY)

    def _propose(self, session: Session, goal: GoalRow, task: PlanningTask, solution: Solution) -> None:
        repairs = task.replaces.repaired_by(solution) if task.replaces else None
        tender = tender_of(goal)
        if self._tenders is not None and tender is not None and solution.result.plan_net is not None:
            tender = self._tenders.planned(tender, solution.result.plan_net, task.problem)
            goal.tender = tender.model_dump(mode="json")
        plan = self._proposals.propose(
            session,
            goal,
            solution,
            task.problem,
            repairs,
            tender=tender,
            edits=task.replaces.edits if task.replaces else (),
        )
        goal_lifecycle.propose(goal, plan.id, plan.reason)
        self._events.append(session, GoalPlanned(subject=goal.id, plan=plan.id))
        if goal.auto_approve:
            session.flush()
            self._approval.approve_or_expire(session, plan, goal, actor=AUTOMATIC, comment="")

    def _expired(self, session: Session, goal: GoalRow) -> ReplacedPlan | None:
        """The goal's last plan if it has expired; None if its facts are no longer in the vocabulary."""
        plan = session.get(PlanRow, goal.plan_id) if goal.plan_id else None
        if plan is None or plan.state != PlanState.EXPIRED:
            return None
        body = PlanBody.model_validate(plan.body)
        try:
            net = body.to_plan_net(self._knowledge_base)
        except KnowledgeBaseError:
            return None
        return ReplacedPlan(plan_id=plan.id, plan_net=net, edits=body.edits)


def finish_without_mission(
    session: Session, events: EventLog, goal: GoalRow, reason: str, carried_out_by: str | None = None
) -> None:
    """End a goal for which there is nothing to carry out.

    :param carried_out_by: the mission of another goal that has done it.
    """
    goal_lifecycle.finish(goal, outcome=MissionState.COMPLETED, reason=reason, carried_out_by=carried_out_by)
    events.append(session, GoalFinished(subject=goal.id, outcome=MissionState.COMPLETED, reason=reason))


def finish_with_others(session: Session, events: EventLog, goal: GoalRow, joint: GoalRow) -> None:
    """End a goal that its joint goal has carried out."""
    reason = f"carried out together with others by {joint.mission_id or joint.id}"
    finish_without_mission(session, events, goal, reason, carried_out_by=joint.mission_id)


def _is_true(solution: Solution) -> bool:
    """True if all goals are true before anything is done for them, so that there is nothing to approve."""
    net = solution.result.plan_net
    return net is not None and not (net.actions or net.late or solution.result.left_out)
