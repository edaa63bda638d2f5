"""The skeleton of the durable jobs that plan: a goal, alternatives to its plan, the repair of a mission's plan.

First, in one transaction, the record is locked and checked and the problem is built. Then a planning process works on
it without a lock, and its progress is watched. Last, in another transaction, the result is recorded, unless it is no
longer wanted, for example because the goal was cancelled or another process has begun to plan it. A job that keeps
failing is given up.
"""

from abc import ABC, abstractmethod
from collections.abc import Hashable
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, Generic, TypeVar

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.plan_document import DifferenceBody, RepairsBody
from app.planning.pool.pool import PlanningWorker, WorkerClosed
from app.planning.pool.process import Watch
from app.planning.pool.waiting_line import Job, Priority
from app.planning.pool.withheld import WorkUnlessBlocked
from app.planning.pool.work import Solution, Solutions, Work, WorkResult
from app.planning.problem_builder import GoalProblem
from app.planning.progress_watch import ProgressWatch
from app.planning.queueing import is_large_goal
from app.store import GoalRow, MissionRow
from app.workflows import or_give_up, step
from planner import PlanNet, PlanningStatus


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplacedPlan:
    """A plan of a goal that is to be replaced: it has expired, or a mission cannot go on with it."""

    plan_id: str
    plan_net: PlanNet

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
    """

    problem: GoalProblem
    work: Work[Solutions]
    time_limit_s: float
    replaces: ReplacedPlan | None = None
    is_under_way: bool = False


Row = TypeVar("Row", GoalRow, MissionRow)
Task = TypeVar("Task", bound=PlanningTask)


class PlanningJob(ABC, Generic[Row, Task]):
    """A durable job that plans for a goal or a mission, the subject."""

    step_name: ClassVar[str]
    """The name that the workflow's step is recorded under."""
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
            goal = _goal_of(session, subject)
            goal_id = goal.id
            job = Job(world=goal.world, priority=self.priority, is_large=is_large_goal(goal))

        def is_wanted(session: Session) -> bool:
            return self.attempt_key(self.load(session, subject_id, lock=False)) == key

        watch = ProgressWatch(self._database, self._events, goal_id, is_wanted=is_wanted, clock=self._clock)
        try:
            result = self._result(task, watch, job)
        except WorkerClosed:  # the service ends; the job is recovered at its next start
            return
        with self._database.write() as session:
            subject = self.load(session, subject_id, lock=True)
            _goal_of(session, subject).planning = None
            if self.attempt_key(subject) == key:
                self.conclude(session, subject, task, result)

    def _give_up(self, subject_id: str, reason: str) -> None:
        with self._database.write() as session:
            subject = self.load(session, subject_id, lock=True)
            _goal_of(session, subject).planning = None
            self.give_up(session, subject, reason)

    def _result(self, task: Task, watch: Watch, job: Job) -> WorkResult[Solutions]:
        problem = task.problem
        work = task.work
        if problem.withheld:
            work = WorkUnlessBlocked(
                work=work,
                problem=None if task.is_under_way else problem.problem,
                withheld=problem.withheld,
                knowledge_base=self._knowledge_base,
                refusal=problem.refusal,
            )
        elif problem.refusal:
            return WorkResult(status=PlanningStatus.UNSOLVABLE, reason=problem.refusal)
        return self._worker.do(work, task.time_limit_s, watch, job)


def _goal_of(session: Session, subject: GoalRow | MissionRow) -> GoalRow:
    return subject if isinstance(subject, GoalRow) else session.get_one(GoalRow, subject.goal_id)
