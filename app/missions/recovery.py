"""A mission's recovery: a durable workflow repairs its plan, and approves or proposes it by the recovery policy."""

from collections.abc import Callable, Collection, Hashable, Mapping, Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.blockers import Blockers
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.events import MissionRepairProposed, MissionStuck
from app.domain.lifecycles import recovery
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import MissionState, has_ended
from app.domain.lifecycles.recovery import RecoveryStep, goes_back, troubles_of
from app.domain.mission_monitor import MissionView, Verdict
from app.domain.plan_edits import GoalPin, Pins
from app.domain.recovery_rules import (
    LeftOut,
    Policy,
    Trouble,
    left_out,
    measure_of,
    needs_decision,
)
from app.domain.world_model.beliefs import OBJECT_POSITION
from app.missions.out_of_service import OutOfService
from app.missions.repair_tasks import RepairTask, RepairTasks
from app.planning.approval import RECOVERY, PlanApproval
from app.planning.job import PlanningJob
from app.planning.pool.pool import PlanningWorker
from app.planning.pool.waiting_line import Priority
from app.planning.pool.work import Solution, Solutions, WorkResult
from app.planning.proposals import Proposals
from app.planning.requests import PlanningRequests
from app.planning.tenders import Tenders
from app.planning.waiting_goals import WaitingGoals
from app.store import GoalRow, MissionRow
from app.store.event_log import EventLog
from app.store.records import lock_goals, lock_mission
from robots.clock import Clock

RETRY_BLOCKED_S = 20.0
"""Least time, in world seconds, before planning is tried again when other missions blocked it (our choice)."""


class RecoverySteps:
    """Carries out the recovery steps that the mission monitor decides on."""

    def __init__(self, events: EventLog, *, requests: PlanningRequests) -> None:
        self._events = events
        self._requests = requests

    def take(self, session: Session, mission: MissionRow, view: MissionView, verdict: Verdict) -> None:
        """Begin to plan a repair, or record that the mission is stuck, as the monitor's verdict says."""
        if verdict.recover is RecoveryStep.PLANNING:
            failure = None if view.category is None else view.category.value
            self._requests.recover(session, mission, view.troubles, failure=failure, reason=verdict.reason)
        else:
            recovery.get_stuck(mission)
            state = MissionState(mission.state)
            self._events.append(session, MissionStuck(subject=mission.id, reason=verdict.reason, state=state))


