"""Plans goals that wait together: the service states one goal for as many as can be carried out now.

Planned one by one, each takes the robots that it needs and the others wait; planned together, they share them.
Only goals that leave it to the service are planned so: approved and recovered by themselves, of the same priority,
without a deadline and without constraints.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import takewhile

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.blockers import Blockers
from app.domain.events import GoalPlanned, GoalSubmitted
from app.domain.goal_language.check import blocking, check_request
from app.domain.goal_language.constraints import UNCONSTRAINED
from app.domain.goal_language.terms import GoalTerms
from app.domain.ids import new_id
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles.goal import GoalState
from app.domain.recovery_rules import Policy
from app.domain.tender_document import Allocation
from app.planning.approval import AUTOMATIC, PlanApproval
from app.planning.limits import PlanningLimits, PlanningWish
from app.planning.pool.joint import JointWork, Together
from app.planning.pool.pool import PlanningWorker, WorkerClosed
from app.planning.pool.waiting_line import Job, is_large
from app.planning.pool.work import WorkResult
from app.planning.problem_builder import GoalProblem, ProblemBuilder
from app.planning.proposals import Proposals
from app.planning.waiting_goals import BY_URGENCY, IS_DUE, STATED_BY, have_wait
from app.store import GoalRow, MissionRow
from app.store.roles import with_roles_in_force
from planner import Fact
from robots.wire import SymbolicFact
from robots.world import WorldFile

CANDIDATES = 16
"""The most goals that are looked at together."""
_DUE = select(GoalRow).where(*IS_DUE).order_by(*BY_URGENCY).limit(CANDIDATES)


class _OutOfDate(Exception):
    """Raised when the world has changed since the plan was made: nothing of it is recorded."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Task:
    """Goals that wait, the most urgent first, and one goal for all of them with its problem; it is not recorded yet."""

    goals: Sequence[GoalRow]
    joint: GoalRow
    built: GoalProblem


