"""Meeting the worlds when a service begins: one whose run the record knows goes on where it stood, any other begins
afresh, as its file says, so what ran in it before is over.
"""

from collections.abc import Collection

from sqlalchemy import delete, inspect, select
from sqlalchemy.orm import Session

from app.agents.running_world import RunningWorld
from app.agents.tuning import renew_tunings
from app.core import Core
from app.domain.events import GoalWaiting, GoalWithdrawn
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import ENDED, MissionState
from app.domain.lifecycles.plan import PlanState
from app.domain.lifecycles.script import release_abandoned
from app.domain.world_model import initial_facts
from app.domain.world_model.layout import layout_of
from app.missions.ending import end_mission
from app.planning.proposals import close_plans
from app.settings import Settings
from app.store import Database, FactRow, GoalRow, LostRobotRow, MissionRow, ScriptRow, UnknownRow, WorldRow
from app.store.event_log import EventLog
from robots.wire import FailureCategory
from robots.world import WorldFile

UNMET = ""
"""The run of a world whose fleet has not been heard of yet: its facts are as its file says."""


def recorded_run(settings: Settings, world: str) -> str | None:
    """The run of a world that the record tells of; None if there is no record yet, or it knows none to go on with."""
    settings.data.mkdir(parents=True, exist_ok=True, mode=0o700)
    database = Database(settings.resolved_database_url())
    try:
        known = inspect(database.engine)
        columns = known.get_columns(WorldRow.__tablename__) if known.has_table(WorldRow.__tablename__) else []
        if all(column["name"] != WorldRow.run.key for column in columns):
            return None  # of before there were runs; it is brought up to date when the service begins
        with database.read() as session:
            return session.scalar(select(WorldRow.run).where(WorldRow.id == world))
    finally:
        database.close()


def begin_world(session: Session, core: Core, world: RunningWorld) -> None:
    """Meet the world if its run is known already; else expect its fleet."""
    if world.run is None:
        expect_world(session, core, world.file)
    else:
        meet_world(session, core, world.file, world.run, why_afresh=world.why_afresh)


def meet_world(session: Session, core: Core, world: WorldFile, run: str, *, why_afresh: str = "") -> bool:
    """True if the world goes on: its run is the one that the record's facts belong to.

    Else it begins afresh: facts as the file says, missions that ran have failed, open plans have expired, goals that
    nobody has decided on wait to be planned again.

    :param why_afresh: why it could not go on, if that is known.
    """
    core.database.lock(session, f"world {world.name}")  # another process may meet it just now
    row = session.get(WorldRow, world.name)
    if row is None:
        row = WorldRow(id=world.name, version=0)
        session.add(row)
    row.title, row.layout = world.title or world.name, layout_of(world)
    session.flush()
    if row.run in (run, UNMET):
        row.run = run
        return True
    row.run = run
    session.execute(delete(FactRow).where(FactRow.world == world.name))
    facts = initial_facts(world, core.knowledge_base)
    renew_tunings(session, world.name)
    core.facts.change(session, world.name, add=facts, source=f"world file {world.name}", at_s=0.0)
    session.execute(delete(LostRobotRow).where(LostRobotRow.world == world.name))
    session.execute(delete(UnknownRow).where(UnknownRow.world == world.name))
    _forget_abandoned(session, world.name)
    reason = "the simulated world was started afresh" + (f": {why_afresh}" if why_afresh else "")
    _end_missions(session, core.events, world.name, reason)
    _reopen_goals(session, core.events, world.name, reason, runs=True)
    return False


def expect_world(session: Session, core: Core, world: WorldFile) -> None:
    """Its fleet is not known yet: until it is the record stands, if there is one to go on with."""
    row = session.get(WorldRow, world.name)
    known = row.run if row is not None else None
    meet_world(session, core, world, UNMET if known is None else known)


def _forget_abandoned(session: Session, world_id: str) -> None:
    """Robots that were lost in a world that is no more need not be told to stop."""
    query = select(ScriptRow).join(MissionRow, MissionRow.id == ScriptRow.mission_id)
    for script in session.scalars(query.where(MissionRow.world == world_id, ScriptRow.abandoned)).all():
        release_abandoned(script)


def part_from_others(session: Session, core: Core, running: Collection[str]) -> None:
    """Worlds of the record that do not run: what ran in them is over, open goals are withdrawn; they will not go on."""
    for row in session.scalars(select(WorldRow).where(WorldRow.id.not_in(running))).all():
        row.run = None
        reason = f"world {row.id} does not run any more"
        _end_missions(session, core.events, row.id, reason)
        _reopen_goals(session, core.events, row.id, reason, runs=False)


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
    query = select(GoalRow).where(GoalRow.world == world_id, GoalRow.state.in_(goal_lifecycle.UNDECIDED))
    for goal in session.scalars(query).all():
        close_plans(session, events, goal, PlanState.EXPIRED, reason)
        if runs:
            goal_lifecycle.wait(goal, reason)
            events.append(session, GoalWaiting(subject=goal.id, reason=reason, state=GoalState.WAITING))
        else:
            goal_lifecycle.withdraw(goal, outcome="world_not_running", reason=reason)
            events.append(session, GoalWithdrawn(subject=goal.id, reason=reason))
