"""The skeleton of the durable jobs that plan: a goal, alternatives to its plan, the repair of a mission's plan.

First, in one transaction, the record is locked and checked and the problem is built. Then a planning process works on
it without a lock, and its progress is watched. Last, in another transaction, the result is recorded, unless it is no
longer wanted, for example because the goal was cancelled or another process has begun to plan it. A job that keeps
failing is given up.
"""

from abc import ABC, abstractmethod
from collections.abc import Hashable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar, Generic, TypeVar

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.blockers import Blockers
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.plan_document import DifferenceBody, RepairsBody
from app.domain.plan_edits import Pins
from app.planning.pool.conflicts import ConflictSearch, WorkUnderConstraints
from app.planning.pool.pool import PlanningWorker, WorkerClosed
from app.planning.pool.waiting_line import Job, Priority
from app.planning.pool.withheld import WorkUnlessBlocked
from app.planning.pool.work import Solution, Solutions, Work, WorkResult
from app.planning.problem_builder import GoalProblem
from app.planning.progress_watch import ProgressWatch
from app.planning.queueing import is_large_goal
from app.store import Database, GoalRow, MissionRow
from app.workflows import or_give_up, step
from planner import KnowledgeBase, PlanNet, PlanningStatus


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplacedPlan:
    """A plan of a goal that is to be replaced: it has expired, or a mission cannot go on with it."""

    plan_id: str
    plan_net: PlanNet
    edits: Pins = ()

    def repaired_by(self, solution: Solution) -> RepairsBody | None:
        """How the solution repairs this plan; None if it was not made from it."""
        repair = solution.repair
        if repair is None or repair.difference is None:
            return None
        difference = DifferenceBody.model_validate(repair.difference, from_attributes=True)
        return RepairsBody(plan_id=self.plan_id, course=repair.course, difference=difference)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanningTask:
    """What is planned in one attempt of a job.

    :param time_limit_s: of the work, from when a process begins it.
    :param replaces: the plan that the work repairs.
    :param is_under_way: that plan is carried out, so that its actions will change the problem's facts.
    :param search: where the constraints are looked for that leave no plan, if there is none; None: they are not.
    """

    problem: GoalProblem
    work: Work[Solutions]
    time_limit_s: float
    replaces: ReplacedPlan | None = None
    is_under_way: bool = False
    search: ConflictSearch | None = None


Row = TypeVar("Row", GoalRow, MissionRow)
Task = TypeVar("Task", bound=PlanningTask)


class PlanningJob(ABC, Generic[Row, Task]):
    """A durable job that plans for a goal or a mission, the subject."""

    step_name: ClassVar[str]
    """The name of the workflow's step, in the log and in the reason of a job that is given up."""
    priority: ClassVar[Priority]

    def __init__(self, core: Core, *, worker: PlanningWorker, clock: WallClock = SYSTEM_CLOCK) -> None:
        self._database = core.database
        self._events = core.events
        self._knowledge_base = core.knowledge_base
        self._worker = worker
        self._clock = clock

    @abstractmethod
    def load(self, session: Session, subject_id: str, *, lock: bool) -> Row:
        """Read the subject, with `lock` locked; a mission's goal is locked before the mission."""

    @abstractmethod
    def begin(self, session: Session, subject: Row) -> Task | None:
        """Build what is to be planned, and record that planning begins; None if no plan is wanted any longer."""

    def renew(self, session: Session, subject: Row, task: Task) -> Task:
        """The task in the present world, after it has waited for a planning process; the same unless overridden."""
        return task

    def binds(self, subject: Row) -> bool:
        """Whether the result may reserve something without anybody's decision."""
        return False

    @abstractmethod
    def attempt_key(self, subject: Row) -> Hashable:
        """Identifies the present planning attempt; None while no plan is wanted.

        A result is recorded only if the key has not changed since its attempt began.
        """

    @abstractmethod
    def conclude(self, session: Session, subject: Row, task: Task, result: WorkResult[Solutions]) -> None:
        """Record the result."""

    @abstractmethod
    def give_up(self, session: Session, subject: Row, reason: str) -> None:
        """Record that planning keeps failing, if a plan is wanted."""

    def run(self, subject_id: str) -> None:
        """The workflow."""
        or_give_up(
            lambda: step(self.step_name, lambda: self.plan_once(subject_id)),
            partial(self._give_up, subject_id),
        )

    def plan_once(self, subject_id: str) -> None:
        """The workflow's step: plan for the subject if a plan is wanted, and record the result if it still is."""
        with self._database.write() as session:
            subject = self.load(session, subject_id, lock=True)
            task = self.begin(session, subject)
            if task is None:
                return
            key = self.attempt_key(subject)
            attempt = _Attempt(self, self._database, self._knowledge_base, subject_id, task, key)
            goal = _goal_of(session, subject)
            goal_id = goal.id
            job = Job(
                world=goal.world,
                priority=self.priority,
                is_large=is_large_goal(goal),
                binds=self.binds(subject),
            )
        if task.problem.refusal and not task.problem.withheld:
            refusal = task.problem.refusal
            attempt.conclude(WorkResult(status=PlanningStatus.UNSOLVABLE, reason=refusal, is_refused=True))
            return
        watch = ProgressWatch(
            self._database, self._events, goal_id, is_wanted=attempt.is_wanted, clock=self._clock
        )
        with suppress(WorkerClosed):  # the service ends; the job is recovered at its next start
            self._worker.do(
                work_of(task, self._knowledge_base),
                task.time_limit_s,
                watch,
                job,
                renew=attempt.renew,
                conclude=attempt.conclude,
            )

    def _give_up(self, subject_id: str, reason: str) -> None:
        with self._database.write() as session:
            subject = self.load(session, subject_id, lock=True)
            _goal_of(session, subject).planning = None
            self.give_up(session, subject, reason)


