"""Operators' requests on missions: read, cancel, pause, resume, plan again, set the recovery policy."""

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.errors import Conflict, NotFound, unrecorded
from app.domain.events import (
    MissionCancelRequested,
    MissionPaused,
    MissionRecoverySet,
    MissionResumed,
)
from app.domain.lifecycles import mission as mission_lifecycle
from app.domain.lifecycles.mission import MissionState, has_ended, is_paused
from app.domain.lifecycles.recovery import RecoveryStep, try_again
from app.domain.lifecycles.script import can_be_ordered, order
from app.domain.recovery_rules import Policy
from app.missions.mission_speech import conversation_of
from app.store import MissionRow, ResultRow, ScriptRow
from app.store.records import all_of, page, read_only
from robots.wire import ControlVerb

Mission = tuple[MissionRow, list[ScriptRow]]


class MissionService:
    """Reads missions and takes operators' orders on them."""

    def __init__(self, core: Core) -> None:
        self._database = core.database
        self._events = core.events
        self._workflows = core.workflows

    def get(self, mission_id: str) -> Mission:
        with self._database.read() as session:
            return with_scripts(session, mission_row(session, mission_id))

    def newest(
        self,
        *,
        world: str | None = None,
        state: str | None = None,
        limit: int = 100,
        after: str | None = None,
    ) -> tuple[Sequence[Mission], str | None]:
        with self._database.read() as session:
            rows, token = page(session, MissionRow, limit=limit, after=after, world=world, state=state)
            scripts = _scripts_by_mission(session, [row.id for row in rows])
            return [(row, scripts.get(row.id, [])) for row in rows], token

    def results(self, mission_id: str) -> Sequence[ResultRow]:
        """What its packets have brought, oldest first, without the images' content."""
        with self._database.read() as session:
            mission_row(session, mission_id)
            query = read_only(ResultRow).where(ResultRow.mission_id == mission_id)
            return all_of(session, query.order_by(ResultRow.at_s, ResultRow.created_at, ResultRow.id))

    def conversation(self, mission_id: str) -> Sequence[Mapping[str, Any]]:
        """What its robots have said to each other and reported, and what was said with the service, in order."""
        with self._database.read() as session:
            return conversation_of(session, mission_row(session, mission_id))

    def result(self, mission_id: str, result_id: str) -> ResultRow:
        """One result with its content."""
        with self._database.read() as session:
            mission_row(session, mission_id)
            row = session.get(ResultRow, result_id)
            if row is None or row.mission_id != mission_id:
                raise NotFound(f"mission {mission_id} has no result {result_id!r}", code="unknown-result")
            return row

    def cancel(self, mission_id: str, actor: str, comment: str) -> Mission:
        """Have every robot stop its script. The mission is cancelled once they have answered."""
        with self._database.write() as session:
            mission = mission_row(session, mission_id, to_change=True)
            if mission.cancel_requested:
                return with_scripts(session, mission)
            refuse_ended(mission, "cancelled")
            mission.cancel_requested = True
            state = MissionState(mission.state)
            self._events.append(
                session,
                MissionCancelRequested(subject=mission.id, actor=actor, comment=comment, state=state),
            )
            self._workflows.wake(session, mission.workflow)
            return with_scripts(session, mission)

    def set_recovery(self, mission_id: str, policy: Policy, actor: str) -> Mission:
        """Set the recovery policy for later failures; a repair that waits for a decision still does."""
        with self._database.write() as session:
            mission = mission_row(session, mission_id, to_change=True)
            refuse_ended(mission, "recovered otherwise")
            if mission.recovery != policy:
                mission.recovery = policy
                state = MissionState(mission.state)
                self._events.append(
                    session,
                    MissionRecoverySet(subject=mission.id, actor=actor, policy=policy.value, state=state),
                )
                self._workflows.wake(session, mission.workflow)
            return with_scripts(session, mission)

    def pause(self, mission_id: str, actor: str, comment: str) -> Mission:
        """Order every robot that is still at work to stand still and to keep its position in its script."""
        with self._database.write() as session:
            return self.pause_in(session, mission_id, actor, comment)

    def pause_in(self, session: Session, mission_id: str, actor: str, comment: str) -> Mission:
        """As `pause`, in a transaction."""
        mission = mission_row(session, mission_id, to_change=True)
        refuse_ended(mission, "paused")
        if mission.cancel_requested:
            raise Conflict(f"mission {mission.id} is being cancelled", code="being-cancelled")
        if not is_paused(mission):
            mission_lifecycle.pause(mission)
            self._order(session, mission, ControlVerb.PAUSE, actor, comment)
        return with_scripts(session, mission)

    def resume(self, mission_id: str, actor: str, comment: str) -> Mission:
        """Go on after a pause; a stuck mission is recovered again."""
        with self._database.write() as session:
            mission = mission_row(session, mission_id, to_change=True)
            if mission.recovery_step == RecoveryStep.STUCK and not is_paused(mission):
                return self._try_again(session, mission, actor, comment)
            if not is_paused(mission):
                raise Conflict(f"mission {mission.id} is {mission.state}, not paused", code="not-paused")
            mission_lifecycle.resume(mission)
            self._order(session, mission, ControlVerb.RESUME, actor, comment)
            return with_scripts(session, mission)

    def _try_again(self, session: Session, mission: MissionRow, actor: str, comment: str) -> Mission:
        try_again(mission)
        state = MissionState(mission.state)
        self._events.append(
            session, MissionResumed(subject=mission.id, actor=actor, comment=comment, state=state)
        )
        self._workflows.wake(session, mission.workflow)
        return with_scripts(session, mission)

    def _order(
        self, session: Session, mission: MissionRow, verb: ControlVerb, actor: str, comment: str
    ) -> None:
        ordered = MissionPaused if verb is ControlVerb.PAUSE else MissionResumed
        state = MissionState(mission.state)
        self._events.append(session, ordered(subject=mission.id, actor=actor, comment=comment, state=state))
        for script in _scripts(session, mission.id):
            if can_be_ordered(script, mission):
                order(script, verb)


def mission_row(session: Session, mission_id: str, *, to_change: bool = False) -> MissionRow:
    """The mission, with `to_change` locked.

    :raises NotFound: if there is no such mission.
    """
    row = session.get(MissionRow, mission_id, with_for_update=to_change)
    if row is None:
        raise unrecorded("mission", mission_id)
    return row


def refuse_ended(mission: MissionRow, verb: str) -> None:
    """:raises Conflict: if the mission has ended."""
    if has_ended(mission):
        raise Conflict(
            f"mission {mission.id} is {mission.state}: it cannot be {verb} any longer", code="mission-ended"
        )


def _scripts(session: Session, mission_id: str) -> Sequence[ScriptRow]:
    query = select(ScriptRow).where(ScriptRow.mission_id == mission_id).order_by(ScriptRow.robot)
    return session.scalars(query).all()


def _scripts_by_mission(session: Session, mission_ids: Sequence[str]) -> Mapping[str, list[ScriptRow]]:
    query = read_only(ScriptRow).where(ScriptRow.mission_id.in_(mission_ids)).order_by(ScriptRow.robot)
    found: dict[str, list[ScriptRow]] = {}
    for script in all_of(session, query):
        found.setdefault(script.mission_id, []).append(script)
    return found


def with_scripts(session: Session, mission: MissionRow) -> Mission:
    """The mission and its scripts, in the order of their robots' names."""
    return mission, list(_scripts(session, mission.id))