class RecoveryJob(PlanningJob[MissionRow, RepairTask]):
    """Repairs the plans of missions."""

    step_name = "recover"
    priority = Priority.RECOVERY

    def __init__(
        self,
        core: Core,
        *,
        tasks: RepairTasks,
        proposals: Proposals,
        worker: PlanningWorker,
        clocks: Mapping[str, Clock],
        requests: PlanningRequests,
        approval: PlanApproval,
        out_of_service: OutOfService,
        peripherals: Callable[[str], Collection[str]],
        waiting: WaitingGoals,
        tenders: Tenders | None = None,
        clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """:param peripherals: by world, the names of its doors, hatches and lifts.
        :param tenders: None: robots do not bid for goals.
        """
        super().__init__(core, worker=worker, clock=clock)
        self._tasks = tasks
        self._proposals = proposals
        self._clocks = clocks
        self._requests = requests
        self._approval = approval
        self._out_of_service = out_of_service
        self._peripherals = peripherals
        self._waiting = waiting
        self._tenders = tenders

    def load(self, session: Session, subject_id: str, *, lock: bool) -> MissionRow:
        mission = session.get_one(MissionRow, subject_id)
        if not lock:
            return mission
        others = (*recovery.goals_beside(mission), *recovery.goals_left_out(mission))
        if others:  # lock order: the goals before the mission
            lock_goals(session, (mission.goal_id, *others))
        return lock_mission(session, subject_id)

    def binds(self, subject: MissionRow) -> bool:
        return True

    def attempt_key(self, subject: MissionRow) -> Hashable:
        return len(subject.attempts) if _is_wanted(subject) else None

    def begin(self, session: Session, subject: MissionRow) -> RepairTask | None:
        mission = subject
        if not _is_wanted(mission):
            return None
        self._part_with(session, mission)
        goal = session.get_one(GoalRow, mission.goal_id)
        goal.stop_requested = False  # the request was for an earlier planning attempt
        troubles = troubles_of(mission)
        without = left_out(troubles)
        failing = _failing(troubles, without, self._peripherals(mission.world))
        self._out_of_service.take_out_failing(session, mission.world, failing)
        recovery.note_left_out(mission, without.words)
        return self._tasks.of(
            session,
            mission,
            goal,
            without=without,
            failing=frozenset(failing),
            pins=_newly_pinned(mission),
            is_thorough=mission.replanning is not None,
        )

    def conclude(
        self, session: Session, subject: MissionRow, task: RepairTask, result: WorkResult[Solutions]
    ) -> None:
        if result.answer is not None:
            self._propose(session, subject, task, result.answer[0])
        elif recovery.asked_goals(subject):
            self._leave_goals_out(
                session, subject, result.waits_for.reason if result.waits_for else result.why
            )
        elif result.waits_for:
            self._wait(session, subject, result.waits_for)
        else:
            self._requests.end_without_plan(session, subject, _failure_reason(result.why, task))

    def give_up(self, session: Session, subject: MissionRow, reason: str) -> None:
        if _is_wanted(subject) and recovery.asked_goals(subject):
            self._leave_goals_out(session, subject, reason)
        elif _is_wanted(subject):
            self._requests.end_without_plan(session, subject, reason)

    def _leave_goals_out(self, session: Session, mission: MissionRow, why: str) -> None:
        """Have the mission planned without the goals that it was to carry out, too: there is no plan with them."""
        reason = f"there is no plan with {', '.join(recovery.asked_goals(mission))}: {why}"
        recovery.leave_goals_out(mission, reason)
        self._requests.recover(session, mission, (), failure=None, reason=reason)

    def _part_with(self, session: Session, mission: MissionRow) -> None:
        """Have the goals planned by themselves that plans were asked for in vain."""
        for goal in session.scalars(select(GoalRow).where(GoalRow.id.in_(recovery.goals_left_out(mission)))):
            if goal.joint_goal == mission.goal_id and goal.state == GoalState.WAITING:
                self._waiting.part(session, goal, mission)

    def _propose(self, session: Session, mission: MissionRow, task: RepairTask, solution: Solution) -> None:
        """Propose the repaired plan; approve it at once if the recovery policy allows."""
        goal = session.get_one(GoalRow, mission.goal_id)
        repair = solution.repair
        assert repair is not None
        repairs = task.replaces.repaired_by(solution)
        tender, net = task.tender, solution.result.plan_net
        if tender is not None and net is not None and self._tenders is not None:
            tender = self._tenders.planned(tender, net, task.problem)
        plan = self._proposals.propose(
            session, goal, solution, task.problem, repairs, tender=tender, edits=task.replaces.edits
        )
        # NOTE: the operator has decided already if the old plan does not use what is left out.
        measure = measure_of(repair.course, without=task.left_out.concerns(task.replaces.plan_net))
        words = repair.difference.words if repair.difference else ()
        recovery.propose(mission, plan_id=plan.id, measure=measure, detail="; ".join(words[:1]))
        goal.plan_id = plan.id
        session.flush()
        if needs_decision(Policy(mission.recovery), measure) and not goes_back(mission):
            recovery.ask_operator(mission)
            mission.reason = f"{mission.attempts[-1]['reason']}; plan {plan.id} waits for a decision"
            self._events.append(
                session,
                MissionRepairProposed(
                    subject=mission.id,
                    plan=plan.id,
                    measure=measure.value,
                    reason=mission.reason,
                    state=MissionState(mission.state),
                ),
            )
        else:
            self._approval.approve_or_expire(session, plan, goal, actor=RECOVERY, comment="")

    def _wait(self, session: Session, mission: MissionRow, waits_for: Blockers) -> None:
        """Let the mission wait for the blockers, and schedule another attempt."""
        now_s = self._clocks[mission.world].now_s()
        mission.enquire_at_s = now_s + max(RETRY_BLOCKED_S, mission.original_estimate_s / 2)
        recovery.wait_for(mission, waits_for)
        self._requests.wake_after_attempt(session, mission)


def _newly_pinned(mission: MissionRow) -> Pins:
    """What the operator pins who has asked for another plan."""
    asked = mission.replanning or {"pins": ()}
    return tuple(GoalPin.model_validate(pin) for pin in asked["pins"])


def _is_wanted(mission: MissionRow) -> bool:
    return mission.recovery_step == RecoveryStep.PLANNING and not has_ended(mission)


def _failing(
    troubles: Sequence[Trouble], without: LeftOut, peripherals: Collection[str]
) -> Mapping[str, str]:
    """The peripherals that failed so often that they are left out, each with what it said last."""
    often = {name for name, _ in without.packets} | {
        one.robot for one in troubles if one.fit
    } & without.robots
    names = often & set(peripherals)
    return {one.robot: one.detail for one in troubles if one.robot in names}


def _failure_reason(reason: str, task: RepairTask) -> str:
    """Why no plan was found, which robots and packets were left out, and what the robots left out hold."""
    without = task.left_out.words
    others = f" without {', '.join(without)}" if without else ""
    held = [
        fact
        for fact in sorted(task.problem.withheld.whole.facts)
        if fact.predicate == OBJECT_POSITION and fact.args[2] in task.left_out.robots
    ]
    return "; ".join(
        [f"no plan was found{others}: {reason}", *(f"{fact.args[2]} holds {fact.args[0]}" for fact in held)]
    )