class _Attempt(Generic[Row, Task]):
    """One planning of a subject, from its task to the record of the result."""

    def __init__(
        self,
        job: PlanningJob[Row, Task],
        database: Database,
        knowledge_base: KnowledgeBase,
        subject_id: str,
        task: Task,
        key: Hashable,
    ) -> None:
        self._job: PlanningJob[Row, Task] = job
        self._database = database
        self._knowledge_base = knowledge_base
        self._subject_id = subject_id
        self._task = task
        self._key = key

    def is_wanted(self, session: Session) -> bool:
        return self._job.attempt_key(self._job.load(session, self._subject_id, lock=False)) == self._key

    def renew(self) -> Work[Solutions]:
        """The work in the present world."""
        with self._database.write() as session:
            subject = self._job.load(session, self._subject_id, lock=True)
            if self._job.attempt_key(subject) == self._key:
                self._task = self._job.renew(session, subject, self._task)
                self._key = self._job.attempt_key(subject)
        return work_of(self._task, self._knowledge_base)

    def conclude(self, result: WorkResult[Solutions]) -> None:
        """Record the result, if it is still wanted."""
        with self._database.write() as session:
            subject = self._job.load(session, self._subject_id, lock=True)
            _goal_of(session, subject).planning = None
            if self._job.attempt_key(subject) == self._key:
                self._job.conclude(session, subject, self._task, permitted(self._task.problem, result))


def work_of(task: PlanningTask, knowledge_base: KnowledgeBase) -> Work[Solutions]:
    """The task's work, which may turn out to have to wait for what its problem leaves out."""
    problem = task.problem
    work = task.work
    if problem.withheld or problem.refusal:
        work = WorkUnlessBlocked(
            work=work,
            problem=None if task.is_under_way else problem.problem,
            withheld=problem.withheld,
            knowledge_base=knowledge_base,
            refusal=problem.refusal,
        )
    return work if task.search is None else WorkUnderConstraints(work=work, search=task.search)


def permitted(built: GoalProblem, result: WorkResult[Solutions]) -> WorkResult[Solutions]:
    """The result without plans that fill a place that is to be kept empty, or end a kept fact; without any, why.

    The facts of a problem say that such a place has no room; if it is emptied by the plan itself, they do not. Nor do
    they keep a plan from ending for a time what its goal asks for and is true already.
    """
    nets = [] if result.answer is None else [one.result.plan_net for one in result.answer]
    broken = [built.constraints.broken_by(net) if net is not None else () for net in nets]
    if result.answer is None or not any(broken):
        return result
    kept = tuple(one for one, wrong in zip(result.answer, broken, strict=True) if not wrong)
    if kept:
        return replace(result, answer=kept)
    first = next(wrong for wrong in broken if wrong)
    return WorkResult(
        status=PlanningStatus.UNSOLVABLE,
        reason=f"the plan that was found breaks a constraint: {'; '.join(first)}",
        waits_for=Blockers(holds=tuple(built.withheld.holds)),
    )


def _goal_of(session: Session, subject: GoalRow | MissionRow) -> GoalRow:
    return subject if isinstance(subject, GoalRow) else session.get_one(GoalRow, subject.goal_id)
