"""A mission's recovery as a durable workflow: its plan repaired, and approved or proposed as the operator wished."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.mission_monitor import MissionView, Verdict
from app.domain.plan_document import RepairsBody
from app.domain.recovery_rules import LeftOut, Policy, Step, category_of, left_out, measure_of, needs_decision
from app.domain.states import MissionState
from app.domain.world_model.beliefs import OBJECT_POSITION
from app.missions.recovery_watch import RecoveryWatch
from app.planning.approval import RECOVERY, PlanApproval
from app.planning.limits import PlanningLimits, PlanningWish
from app.planning.mission_progress import note, progress_of, troubles_of
from app.planning.pool.pool import PlanningWorker, WorkerClosed
from app.planning.pool.process import WorkFailed
from app.planning.problem_builder import GoalProblem, ProblemBuilder
from app.planning.proposals import Proposals
from app.planning.repairs import RepairWork, ReplacedPlan
from app.planning.requests import PlanningRequests
from app.store import GoalRow, MissionRow, ScriptRow
from app.store.records import lock_mission
from app.workflows import or_give_up, step
from planner.repair import Repair
from robots.clock import Clock

LOOK_AGAIN_S = 20.0
"""World seconds after which a plan is sought again that others kept from being made, at least (our choice)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Sought:
    """A repair that is sought."""

    posed: GoalProblem
    old: ReplacedPlan
    work: RepairWork
    left_out: LeftOut


