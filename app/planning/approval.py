"""Operators' decisions on plans: approve or reject. A plan that the world has overtaken expires instead."""

from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.errors import Conflict, unrecorded
from app.domain.ids import new_id
from app.domain.mission_organiser import Margin
from app.domain.plan_document import PlanBody
from app.domain.recovery_rules import TRIES
from app.domain.states import GoalState, MissionState, PlanState
from app.planning.proposals import close_plans, open_plans
from app.planning.requests import PlanningRequests
from app.planning.revision import revise, turn_down
from app.planning.staleness import Staleness
from app.store import GoalRow, MissionRow, PlanRow
from app.store.durations import learned_durations
from app.store.records import page
from app.store.tables import utc_now
from app.workflows import MISSION_LIFE, MISSIONS

AUTOMATIC = "auto_approve"
"""Who decided on a plan whose goal was submitted with `auto_approve`."""
RECOVERY = "recovery"
"""Who decided on a repaired plan of a mission that is recovered without asking."""


class PlanApproval:
    """Reads plans and takes decisions on them."""

    def __init__(
        self,
        core: Core,
        *,
        margin: Margin,
        requests: PlanningRequests,
    ) -> None:
        self._database, self._events, self._workflows = core.database, core.events, core.workflows
        self._facts, self._plan_nets, self._staleness = core.facts, core.plan_nets, Staleness(core)
        self._margin = margin
        self._requests = requests

    def get(self, plan_id: str) -> PlanRow:
        with self._database.read() as session:
            return _plan(session, plan_id)

    def overtaken(self, plan: PlanRow) -> list[str]:
        """Why the plan cannot be approved as it is, if it waits for a decision; approving has it repaired then."""
        if plan.state != PlanState.PROPOSED:
            return []
        with self._database.read() as session:
            return self._staleness.of(session, plan, session.get_one(GoalRow, plan.goal_id))

    def newest(
        self,
        *,
        goal_id: str | None = None,
        state: str | None = None,
        limit: int = 100,
        after: str | None = None,
    ) -> tuple[Sequence[PlanRow], str | None]:
        with self._database.read() as session:
            return page(session, PlanRow, limit=limit, after=after, goal_id=goal_id, state=state)

    def approve(self, plan_id: str, *, actor: str, comment: str = "") -> tuple[PlanRow, str]:
        """Approve a plan and start its mission; once approved, approving again answers the same mission.

        :raises Conflict: if it was decided otherwise, or the world has changed under it; then it is repaired.
        """
        with self._database.write() as session:
            plan, goal = _to_decide(session, plan_id)
            if plan.state == PlanState.APPROVED:
                return plan, _mission_of(session, plan)
            _refuse_decided(plan)
            mission_id = self.approve_or_expire(session, plan, goal, actor=actor, comment=comment)
        if mission_id is None:
            detail = f"the world has changed since the plan was made: {plan.reason}; it is being repaired"
            raise Conflict(detail, code="plan-stale")
        return plan, mission_id

    def approve_or_expire(
        self, session: Session, plan: PlanRow, goal: GoalRow, *, actor: str, comment: str
    ) -> str | None:
        """Approve inside the caller's transaction and answer the mission's id.

        None if the world has changed under the plan: then it has expired, and a repaired one is to take its place.
        """
        if goal.mission_id is not None:
            session.get_one(MissionRow, goal.mission_id, with_for_update=True)  # before the world, as all do
        # Of two plans that take the same robots, approved at once in two processes, one sees the other's mission.
        self._facts.lock(session, plan.world)
        stale = "; ".join(self._staleness.of(session, plan, goal))
        if not stale:
            return self._approve(session, plan, goal, actor=actor, comment=comment)
        plan.state, plan.reason, goal.plan_id = PlanState.EXPIRED, stale, plan.id
        self._events.append(session, "plan.expired", plan.id, goal=goal.id, reason=stale, actor=actor)
        close_plans(session, self._events, goal, PlanState.EXPIRED, "another plan of the goal is repaired")
        reason = f"the plan was overtaken: {stale}"
        if goal.mission_id is None:
            self._requests.plan_goal(session, goal, reason)
        else:
            self._requests.recover_again(session, goal, reason)
        return None

    def _approve(self, session: Session, plan: PlanRow, goal: GoalRow, *, actor: str, comment: str) -> str:
        self._decide(session, plan, PlanState.APPROVED, actor, comment)
        close_plans(
            session, self._events, goal, PlanState.SUPERSEDED, f"plan {plan.id} was approved", but=plan.id
        )
        body = PlanBody.model_validate(plan.body)
        net = self._plan_nets.of(session, plan.id)
        margin_s = self._margin.of(net, learned_durations(session, plan.world), plan.world)
        if goal.mission_id is not None:
            mission = session.get_one(MissionRow, goal.mission_id, with_for_update=True)
            revise(session, self._events, self._workflows, mission, plan, goal, margin_s=margin_s)
            return mission.id
        mission_id = new_id("mission")
        mission = MissionRow(
            id=mission_id,
            workflow=mission_id,
            goal_id=goal.id,
            plan_id=plan.id,
            world=plan.world,
            state=MissionState.PENDING,
            estimate_s=body.makespan_s,
            original_estimate_s=body.makespan_s,
            margin_s=margin_s,
            deadline_s=goal.deadline_at_s,
            recovery=goal.recovery,
            tries_left=TRIES,
        )
        session.add(mission)
        goal.state, goal.plan_id, goal.mission_id = GoalState.COMMITTED, plan.id, mission.id
        self._events.append(
            session, "mission.pending", mission.id, goal=goal.id, plan=plan.id, robots=list(body.robots)
        )
        self._workflows.start(session, MISSIONS, MISSION_LIFE, mission.workflow, mission.id)
        return mission.id

    def reject(self, plan_id: str, *, actor: str, comment: str = "") -> PlanRow:
        """Reject a plan; its goal is withdrawn with the last plan open. Rejecting again changes nothing.

        The mission that a repaired plan was for ends; its robots are safe.
        """
        with self._database.write() as session:
            plan, goal = _to_decide(session, plan_id)
            if plan.state == PlanState.REJECTED:
                return plan
            _refuse_decided(plan)
            self._decide(session, plan, PlanState.REJECTED, actor, comment)
            session.flush()
            if goal.mission_id is not None:
                mission = session.get_one(MissionRow, goal.mission_id, with_for_update=True)
                turn_down(session, self._workflows, mission, plan, goal, comment)
                return plan
            if left := open_plans(session, goal.id):
                goal.plan_id = left[0].id
                return plan
            goal.state, goal.outcome = GoalState.WITHDRAWN, "plan_rejected"
            goal.reason = f"plan rejected: {comment}" if comment else "plan rejected"
            self._events.append(session, "goal.withdrawn", goal.id, reason=goal.reason)
            return plan

    def _decide(self, session: Session, plan: PlanRow, state: PlanState, actor: str, comment: str) -> None:
        plan.state, plan.comment, plan.decided_by, plan.decided_at = state, comment, actor, utc_now()
        self._events.append(
            session, f"plan.{state.value}", plan.id, goal=plan.goal_id, actor=actor, comment=comment
        )


def _plan(session: Session, plan_id: str) -> PlanRow:
    row = session.get(PlanRow, plan_id)
    if row is None:
        raise unrecorded("plan", plan_id)
    return row


def _to_decide(session: Session, plan_id: str) -> tuple[PlanRow, GoalRow]:
    """The plan and its goal, locked: the goal first, as all do, so that two processes never wait for each other."""
    plan = _plan(session, plan_id)
    goal = session.get_one(GoalRow, plan.goal_id, with_for_update=True)
    session.refresh(plan, with_for_update=True)
    return plan, goal


def _mission_of(session: Session, plan: PlanRow) -> str:
    return session.scalars(select(MissionRow.id).where(MissionRow.goal_id == plan.goal_id)).one()


def _refuse_decided(plan: PlanRow) -> None:
    if plan.state != PlanState.PROPOSED:
        why = f": {plan.reason}" if plan.reason else ""
        raise Conflict(f"plan {plan.id} is {plan.state}, not proposed{why}", code="plan-decided")
