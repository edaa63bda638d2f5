"""Clearance: a message to a robot that actions have ended which its packets wait for and whose end it cannot sense.

Clearances follow from the actions that have ended; they are derived again with each report and kept in the record until
the robot has acknowledged them.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence

from sqlalchemy.orm import Session

from app.domain.events import ScriptCleared
from app.domain.lifecycles.script import DELIVERABLE, has_failed, has_terminated
from app.store import MissionRow, ScriptRow
from app.store.event_log import EventLog
from robots.wire import PacketReport, PacketState, ScriptReport, ScriptState


def action_has_ended(scripts: Iterable[ScriptRow], action: str) -> bool:
    """True if every robot that takes part in the action has ended its part.

    :param scripts: all of one plan.
    """
    return all(_has_ended_its_part(script, action) for script in scripts if action in packets_of(script))


def begun_uncleared(
    packet_id: str, script: ScriptRow, scripts: Sequence[ScriptRow]
) -> tuple[str, str] | None:
    """A packet up to this one, and an action that it waits for and that has not ended; None if there is none.

    A robot that has begun a packet has begun those before it.
    :param scripts: all of the same plan.
    """
    for packet in script.body["packets"]:
        for action in packet.get("after", ()):
            if not action_has_ended(scripts, action):
                return packet["id"], action
        if packet["id"] == packet_id:
            return None
    return None


def counterparts(script: ScriptRow, scripts: Sequence[ScriptRow]) -> tuple[str, ...]:
    """The robots that have not ended what this one waits for.

    :param scripts: all of the same plan.
    """
    awaited = {action for packet in script.body["packets"] for action in packet.get("after", ())}
    return tuple(
        one.robot
        for one in scripts
        if one is not script
        and any(a in awaited and not _has_ended_its_part(one, a) for a in packets_of(one))
    )


def begun_by(report: object, script: ScriptRow) -> str | None:
    """The packet up to which the robot reports to have begun its script; None if the report is another."""
    if isinstance(report, PacketReport) and report.state is PacketState.RUNNING:
        return report.packet_id if report.packet_id in packets_of(script) else None
    return finished_by(report, script)


def finished_by(report: object, script: ScriptRow) -> str | None:
    """The packet up to which the robot reports to have finished its script; None if the report is another."""
    packets = packets_of(script)
    match report:
        case PacketReport(state=PacketState.FINISHED, packet_id=packet):
            return packet if packet in packets else None
        case ScriptReport(state=ScriptState.FINISHED):
            return packets[-1]
    return None


def packets_of(script: ScriptRow) -> list[str]:
    """The ids of the script's packets, in order."""
    return [packet["id"] for packet in script.body["packets"]]


def renew_clearances(
    session: Session, events: EventLog, mission: MissionRow, scripts: Sequence[ScriptRow]
) -> None:
    """Record new clearances for actions that have ended since the last ones, unless the mission is to stop.

    :param scripts: all of the plan that the mission carries out now.
    """
    if mission.cancel_requested or any(map(has_failed, scripts)):
        return
    doers: dict[str, list[ScriptRow]] = defaultdict(list)
    for script in scripts:
        for action in packets_of(script):
            doers[action].append(script)
    for script in scripts:
        if script.delivery not in DELIVERABLE or has_terminated(script):
            continue
        after = dict.fromkeys(one for packet in script.body["packets"] for one in packet.get("after", ()))
        ended = [action for action in after if action_has_ended(doers[action], action)]
        fresh = [action for action in ended if action not in script.cleared]
        if fresh:
            script.cleared = ended
            script.clearance = f"clearance:{len(ended)}"
            events.append(session, ScriptCleared(subject=script.id, robot=script.robot, ended=tuple(fresh)))


def _has_ended_its_part(script: ScriptRow, action: str) -> bool:
    # A robot may drop a packet's report when its storage is full; the script's report implies it.
    known = script.packets.get(action, {}).get("state")
    return known == PacketState.FINISHED or script.state == ScriptState.FINISHED
