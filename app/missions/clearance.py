"""Clearance: a message to a robot that actions have ended which its packets wait for and whose end it cannot sense.

Robots that speak with each other may have it earlier from those that its script names (`told_by`); that a robot says so
does not end the other's action in the record, which its own report does.

Clearances follow from the actions that have ended; they are derived again with each report and kept in the record until
the robot has acknowledged them.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from sqlalchemy.orm import Session

from app.domain.events import ScriptCleared
from app.domain.lifecycles.script import DELIVERABLE, has_failed, has_terminated
from app.domain.mission_organiser.synchronisation import time_of
from app.store import MissionRow, ScriptRow
from app.store.event_log import EventLog
from robots.wire import PacketReport, PacketState, ScriptReport, ScriptState


def action_has_ended(scripts: Iterable[ScriptRow], action: str) -> bool:
    """True if every robot that takes part in the action has ended its part.

    :param scripts: all of one plan.
    """
    if time_of(action) is not None:  # which has come for all at once, when it was noticed
        return any(action in script.cleared for script in scripts)
    return all(_has_ended_its_part(script, action) for script in scripts if action in packets_of(script))


def next_time_s(scripts: Iterable[ScriptRow]) -> float | None:
    """The next time, by the world's clock, that a packet waits for and that has not been noticed to have come."""
    awaited = (
        time_of(one)
        for script in scripts
        if script.delivery in DELIVERABLE and not has_terminated(script)
        for packet in script.body["packets"]
        for one in packet.get("after", ())
        if one not in script.cleared
    )
    return min((at_s for at_s in awaited if at_s is not None), default=None)


def told_by_peers(
    script: ScriptRow, packet_id: str, said: Mapping[str, Sequence[str]]
) -> dict[str, list[str]]:
    """Of what a robot says that others have told it, that which its script has it believe.

    :param said: by action, the robots that have told the robot of its end.
    """
    packets: Sequence[Mapping[str, Any]] = script.body["packets"]
    named: Mapping[str, Sequence[str]] = next(
        (one.get("told_by", {}) for one in packets if one["id"] == packet_id), {}
    )
    return {
        action: sorted(named[action])
        for action in said
        if named.get(action) and {*named[action]} <= {*said[action]}
    }


def begun_uncleared(
    packet_id: str,
    script: ScriptRow,
    scripts: Sequence[ScriptRow],
    said: Mapping[str, Sequence[str]] | None = None,
) -> tuple[str, str] | None:
    """A packet up to this one, and an action that it waits for and that has not ended; None if there is none.

    A robot that has begun a packet has begun those before it. What it was told by the robots that its script names is
    cleared.
    :param scripts: all of the same plan.
    :param said: by action, who has told the robot of its end, as it says with this packet's beginning.
    """
    for packet in script.body["packets"]:
        told = script.packets.get(packet["id"], {}).get("cleared_by", {})
        if packet["id"] == packet_id and said:
            told = told | told_by_peers(script, packet_id, said)
        for action in packet.get("after", ()):
            is_action = time_of(action) is None
            if is_action and action not in told and not action_has_ended(scripts, action):
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


def said_with(report: object) -> Mapping[str, Sequence[str]]:
    """By action, the robots that have told the reporting one of its end."""
    return report.cleared_by if isinstance(report, PacketReport) else {}


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
    session: Session,
    events: EventLog,
    mission: MissionRow,
    scripts: Sequence[ScriptRow],
    *,
    now_s: float | None = None,
) -> None:
    """Record new clearances for actions that have ended since the last ones, unless the mission is to stop.

    :param scripts: all of the plan that the mission carries out now.
    :param now_s: by the world's clock; None: it is not looked for times that have come.
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
        ended = [one for one in after if _has_come(one, script, doers, now_s)]
        fresh = [action for action in ended if action not in script.cleared]
        if fresh:
            script.cleared = ended
            script.clearance = f"clearance:{len(ended)}"
            events.append(session, ScriptCleared(subject=script.id, robot=script.robot, ended=tuple(fresh)))


def _has_come(
    awaited: str, script: ScriptRow, doers: Mapping[str, Sequence[ScriptRow]], now_s: float | None
) -> bool:
    """True if the action has ended, or the time has come, that the script's robot waits for."""
    at_s = time_of(awaited)
    if at_s is None:
        return action_has_ended(doers.get(awaited, ()), awaited)
    return awaited in script.cleared or (now_s is not None and at_s <= now_s)


def _has_ended_its_part(script: ScriptRow, action: str) -> bool:
    # A robot may drop a packet's report when its storage is full; the script's report implies it.
    known = script.packets.get(action, {}).get("state")
    return known == PacketState.FINISHED or script.state == ScriptState.FINISHED
