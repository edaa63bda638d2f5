"""A repaired plan in the place of the one a mission carried out: approved, or turned down."""

from sqlalchemy.orm import Session

from app.domain.events import GoalCommitted, MissionRevised
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles import mission as mission_lifecycle
from app.domain.lifecycles import recovery
from app.domain.lifecycles.mission import MissionState
from app.store import GoalRow, MissionRow, PlanRow
from app.store.event_log import EventLog
from app.workflows import Workflows


def revise(
    session: Session,
    events: EventLog,
    workflows: Workflows,
    mission: MissionRow,
    plan: PlanRow,
    goal: GoalRow,
    *,
    margin_s: float,
) -> None:
    """The mission carries out this plan from now on. What is done stays done; its robots get new scripts.

    One that is paused gets them when it is resumed.
    """
    mission.plan_id = plan.id
    mission.margin_s = margin_s
    mission.revision += 1
    recovery.approve(mission, plan.id)
    goal_lifecycle.commit(goal, plan_id=plan.id, mission_id=mission.id)
    mission_lifecycle.dispatch(mission)
    events.append(session, GoalCommitted(subject=goal.id, plan=plan.id, mission=mission.id))
    revised = MissionRevised(
        subject=mission.id, plan=plan.id, revision=mission.revision, state=MissionState(mission.state)
    )
    events.append(session, revised)
    workflows.wake(session, mission.workflow, f"revised:{mission.id}:{mission.revision}")


def turn_down(
    session: Session, workflows: Workflows, mission: MissionRow, plan: PlanRow, goal: GoalRow, comment: str
) -> None:
    """The operator does not want the mission recovered this way: it ends."""
    goal.plan_id = mission.plan_id
    said = f": {comment}" if comment else ""
    recovery.reject(mission, plan.id, f"the repair was rejected{said}")
    workflows.wake(session, mission.workflow, f"rejected:{plan.id}")
