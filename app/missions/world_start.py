"""The start of worlds: a recorded run continues from the record; a new run starts with the facts of the world's file,
and the earlier run's missions end.
"""

from collections.abc import Collection

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from app.agents.rules import renew_rules
from app.agents.running_world import RunningWorld
from app.agents.speech import end_conversations
from app.agents.tuning import renew_tunings
from app.core import Core
from app.domain.clock import SYSTEM_CLOCK
from app.domain.events import GoalWaiting, GoalWithdrawn
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles.mission import OPEN, MissionState
from app.domain.lifecycles.plan import PlanState
from app.domain.lifecycles.script import release_abandoned
from app.domain.world_model import initial_facts
from app.domain.world_model.beliefs import SOLID
from app.missions.dialogues import end_dialogues
from app.missions.embodiment_record import begin_anew, forget_absent
from app.missions.ending import end_mission
from app.planning.hold_service import end_spans
from app.planning.proposals import close_plans
from app.store import (
    GoalRow,
    LostRobotRow,
    MissionRow,
    NumberRow,
    ScriptRow,
    UnknownRow,
    WorldRow,
)
from app.store.event_log import EventLog
from robots.wire import FailureCategory
from robots.world import WorldFile

UNKNOWN_RUN = ""
"""The run of a world whose fleet has not announced itself yet: its facts are those of its file."""


def start_world(session: Session, core: Core, world: RunningWorld, present: WorldFile) -> None:
    """Start the run that the world is in, or continue it; without one, wait for the run of its fleet.

    :param present: its newest edition.
    """
    if world.run is None:
        await_fleet(session, core, present)
    else:
        start_world_run(session, core, present, world.run, new_run_reason=world.new_run_reason)


def start_world_run(
    session: Session, core: Core, world: WorldFile, run: str, *, new_run_reason: str = ""
) -> bool:
    """Continue the run if the record's facts belong to it, and return True; else start it, and return False.

    A new run has the facts of the world's file; running missions fail, open plans expire, and goals without a mission
    wait to be planned again.

    :param new_run_reason: why the last run could not be continued, if that is known.
    """
    core.database.lock(session, f"world {world.name}")  # another process may be starting it, too
    row = session.get(WorldRow, world.name)
    if row is None:
        row = WorldRow(id=world.name, version=0)
        session.add(row)
    row.title = world.title or world.name
    core.facts.numbers.lay_out(session, row, world)
    session.flush()
    forget_absent(session, world)
    source = f"world file {world.name}"
    if row.run in (run, UNKNOWN_RUN):
        row.run = run
        known = core.facts.facts(session, world.name)
        # An earlier version did not record which robots are solid.
        solid = {
            fact for fact in initial_facts(world, core.knowledge_base) if fact.predicate == SOLID
        } - known
        if solid:
            core.facts.change(session, world.name, add=solid, source=source, at_s=0.0)
        core.facts.numbers.complete(session, world, known | solid, source=source, at_s=0.0)
        return True
    row.run = run
    core.facts.begin_run(session, world.name)
    session.execute(delete(NumberRow).where(NumberRow.world == world.name))
    facts = initial_facts(world, core.knowledge_base)
    renew_tunings(session, world.name)
    renew_rules(session, world.name)
    core.facts.change(session, world.name, add=facts, source=source, at_s=0.0)
    core.facts.numbers.complete(session, world, facts, source=source, at_s=0.0)
    session.execute(delete(LostRobotRow).where(LostRobotRow.world == world.name))
    session.execute(delete(UnknownRow).where(UnknownRow.world == world.name))
    end_spans(session, core.events, world.name, SYSTEM_CLOCK.epoch_s())
    _forget_abandoned(session, world.name)
    reason = "the simulated world was started again" + (f": {new_run_reason}" if new_run_reason else "")
    begin_anew(session, core.events, world, reason)
    end_conversations(session, world.name, reason)
    end_dialogues(session, core.events, world.name, reason)
    _end_missions(session, core.events, world.name, reason)
    _reopen_goals(session, core.events, world.name, reason, runs=True)
    return False


def await_fleet(session: Session, core: Core, world: WorldFile) -> None:
    """Keep the world's record, if there is one, until the fleet's run is known."""
    row = session.get(WorldRow, world.name)
    known = row.run if row is not None else None
    start_world_run(session, core, world, UNKNOWN_RUN if known is None else known)


def _forget_abandoned(session: Session, world_id: str) -> None:
    """Drop the orders to stop for lost robots: they belong to the earlier run."""
    query = select(ScriptRow).join(MissionRow, MissionRow.id == ScriptRow.mission_id)
    for script in session.scalars(query.where(MissionRow.world == world_id, ScriptRow.abandoned)).all():
        release_abandoned(script)


def end_missions_of_absent_worlds(session: Session, core: Core, running: Collection[str]) -> None:
    """End the missions of recorded worlds that no longer run, and withdraw their goals."""
    for row in session.scalars(select(WorldRow).where(WorldRow.id.not_in(running))).all():
        row.run = None
        reason = f"world {row.id} no longer runs"
        end_conversations(session, row.id, reason)
        end_dialogues(session, core.events, row.id, reason)
        _end_missions(session, core.events, row.id, reason)
        _reopen_goals(session, core.events, row.id, reason, runs=False)


def _end_missions(session: Session, events: EventLog, world_id: str, reason: str) -> None:
    query = select(MissionRow).where(MissionRow.world == world_id, MissionRow.state.in_(OPEN))
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
        goal.tender = None  # its times are of the earlier run's clock
        if runs:
            goal_lifecycle.wait(goal, reason)
            events.append(session, GoalWaiting(subject=goal.id, reason=reason))
        else:
            goal_lifecycle.withdraw(goal, outcome="world_not_running", reason=reason)
            events.append(session, GoalWithdrawn(subject=goal.id, reason=reason))
