"""Operators have what a mission has not done planned again, or look first at what would come of it."""

import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.errors import Busy, Conflict, Invalid, Unavailable, unrecorded
from app.domain.events import MissionReplanRequested
from app.domain.goal_language.terms import GoalTerms
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import MissionState, is_paused
from app.domain.lifecycles.recovery import ask_for_plan, troubles_of
from app.domain.plan_document import PlanBody
from app.domain.plan_edits import Pins, PlanEdit, words_of
from app.domain.recovery_rules import left_out
from app.domain.world_model.vocabulary import symbolic
from app.missions.mission_service import Mission, mission_row, refuse_ended, with_scripts
from app.missions.repair_tasks import RepairTask, RepairTasks
from app.planning.job import permitted, work_of
from app.planning.pool.pool import PlanningWorker, WorkerClosed
from app.planning.pool.process import Deadline
from app.planning.pool.waiting_line import Job, Priority, is_large
from app.planning.pool.work import Solutions, WorkResult
from app.planning.problem_builder import GoalProblem, ProblemBuilder
from app.planning.waiting_goals import WaitingGoals
from app.store import GoalRow, MissionRow, PlanRow
from app.store.records import joint_goal_of, lock_goals
from planner import GOAL
from planner.repair import unkept_pins
from robots.clock import Clock
from robots.wire import SymbolicFact

