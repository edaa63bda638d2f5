"""What operators ask of missions: to see them, and to cancel, pause or resume them."""

from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.errors import Conflict, unrecorded
from app.domain.ids import new_id
from app.domain.recovery_rules import TRIES, Policy, Step
from app.domain.states import MissionState
from app.planning.mission_progress import note
from app.store import MissionRow, ScriptRow
from app.store.records import page
from app.store.script_orders import can_be_ordered, give
from robots.wire import ControlVerb

Mission = tuple[MissionRow, list[ScriptRow]]


class MissionService:
    """Reads missions and takes operators' orders on them."""

    def __init__(self, core: Core) -> None:
        self._database, self._events, self._workflows = core.database, core.events, core.workflows

    def get(self, mission_id: str) -> Mission:
        with self._database.read() as session:
            return _with_scripts(session, _mission(session, mission_id))

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
            return [_with_scripts(session, row) for row in rows], token

    def cancel(self, mission_id: str, actor: str, comment: str) -> Mission:
        """Have every robot stop its script. The mission is cancelled once they have answered."""
        with self._database.write() as session:
            mission = _mission(session, mission_id, to_change=True)
            if mission.cancel_requested:
                return _with_scripts(session, mission)
            _refuse_ended(mission, "cancelled")
            mission.cancel_requested = True
            self._events.append(session, "mission.cancel_requested", mission.id, actor=actor, comment=comment)
            self._workflows.wake(session, mission.workflow, f"cancel:{mission.id}")
            return _with_scripts(session, mission)

    def set_recovery(self, mission_id: str, policy: Policy, actor: str) -> Mission:
        """What becomes of the mission's failures from now on; a repair that waits for a decision still does."""
        with self._database.write() as session:
            mission = _mission(session, mission_id, to_change=True)
            _refuse_ended(mission, "recovered otherwise")
            if mission.recovery != policy:
                mission.recovery = policy
                data = {"actor": actor, "policy": policy.value}
                self._events.append(session, "mission.recovery_set", mission.id, **data)
                self._workflows.wake(session, mission.workflow, f"{mission.id}:policy:{new_id('policy')}")
            return _with_scripts(session, mission)

    def pause(self, mission_id: str, actor: str, comment: str) -> Mission:
        """Have every robot that is still at work stand still and keep its place in its script."""
        with self._database.write() as session:
            mission = _mission(session, mission_id, to_change=True)
            _refuse_ended(mission, "paused")
            if mission.cancel_requested:
                raise Conflict(f"mission {mission.id} is being cancelled", code="being-cancelled")
            if mission.state != MissionState.PAUSED:
                mission.resume_to, mission.state = mission.state, MissionState.PAUSED
                self._order(session, mission, ControlVerb.PAUSE, actor, comment)
            return _with_scripts(session, mission)

    def resume(self, mission_id: str, actor: str, comment: str) -> Mission:
        """Go on after a pause; or look for a way again where none was found and an operator was asked."""
        with self._database.write() as session:
            mission = _mission(session, mission_id, to_change=True)
            if mission.recovery_step == Step.STUCK and mission.state != MissionState.PAUSED:
                return self._try_again(session, mission, actor, comment)
            if mission.state != MissionState.PAUSED:
                raise Conflict(f"mission {mission.id} is {mission.state}, not paused", code="not-paused")
            mission.state, mission.resume_to = mission.resume_to or MissionState.RUNNING, None
            self._order(session, mission, ControlVerb.RESUME, actor, comment)
            return _with_scripts(session, mission)

    def _try_again(self, session: Session, mission: MissionRow, actor: str, comment: str) -> Mission:
        mission.recovery_step, mission.tries_left = None, TRIES
        note(mission, outcome="taken up")
        self._events.append(session, "mission.resumed", mission.id, actor=actor, comment=comment)
        self._workflows.wake(session, mission.workflow, f"{mission.id}:again:{len(mission.attempts)}")
        return _with_scripts(session, mission)

    def _order(
        self, session: Session, mission: MissionRow, verb: ControlVerb, actor: str, comment: str
    ) -> None:
        self._events.append(session, f"mission.{verb.value}d", mission.id, actor=actor, comment=comment)
        for script in _scripts(session, mission.id):
            if can_be_ordered(script, mission):
                give(script, verb)


def _mission(session: Session, mission_id: str, *, to_change: bool = False) -> MissionRow:
    row = session.get(MissionRow, mission_id, with_for_update=to_change)
    if row is None:
        raise unrecorded("mission", mission_id)
    return row


def _refuse_ended(mission: MissionRow, verb: str) -> None:
    if MissionState(mission.state).ended:
        raise Conflict(
            f"mission {mission.id} is {mission.state}: it cannot be {verb} any more", code="mission-ended"
        )


def _scripts(session: Session, mission_id: str) -> Sequence[ScriptRow]:
    query = select(ScriptRow).where(ScriptRow.mission_id == mission_id).order_by(ScriptRow.robot)
    return session.scalars(query).all()


def _with_scripts(session: Session, mission: MissionRow) -> Mission:
    return mission, list(_scripts(session, mission.id))
