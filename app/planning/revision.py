"""A repaired plan in the place of the one a mission carried out: approved, or turned down."""

from sqlalchemy.orm import Session

from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.recovery_rules import Step
from app.domain.states import MissionState
from app.planning.mission_progress import note
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
    mission.plan_id, mission.margin_s = plan.id, margin_s
    mission.revision += 1
    mission.recovery_step = None
    note(mission, plan_id=plan.id, outcome="approved")
    goal_lifecycle.commit(goal, plan_id=plan.id, mission_id=mission.id)
    if mission.state == MissionState.PAUSED:
        mission.resume_to = MissionState.DISPATCHING
    else:
        mission.state = MissionState.DISPATCHING
    mission.reason, mission.failure = "", None
    data = {"plan": plan.id, "revision": mission.revision}
    events.append(session, "mission.revised", mission.id, **data)
    workflows.wake(session, mission.workflow, f"revised:{mission.id}:{mission.revision}")


def turn_down(
    session: Session, workflows: Workflows, mission: MissionRow, plan: PlanRow, goal: GoalRow, comment: str
) -> None:
    """The operator does not want the mission recovered this way: it ends."""
    mission.recovery_step, goal.plan_id = Step.ENDING, mission.plan_id
    said = f": {comment}" if comment else ""
    note(mission, plan_id=plan.id, outcome="rejected", detail=f"the repair was rejected{said}")
    workflows.wake(session, mission.workflow, f"rejected:{plan.id}")
