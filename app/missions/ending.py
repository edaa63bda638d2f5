"""The end of a mission in the record: its scripts, its goal and the events, in the caller's transaction."""

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.events import GoalFinished, MissionEnded
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles import mission as mission_lifecycle
from app.domain.lifecycles import recovery
from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.plan import PlanState
from app.domain.lifecycles.script import withdraw
from app.planning.proposals import close_plans
from app.store import GoalRow, MissionRow, ScriptRow
from app.store.event_log import EventLog
from robots.wire import FailureCategory


def end_mission(
    session: Session,
    events: EventLog,
    mission: MissionRow,
    *,
    state: MissionState,
    reason: str,
    failure: FailureCategory | None,
    now_s: float,
) -> None:
    """End the mission: withdraw its scripts, finish its goal with its outcome, and close a repair that is proposed.

    Only the order to stop is still delivered, to robots that were declared lost. The time of the end is that of the
    robots' last report, or `now_s` without any (world's clock).
    """
    scripts = session.scalars(select(ScriptRow).where(ScriptRow.mission_id == mission.id)).all()
    for script in scripts:
        if not script.abandoned:
            withdraw(script)
    ended_at_s = max((s.heard_at_s for s in scripts if s.heard_at_s is not None), default=now_s)
    late_s = 0.0 if mission.deadline_s is None else ended_at_s - mission.deadline_s
    if state is MissionState.COMPLETED and late_s > 0:
        reason = f"came true {late_s:.0f} s after the deadline"
        failure = FailureCategory.DEADLINE
    mission_lifecycle.end(mission, state, reason=reason, failure=failure, ended_at_s=ended_at_s)
    recovery.end(mission)
    goal = session.get_one(GoalRow, mission.goal_id)
    close_plans(session, events, goal, PlanState.EXPIRED, "its mission has ended")
    goal_lifecycle.finish(goal, outcome=state.value, reason=reason)
    events.append(
        session,
        MissionEnded(
            subject=mission.id,
            goal=goal.id,
            state=state,
            reason=reason,
            failure=failure,
            ended_at_s=ended_at_s,
        ),
    )
    events.append(session, GoalFinished(subject=goal.id, outcome=state, reason=reason))