class MissionRecovery:
    """Takes the steps of missions' recovery that the monitor asks for."""

    def __init__(
        self,
        core: Core,
        *,
        posing: ProblemBuilder,
        proposing: Proposals,
        worker: PlanningWorker,
        limits: PlanningLimits,
        clocks: Mapping[str, Clock],
        requests: PlanningRequests,
        approval: PlanApproval,
    ) -> None:
        self._core, self._database, self._events = core, core.database, core.events
        self._posing, self._proposing, self._worker = posing, proposing, worker
        self._limits, self._clocks = limits, clocks
        self._requests = requests
        self._approval = approval

    def take(self, session: Session, mission: MissionRow, view: MissionView, verdict: Verdict) -> None:
        """Take the step that the monitor's verdict names."""
        if verdict.recover is Step.PLANNING:
            # An attempt that waited for others repeats the last one; its troubles are counted already.
            troubles = () if view.step is Step.WAITING else view.troubles
            failure = category_of(view.troubles).value
            self._requests.recover(session, mission, troubles, failure=failure, reason=verdict.reason)
        else:
            mission.recovery_step = verdict.recover
            self._events.append(session, "mission.stuck", mission.id, reason=verdict.reason)

    def run(self, mission_id: str) -> None:
        """The workflow."""
        or_give_up(
            lambda: step("recover", lambda: self._recover(mission_id)), partial(self._give_up, mission_id)
        )

    def _give_up(self, mission_id: str, reason: str) -> None:
        with self._database.write() as session:
            mission = lock_mission(session, mission_id)
            session.get_one(GoalRow, mission.goal_id).planning = None
            if _is_sought(mission):
                self._requests.end_without_plan(session, mission, reason)

    def _recover(self, mission_id: str) -> None:
        with self._database.write() as session:
            mission = session.get_one(MissionRow, mission_id, with_for_update=True)
            if not _is_sought(mission):
                return
            sought = self._sought(session, mission)
            note(mission, without=list(sought.left_out.words))
            attempt = len(mission.attempts)
            watch = RecoveryWatch(self._database, self._events, mission)
        repair: Repair | None = None
        reason = sought.posed.refusal
        try:
            if not reason:
                repair = self._worker.do(sought.work, sought.work.request.time_limit_s, watch)
                reason = repair.result.reason or repair.result.status.value
        except WorkFailed as failure:
            reason = failure.reason
        except WorkerClosed:  # the service ends; this workflow is taken up again when it is back
            return
        with self._database.write() as session:
            mission = lock_mission(session, mission_id)
            session.get_one(GoalRow, mission.goal_id).planning = None
            # The next attempt may have begun meanwhile, if another process has taken this one over.
            if not _is_sought(mission) or len(mission.attempts) != attempt:
                return
            if repair is not None and repair.plan_net is not None:
                self._found(session, mission, sought, repair)
            elif sought.posed.waits_for and not sought.posed.why_never(self._core.knowledge_base):
                self._wait(session, mission, sought.posed)
            else:
                self._requests.end_without_plan(session, mission, _in_words(reason, sought))

    def _sought(self, session: Session, mission: MissionRow) -> _Sought:
        goal = session.get_one(GoalRow, mission.goal_id)
        without = left_out(troubles_of(mission))
        posed = self._posing.pose(session, goal).without(without.robots)
        net = self._core.plan_nets.of(session, mission.plan_id)
        here = (ScriptRow.mission_id == mission.id, ScriptRow.plan_id == mission.plan_id)
        scripts = session.scalars(select(ScriptRow).where(*here)).all()
        now_s = self._clocks[mission.world].now_s()
        work = RepairWork(
            knowledge_base=self._core.knowledge_base,
            plan_net=net,
            problem=replace(posed.problem, facts=without.withhold(posed.problem.facts)),
            request=self._limits.request(PlanningWish.from_json(goal.limits)),
            progress=progress_of(mission, scripts, net, without=without.robots, now_s=now_s),
        )
        old = ReplacedPlan(plan_id=mission.plan_id, plan_net=net)
        return _Sought(posed=posed, old=old, work=work, left_out=without)

    def _found(self, session: Session, mission: MissionRow, sought: _Sought, repair: Repair) -> None:
        """Have the repaired plan approved, or decided on."""
        goal = session.get_one(GoalRow, mission.goal_id)
        repairs: RepairsBody | None = sought.old.repaired_by(repair)
        plan = self._proposing.propose(session, goal, repair.result, sought.posed, repairs)
        # NOTE: who was left out before is not new; only of who is, the operator need hear again.
        measure = measure_of(repair.course, without=sought.left_out.concerns(sought.old.plan_net))
        words = repair.difference.words if repair.difference else ()
        note(mission, measure=measure.value, plan_id=plan.id, outcome="proposed", detail="; ".join(words[:1]))
        goal.plan_id = plan.id
        session.flush()
        if needs_decision(Policy(mission.recovery), measure):
            mission.recovery_step = Step.DECIDING
            mission.reason = f"{mission.attempts[-1]['reason']}; plan {plan.id} waits for a decision"
            data = {"plan": plan.id, "measure": measure.value, "reason": mission.reason}
            self._events.append(session, "mission.repair_proposed", mission.id, **data)
        else:
            self._approval.approve_or_expire(session, plan, goal, actor=RECOVERY, comment="")

    def _wait(self, session: Session, mission: MissionRow, posed: GoalProblem) -> None:
        """Others use what a plan would need: look again later, if it may be tried again."""
        waits_for = posed.narrowed(self._core.knowledge_base).waits_for
        now_s = self._clocks[mission.world].now_s()
        mission.recovery_step = Step.WAITING
        mission.enquire_at_s = now_s + max(LOOK_AGAIN_S, mission.original_estimate_s / 2)
        note(mission, outcome="no plan", detail=f"waits for {waits_for}")
        self._requests.wake_after_attempt(session, mission)


def _is_sought(mission: MissionRow) -> bool:
    return mission.recovery_step == Step.PLANNING and not MissionState(mission.state).ended


def _in_words(reason: str, sought: _Sought) -> str:
    without, robots = sought.left_out.words, sought.left_out.robots
    others = f" without {', '.join(without)}" if without else ""
    held = [
        f for f in sorted(sought.posed.whole.facts) if f.predicate == OBJECT_POSITION and f.args[2] in robots
    ]
    return "; ".join(
        [f"no plan was found{others}: {reason}", *(f"{f.args[2]} holds {f.args[0]}" for f in held)]
    )