class JointGoals:
    """States goals for several goals that wait, with their plans."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: Mapping[str, WorldFile],
        problems: ProblemBuilder,
        proposals: Proposals,
        approval: PlanApproval,
        worker: PlanningWorker,
        limits: PlanningLimits,
        at_most: int,
    ) -> None:
        """:param worlds: their newest editions by name.
        :param at_most: so many goals are planned together; 1: each is planned by itself.
        """
        self._database = core.database
        self._events = core.events
        self._facts = core.facts
        self._knowledge_base = core.knowledge_base
        self._worlds = worlds
        self._problems = problems
        self._proposals = proposals
        self._approval = approval
        self._worker = worker
        self._limits = limits
        self._at_most = at_most

    def plan(self, world: str) -> bool | None:
        """Plan goals of the world together that wait and were last planned before the newest release.

        Those that are out of reach wait on; for those that have a plan together a goal is stated, and approved.

        :returns: False if nothing came of it, so that they are to be planned by themselves; None if there are no two
            goals to plan together, or another one is more urgent.
        """
        if self._at_most < 2:
            return None
        with self._database.read() as session:
            task = self._task(session, world)
        if task is None:
            return None
        parts = _parts(task)
        work = JointWork(
            knowledge_base=self._knowledge_base,
            problem=task.built.problem,
            withheld=task.built.withheld,
            request=self._limits.request(PlanningWish()),
            parts=parts,
            at_most=self._at_most,
        )
        has_changed: list[bool] = []

        def conclude(result: WorkResult[Together]) -> None:
            with suppress(_OutOfDate):
                has_changed.append(result.answer is not None and self._conclude(task, result.answer))

        job = Job(world=world, is_large=is_large(goals=sum(map(len, parts)), effort_s=None), binds=True)
        with suppress(WorkerClosed):  # the service ends; the workflow is recovered at its next start
            self._worker.do(work, work.request.time_limit_s, job=job, conclude=conclude)
        return any(has_changed)

    def _task(self, session: Session, world: str) -> _Task | None:
        """The goals to plan together; None if there are fewer than two, or another one is more urgent."""
        due = session.scalars(_DUE, {"world": world}).all()
        goals = list(takewhile(lambda goal: goal.priority == due[0].priority and _is_plain(goal), due))
        if len(goals) > 1:
            goals = self._agreeing(session, world, goals)
        if len(goals) < 2 or goals[0] is not due[0]:
            return None
        joint = _joint_of(goals)
        built = self._problems.build(session, joint)
        if built.refusal or len(built.problem.goals) != len(joint.goal):
            return None
        return _Task(goals=goals, joint=joint, built=built)

    def _agreeing(self, session: Session, world: str, goals: Sequence[GoalRow]) -> list[GoalRow]:
        """The first of the goals that can be asked for together in the present world."""
        file = with_roles_in_force(session, self._worlds[world])
        facts = self._facts.facts(session, world)
        chosen: list[GoalRow] = []
        asked: list[SymbolicFact] = []
        for goal in goals:
            more = [one for one in map(SymbolicFact.model_validate, goal.goal) if one not in asked]
            stated = [*asked, *more]
            issues = check_request(stated, UNCONSTRAINED, file, facts, self._knowledge_base)
            if len(more) == len(goal.goal) and not blocking(issues):
                chosen.append(goal)
                asked = stated
        return chosen

    def _conclude(self, task: _Task, together: Together) -> bool:
        """Record what came of it; True if anything is recorded.

        :raises _OutOfDate: if the plan can no longer be approved.
        """
        with self._database.write() as session:
            concerned = {task.goals[n].id for n in (*together.joined, *together.waiting)}
            query = select(GoalRow).where(GoalRow.id.in_(concerned)).order_by(GoalRow.id).with_for_update()
            rows = {goal.id: goal for goal in session.scalars(query)}
            still = {
                n: rows[goal.id]
                for n, goal in enumerate(task.goals)
                if goal.id in rows and _is_as_it_was(rows[goal.id], goal)
            }
            waiting = [n for n in together.waiting if n in still]
            for n in waiting:
                still[n].releases_seen = task.built.releases
                have_wait(session, self._events, still[n], together.waiting[n])
            joined = [still[n] for n in together.joined if n in still]
            is_stated = bool(joined) and len(joined) == len(together.joined)
            if is_stated:
                self._state(session, task, together, joined)
            return is_stated or bool(waiting)

    def _state(self, session: Session, task: _Task, together: Together, goals: Sequence[GoalRow]) -> None:
        """Record the goal that carries out these, propose its plan and approve it."""
        assert together.solution is not None
        joint = _joint_of(goals)
        joint.attempts = 1
        session.add(joint)
        session.flush()
        self._events.append(
            session, GoalSubmitted(subject=joint.id, text=joint.text, actor=STATED_BY, reason="")
        )
        goal_lifecycle.begin_planning(joint)
        plan = self._proposals.propose(session, joint, together.solution, task.built)
        goal_lifecycle.propose(joint, plan.id, plan.reason)
        self._events.append(session, GoalPlanned(subject=joint.id, plan=plan.id))
        others = "another" if len(goals) == 2 else f"{len(goals) - 1} others"
        blockers = Blockers(missions=(f"{joint.id}, which carries it out together with {others}",))
        for goal in goals:
            goal.joint_goal = joint.id
            have_wait(session, self._events, goal, blockers)
        session.flush()
        mission = self._approval.approve_or_expire(session, plan, joint, actor=AUTOMATIC, comment="")
        if mission is None:
            raise _OutOfDate
        session.get_one(MissionRow, mission).joined_goals = [goal.id for goal in goals]


def _is_plain(goal: GoalRow) -> bool:
    """Whether a goal leaves it to the service how and when it is carried out, and was not carried out so before."""
    terms = GoalTerms.from_json(goal.terms)
    return (
        goal.auto_approve
        and goal.recovery == Policy.AUTO
        and goal.allocation == Allocation.CENTRAL
        and goal.deadline_at_s is None
        and goal.joint_goal is None
        and goal.created_by != STATED_BY
        and PlanningWish.from_json(goal.limits) == PlanningWish()
        and not (terms.constraints or terms.holds or terms.not_before_at_s)
    )


def _joint_of(goals: Sequence[GoalRow]) -> GoalRow:
    """One goal for all of them, not recorded."""
    return GoalRow(
        id=new_id("goal"),
        world=goals[0].world,
        text=" and ".join(goal.text for goal in goals),
        goal=[fact for goal in goals for fact in goal.goal],
        priority=goals[0].priority,
        terms=GoalTerms().model_dump(mode="json"),
        auto_approve=True,
        recovery=Policy.AUTO.value,
        allocation=Allocation.CENTRAL.value,
        limits=PlanningWish().to_json(),
        state=GoalState.SUBMITTED,
        reason="",
        attempts=0,
        created_by=STATED_BY,
    )


def _parts(task: _Task) -> list[tuple[Fact, ...]]:
    """The facts of each goal, as the planner has them."""
    facts = iter(task.built.problem.goals)
    return [tuple(next(facts) for _ in goal.goal) for goal in task.goals]


def _is_as_it_was(now: GoalRow, before: GoalRow) -> bool:
    return (
        now.state == GoalState.WAITING
        and now.joint_goal is None
        and now.priority == before.priority
        and now.releases_seen == before.releases_seen
    )
