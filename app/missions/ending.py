"""The end of a mission in the record: its scripts, its goal and the events, in the caller's transaction.

Goals that it carries out together end each once its own part is done.
"""

from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.events import GoalFinished, MissionEnded
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles import mission as mission_lifecycle
from app.domain.lifecycles import recovery
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.plan import PlanState
from app.domain.lifecycles.script import withdraw
from app.domain.world_model.vocabulary import symbolic
from app.missions.mission_progress import done
from app.planning.goal_planning import finish_with_others
from app.planning.proposals import close_plans
from app.store import GoalRow, MissionRow, ScriptRow
from app.store.event_log import EventLog
from planner import GOAL, INITIAL
from robots.wire import FailureCategory, SymbolicFact


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


def finish_parts(session: Session, core: Core, mission: MissionRow, scripts: Sequence[ScriptRow]) -> None:
    """Finish the goals that the mission carries out together with others and has achieved already.

    A goal is achieved once the actions that its facts rest on have ended and these facts are believed.

    :param mission: locked.
    :param scripts: of its current plan.
    """
    if not mission.joined_goals:
        return
    achieved = _achieved(session, core, mission, scripts)
    if not achieved:
        return
    joint = session.get_one(GoalRow, mission.goal_id)
    parts = select(GoalRow).where(GoalRow.id.in_(mission.joined_goals), GoalRow.state == GoalState.WAITING)
    # NOTE: other transactions lock goals before missions. A goal that one of them holds is finished at the next review.
    for goal in session.scalars(parts.order_by(GoalRow.id).with_for_update(skip_locked=True)):
        if achieved.issuperset(map(SymbolicFact.model_validate, goal.goal)):
            finish_with_others(session, core.events, goal, joint)


def _achieved(
    session: Session, core: Core, mission: MissionRow, scripts: Sequence[ScriptRow]
) -> set[SymbolicFact]:
    """The facts of the mission's goal that are believed and for which nothing is left to be done."""
    net = core.plan_nets.of(session, mission.plan_id)
    ended = {INITIAL, *done(scripts)}
    reached = [link.fact for link in net.causal_links if link.consumer == GOAL and link.producer in ended]
    if not reached:
        return set()
    facts = core.facts.counting_for(session, mission.world, reached, since_s=mission.started_at_s)
    return {symbolic(fact, core.knowledge_base) for fact in reached if fact in facts}
