"""The beginning of an embedded service: worlds start as their files say, so what ran in them before is over."""

from collections.abc import Mapping

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from app.core import Core
from app.database import FactRow, GoalRow, MissionRow, WorldRow
from app.events import EventLog
from app.missions.ending import end_mission
from app.plans.proposing import close_plans
from app.states import ENDED, GoalState, MissionState, PlanState
from app.tuning.desk import renew_tunings
from app.world_model import initial_facts
from app.world_model.layout import layout_of
from robots.wire import FailureCategory
from robots.world import WorldFile

OPEN_GOALS = (GoalState.SUBMITTED, GoalState.PLANNING, GoalState.PLANNED)


def begin_afresh(session: Session, core: Core, worlds: Mapping[str, WorldFile]) -> None:
    """Facts as the world files say. Missions that ran have failed, open plans have expired.

    Goals that nobody has decided on wait to be planned again, or are withdrawn where their world does not run.
    """
    for world in worlds.values():
        _record_world(session, core, world)
    for world_id in session.scalars(select(WorldRow.id)).all():
        runs = world_id in worlds
        reason = (
            "the simulated world was started afresh" if runs else f"world {world_id} does not run any more"
        )
        _end_missions(session, core.events, world_id, reason)
        _reopen_goals(session, core.events, world_id, reason, runs=runs)


def _record_world(session: Session, core: Core, world: WorldFile) -> None:
    row = session.get(WorldRow, world.name)
    if row is None:
        row = WorldRow(id=world.name, version=0)
        session.add(row)
    row.title, row.layout = world.title or world.name, layout_of(world)
    session.flush()
    session.execute(delete(FactRow).where(FactRow.world == world.name))
    facts = initial_facts(world, core.knowledge_base)
    renew_tunings(session, world.name)
    core.facts.change(session, world.name, add=facts, source=f"world file {world.name}", at_s=0.0)


def _end_missions(session: Session, events: EventLog, world_id: str, reason: str) -> None:
    query = select(MissionRow).where(MissionRow.world == world_id, MissionRow.state.not_in(ENDED))
    for mission in session.scalars(query).all():
        end_mission(
            session,
            events,
            mission,
            state=MissionState.FAILED,
            reason=reason,
            failure=FailureCategory.WORLD_CHANGED,
            now_s=0.0,
        )


def _reopen_goals(session: Session, events: EventLog, world_id: str, reason: str, *, runs: bool) -> None:
    query = select(GoalRow).where(GoalRow.world == world_id, GoalRow.state.in_(OPEN_GOALS))
    for goal in session.scalars(query).all():
        close_plans(session, events, goal, PlanState.EXPIRED, reason)
        goal.state, goal.reason = GoalState.SUBMITTED if runs else GoalState.WITHDRAWN, reason
        goal.outcome = None if runs else "world_not_running"
        events.append(session, f"goal.{goal.state}", goal.id, reason=reason)
