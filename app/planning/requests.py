"""Requests for planning: a goal is queued for planning, a mission for the repair of its plan.

Each joins the caller's transaction, so the durable job exists exactly if the change that makes it necessary commits.
"""

from collections.abc import Mapping, Sequence

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.events import GoalSubmitted, MissionNoRepair, MissionRecoveryBegun
from app.domain.ids import new_id
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles import recovery
from app.domain.lifecycles.mission import MissionState
from app.domain.recovery_rules import Policy, Trouble, category_of
from app.planning.pool.waiting_line import Priority
from app.planning.queueing import PlanningQueues
from app.store import GoalRow, MissionRow
from app.workflows import PLAN_GOAL, RECOVER_MISSION
from robots.clock import Clock


class PlanningRequests:
    """Queues goals and missions for planning."""

    def __init__(self, core: Core, *, clocks: Mapping[str, Clock]) -> None:
        """:param clocks: the worlds' clocks by the world's name."""
        self._events = core.events
        self._workflows = core.workflows
        self._queues = PlanningQueues(core.workflows)
        self._clocks = clocks

    def plan_goal(self, session: Session, goal: GoalRow, *, actor: str | None = None) -> None:
        """Have a submitted goal planned.

        :param actor: the operator who submitted it; None if it is planned again.
        """
        goal.attempts += 1
        goal.stop_requested = False
        self._events.append(
            session, GoalSubmitted(subject=goal.id, text=goal.text, actor=actor, reason=goal.reason)
        )
        self._queues.put(session, goal, Priority.GOAL, PLAN_GOAL, f"{goal.id}:{goal.attempts}", goal.id)

    def plan_with_bids(self, session: Session, goal: GoalRow) -> None:
        """Have a goal planned on whose first plan robots were called for proposals."""
        self._queues.put(session, goal, Priority.GOAL, PLAN_GOAL, new_id("bids"), goal.id)

    def plan_again(self, session: Session, goal: GoalRow, reason: str) -> None:
        """Have a goal planned again whose plan has expired."""
        goal_lifecycle.resubmit(goal, reason)
        self.plan_goal(session, goal)

    def recover(
        self,
        session: Session,
        mission: MissionRow,
        troubles: Sequence[Trouble],
        *,
        failure: str | None,
        reason: str,
    ) -> None:
        """Have the mission's plan repaired; this uses up one of its tries.

        :param troubles: the troubles of its present plan's scripts.
        :param failure: the failure category that the attempt is recorded under; None: nothing has failed.
        """
        at_s = self._clocks[mission.world].now_s()
        attempt = recovery.begin_attempt(mission, troubles, at_s=at_s, failure=failure, reason=reason)
        self._events.append(
            session,
            MissionRecoveryBegun(
                subject=mission.id,
                number=attempt["number"],
                failure=attempt["failure"],
                reason=attempt["reason"],
                state=MissionState(mission.state),
            ),
        )
        workflow_id = f"{mission.id}:recovery:{attempt['number']}"
        goal = session.get_one(GoalRow, mission.goal_id)
        self._queues.put(session, goal, Priority.RECOVERY, RECOVER_MISSION, workflow_id, mission.id)

    def recover_again(self, session: Session, goal: GoalRow, reason: str) -> None:
        """Have another repair planned for the goal's mission: the last one became stale before it was approved."""
        mission = session.get_one(MissionRow, goal.mission_id, with_for_update=True)
        recovery.overtake(mission, reason)
        if mission.tries_left <= 0 and mission.recovery == Policy.AUTO:
            self.end_without_plan(session, mission, reason)
            return
        failure = mission.failure or category_of(()).value
        self.recover(session, mission, (), failure=failure, reason=reason)

    def end_without_plan(self, session: Session, mission: MissionRow, reason: str) -> None:
        """Record that the last attempt found no plan, and wake the mission's workflow."""
        recovery.find_no_plan(mission, reason)
        self.wake_after_attempt(session, mission)

    def wake_after_attempt(self, session: Session, mission: MissionRow) -> None:
        """Wake the mission's workflow after an attempt that brought no plan."""
        last = mission.attempts[-1]
        state = MissionState(mission.state)
        self._events.append(session, MissionNoRepair(subject=mission.id, reason=last["detail"], state=state))
        self._workflows.wake(session, mission.workflow)