PREVIEW_LIMIT_S = 10.0
"""Longest planning of a preview: a request waits for it."""
MAX_CONCURRENT = 4
"""Previews at a time: each holds one of the threads that requests are answered in."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Achieved:
    """A goal, and when it would be true, world seconds from now; 0: it is true already."""

    goal: SymbolicFact
    in_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionPreview:
    """What would come of having a mission planned again now, its robots stopped where they are.

    :param plan_id: the plan that is carried out.
    :param reason: why there is no plan; empty if there is one. Without one, the numbers are None and the rest is empty.
    :param ends_in_s: when all goals would be true, from now, world seconds.
    :param expected_in_s: when the mission is expected to end by its present plan, from now; None before it has begun.
    :param robots: those of the plan.
    :param changes: what becomes of the present plan's actions, in words.
    :param achieved: when each goal would be true.
    :param unkept: what the plan does not keep to of the edits, in words.
    """

    plan_id: str
    made_at_s: float
    reason: str = ""
    ends_in_s: float | None = None
    expected_in_s: float | None = None
    robots: Sequence[str] = ()
    changes: Sequence[str] = ()
    achieved: Sequence[Achieved] = ()
    unkept: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Previewed:
    """What is planned for a preview, and what its result is compared with."""

    world: str
    task: RepairTask
    pins: Pins
    is_large: bool
    made_at_s: float
    expected_in_s: float | None


class MissionReplanning:
    """Has missions under way planned again, and previews it."""

    def __init__(
        self,
        core: Core,
        *,
        problems: ProblemBuilder,
        tasks: RepairTasks,
        worker: PlanningWorker,
        waiting: WaitingGoals,
        clocks: Mapping[str, Clock],
        clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """:param clocks: the worlds' clocks by the world's name."""
        self._database = core.database
        self._events = core.events
        self._workflows = core.workflows
        self._plan_nets = core.plan_nets
        self._knowledge_base = core.knowledge_base
        self._problems = problems
        self._tasks = tasks
        self._worker = worker
        self._waiting = waiting
        self._clocks = clocks
        self._clock = clock
        self._slots = threading.BoundedSemaphore(MAX_CONCURRENT)

    def replan(
        self,
        mission_id: str,
        edits: Sequence[PlanEdit],
        actor: str,
        comment: str,
        *,
        goals: Sequence[str] = (),
    ) -> Mission:
        """Have what the mission's robots have not done planned again, with something pinned. They stop meanwhile.

        :param goals: that wait, by id; the mission is to carry them out, too.
        :raises Conflict: if the mission has ended, is being cancelled or recovered, is paused, or is planned again
            already; if one of the goals does not wait, or cannot be true together with the mission's goal.
        :raises Invalid: if an edit cannot be meant of its plan, or a goal is not one that it can carry out, too.
        :raises NotFound: if the mission or a goal is not recorded.
        """
        with self._database.write() as session:
            own = session.scalar(select(MissionRow.goal_id).where(MissionRow.id == mission_id))
            # lock order: the goals before the mission
            rows = lock_goals(session, (*goals, *(() if own is None else (own,))))
            mission = mission_row(session, mission_id, to_change=True)
            pins, joining = self._asked(session, mission, rows, edits, goals)
            words = words_of(pins)
            reason = ": ".join(filter(None, ("an operator has asked for another plan", comment or words)))
            ask_for_plan(
                mission,
                pins=[pin.model_dump(mode="json") for pin in pins],
                goals=[goal.id for goal in joining],
                reason=reason,
            )
            for goal in joining:
                self._waiting.join(session, goal, mission)
            self._events.append(
                session,
                MissionReplanRequested(
                    subject=mission.id,
                    actor=actor,
                    comment=comment,
                    pinned=words,
                    goals=tuple(goal.id for goal in joining),
                    state=MissionState(mission.state),
                ),
            )
            self._workflows.wake(session, mission.workflow)
            return with_scripts(session, mission)

    def preview(
        self,
        mission_id: str,
        edits: Sequence[PlanEdit],
        *,
        goals: Sequence[str] = (),
        priority: Priority = Priority.EXPLANATION,
    ) -> MissionPreview:
        """What would come of `replan` now; the robots go on meanwhile.

        Actions under way are taken to go on from where robots are, as after a stop; with edits, which may be about
        them, they count as not done.

        :raises Conflict, Invalid, NotFound: as `replan`.
        :raises Busy: if too many previews are being made.
        :raises Unavailable: if the service ends meanwhile.
        """
        with self._database.read() as session:
            previewed = self._previewed(session, mission_id, edits, goals)
        if not self._slots.acquire(blocking=False):
            raise Busy(f"{MAX_CONCURRENT} previews are being made; ask again later", code="too-many-previews")
        try:
            return self._preview_of(previewed, self._plan(previewed, priority))
        finally:
            self._slots.release()

    def _previewed(
        self, session: Session, mission_id: str, edits: Sequence[PlanEdit], goals: Sequence[str]
    ) -> _Previewed:
        mission = mission_row(session, mission_id)
        query = select(GoalRow).where(GoalRow.id.in_((mission.goal_id, *goals)))
        rows = {goal.id: goal for goal in session.scalars(query)}
        pins, joining = self._asked(session, mission, rows, edits, goals)
        task = self._tasks.of(
            session,
            mission,
            rows[mission.goal_id],
            without=left_out(troubles_of(mission)),
            pins=pins,
            joining=[goal.id for goal in joining],
            is_thorough=True,
            runs_on=not pins,
        )
        request = replace(
            task.work.request, time_limit_s=min(task.work.request.time_limit_s, PREVIEW_LIMIT_S)
        )
        now_s = self._clocks[mission.world].now_s()
        begun_s = mission.started_at_s
        return _Previewed(
            world=mission.world,
            task=replace(task, work=replace(task.work, request=request), time_limit_s=request.time_limit_s),
            pins=pins,
            is_large=is_large(goals=len(task.work.problem.goals), effort_s=request.effort_s),
            made_at_s=now_s,
            expected_in_s=None if begun_s is None else max(0.0, begun_s + mission.estimate_s - now_s),
        )

    def _asked(
        self,
        session: Session,
        mission: MissionRow,
        rows: Mapping[str, GoalRow],
        edits: Sequence[PlanEdit],
        goals: Sequence[str],
    ) -> tuple[Pins, Sequence[GoalRow]]:
        """What edits pin of the mission's plan, and the goals that are to join it.

        :param rows: its goal and those that are to join it, by id.
        """
        _refuse_to_replan(mission)
        own = rows[mission.goal_id]
        joining = [_to_join(session, rows, one, own) for one in dict.fromkeys(goals)]
        if not (edits or joining):
            return (), ()
        built = self._problems.build(session, own, joining=[goal.id for goal in joining])
        if joining and built.refusal:
            raise Conflict(
                f"mission {mission.id} cannot carry them out, too: {built.refusal}", code="cannot-join"
            )
        return self._pins(session, mission, built, edits), joining

    def _pins(
        self, session: Session, mission: MissionRow, built: GoalProblem, edits: Sequence[PlanEdit]
    ) -> Pins:
        plan = session.get_one(PlanRow, mission.plan_id)
        pinned = self._problems.pinned(built, PlanBody.model_validate(plan.body).edits)
        net = self._plan_nets.of(session, plan.id)
        return self._problems.pins(edits, net, pinned.problem, world=mission.world)

    def _plan(self, previewed: _Previewed, priority: Priority) -> WorkResult[Solutions]:
        task = previewed.task
        job = Job(world=previewed.world, priority=priority, is_large=previewed.is_large)
        try:
            result = self._worker.do(
                work_of(task, self._knowledge_base),
                task.time_limit_s,
                Deadline(self._clock, 2 * PREVIEW_LIMIT_S),
                job,
            )
        except WorkerClosed:
            raise Unavailable("the service ends") from None
        return permitted(task.problem, result)

    def _preview_of(self, previewed: _Previewed, result: WorkResult[Solutions]) -> MissionPreview:
        net = None if result.answer is None else result.answer[0].result.plan_net
        if result.answer is None or net is None:
            why = result.waits_for.reason if result.waits_for else result.why
            return MissionPreview(
                plan_id=previewed.task.replaces.plan_id,
                made_at_s=previewed.made_at_s,
                expected_in_s=previewed.expected_in_s,
                reason=why,
            )
        repair = result.answer[0].repair
        ends_s = {action.id: action.earliest_end_s for action in net.actions}
        problem = previewed.task.problem.problem
        unkept = {
            symbolic(goal, self._knowledge_base) for goal in unkept_pins(net, problem, self._knowledge_base)
        }
        return MissionPreview(
            plan_id=previewed.task.replaces.plan_id,
            made_at_s=previewed.made_at_s,
            ends_in_s=max(ends_s.values(), default=0.0),
            expected_in_s=previewed.expected_in_s,
            robots=tuple(sorted({agent for action in net.actions for agent in action.agents})),
            changes=repair.difference.words if repair is not None and repair.difference is not None else (),
            achieved=tuple(
                Achieved(goal=symbolic(link.fact, self._knowledge_base), in_s=ends_s.get(link.producer, 0.0))
                for link in net.causal_links
                if link.consumer == GOAL
            ),
            unkept=words_of(tuple(pin for pin in previewed.pins if pin.goal in unkept)),
        )


def _refuse_to_replan(mission: MissionRow) -> None:
    refuse_ended(mission, "planned again")
    if mission.cancel_requested:
        raise Conflict(f"mission {mission.id} is being cancelled", code="being-cancelled")
    if mission.replanning is not None:
        raise Conflict(f"mission {mission.id} is being planned again already", code="being-replanned")
    if is_paused(mission):
        raise Conflict(
            f"mission {mission.id} is paused; resume it, then have it planned again", code="mission-paused"
        )
    if mission.state == MissionState.RECOVERING:
        raise Conflict(f"mission {mission.id} is being recovered: {mission.reason}", code="being-recovered")


def _to_join(session: Session, rows: Mapping[str, GoalRow], goal_id: str, own: GoalRow) -> GoalRow:
    """A goal that waits, or is just planned by itself, and that the mission for the goal `own` can carry out, too."""
    goal = rows.get(goal_id)
    if goal is None:
        raise unrecorded("goal", goal_id)
    joint = joint_goal_of(session, goal)
    if joint is not None and joint.state in goal_lifecycle.OPEN:
        raise Conflict(
            f"goal {goal.id} is carried out by mission {joint.mission_id} together with others",
            code="goal-committed",
        )
    is_tried_again = goal.state == GoalState.PLANNING and goal.tender is None
    if goal.state != GoalState.WAITING and not is_tried_again:
        raise Conflict(
            f"goal {goal.id} is {goal.state}; only goals that wait can join", code="goal-not-waiting"
        )
    if goal.world != own.world:
        raise Invalid(f"goal {goal.id} is of world {goal.world}, not of {own.world}", code="other-world")
    terms = GoalTerms.from_json(goal.terms)
    if terms.constraints or terms.holds or terms.not_before_at_s or goal.deadline_at_s is not None:
        raise Invalid(
            f"goal {goal.id} has constraints, holds or times of its own; it is planned by itself",
            code="cannot-join",
        )
    constraints = GoalTerms.from_json(own.terms).constraints
    if constraints.stages or constraints.worth:
        raise Invalid(
            f"goal {own.id} of the mission has an order or optional parts; no other goal can join it",
            code="cannot-join",
        )
    return goal
