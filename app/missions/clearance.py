"""Clearance: robots are told when actions have ended that their packets come after and that they cannot sense.

What a robot is to be told follows from what the record says has ended, so it is worked out anew with each report
and lives in the record until the robot has acknowledged it.
"""

from collections import defaultdict
from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.events import ScriptCleared
from app.domain.lifecycles.script import DELIVERABLE, has_failed, has_terminated
from app.store import MissionRow, ScriptRow
from app.store.event_log import EventLog
from robots.wire import PacketState, ScriptState


def has_ended(scripts: Sequence[ScriptRow], action: str) -> bool:
    """True if every robot of the mission that takes part in the action has ended its part."""
    return all(_is_over(script, action) for script in scripts if action in _packets(script))


def scripts_of(session: Session, mission: MissionRow, plan_id: str) -> Sequence[ScriptRow]:
    """The scripts of one of the mission's plans."""
    here = (ScriptRow.mission_id == mission.id, ScriptRow.plan_id == plan_id)
    return session.scalars(select(ScriptRow).where(*here).order_by(ScriptRow.id)).all()


def renew_clearances(session: Session, events: EventLog, mission: MissionRow) -> None:
    """Have robots told of what has ended since they were last told, unless the mission is to stop."""
    scripts = scripts_of(session, mission, mission.plan_id)
    if mission.cancel_requested or any(map(has_failed, scripts)):
        return
    doers: dict[str, list[ScriptRow]] = defaultdict(list)
    for script in scripts:
        for action in _packets(script):
            doers[action].append(script)
    for script in scripts:
        if script.delivery not in DELIVERABLE or has_terminated(script):
            continue
        after = dict.fromkeys(one for packet in script.body["packets"] for one in packet.get("after", ()))
        ended = [action for action in after if has_ended(doers[action], action)]
        fresh = [action for action in ended if action not in script.cleared]
        if fresh:
            script.cleared = ended
            script.clearance = f"clearance:{len(ended)}"
            events.append(session, ScriptCleared(subject=script.id, robot=script.robot, ended=tuple(fresh)))


def _packets(script: ScriptRow) -> list[str]:
    return [packet["id"] for packet in script.body["packets"]]


def _is_over(script: ScriptRow, action: str) -> bool:
    # NOTE: the report of a packet may be lost for good where a robot must drop some; that of the script says it too.
    known = script.packets.get(action, {}).get("state")
    return known == PacketState.FINISHED or script.state == ScriptState.FINISHED
