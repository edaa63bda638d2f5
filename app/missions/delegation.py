"""Legs that a robot in the field has put to others: what it reports of them, and which robot has done what.

A mission's scripts name the legs and the robots if the approval has granted it; anything else is not believed. The
robot of the script stays the one that reports on it; what the other has done has its effects, of that robot.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.events import LegDelegated
from app.domain.lifecycles.script import hear
from app.domain.world_model.beliefs import NEAR, ROBOT_POSITION
from app.store import MissionRow, ScriptRow
from planner import Fact, PlanNetAction
from robots.wire import BehaviourScript, DelegationReport, DelegationState, PacketState, ScriptState

DONE_BY = "delegated_to"
"""In the record of a packet: the robot that does it, or has done it, in the stead of the script's."""
TOLD_AT_S = "delegation_told_at_s"
"""In the record of a packet: the newest time at which its robot has told who does it, or that nobody does."""
ENDED = frozenset({PacketState.FINISHED, PacketState.FAILED})


def granted_packets(script: ScriptRow, leg: str, robot: str) -> tuple[str, ...]:
    """The packets of a leg of the script that a robot may do; none if it may not."""
    legs = BehaviourScript.model_validate(script.body).delegable
    return next((one.packets for one in legs if one.id == leg and robot in one.robots), ())


def granted_to(script: ScriptRow, done_by: Mapping[str, str]) -> Mapping[str, str]:
    """Of what a robot says that others have done, that which its script lets them do."""
    if not done_by:
        return {}
    may = {
        (packet, robot)
        for leg in BehaviourScript.model_validate(script.body).delegable
        for packet in leg.packets
        for robot in leg.robots
    }
    return {packet: robot for packet, robot in done_by.items() if (packet, robot) in may}


def done_by(scripts: Iterable[ScriptRow]) -> Mapping[str, tuple[str, str]]:
    """By action that another robot does or has done: the robot of the script, and that one."""
    return {
        packet: (script.robot, known[DONE_BY])
        for script in scripts
        for packet, known in script.packets.items()
        if DONE_BY in known
    }


def as_done(action: PlanNetAction, by: Mapping[str, tuple[str, str]]) -> PlanNetAction:
    """The action as it was done: by another robot it has the effects on what was moved, and none on where that stands,
    for it has left again.
    """
    if action.id not in by:
        return action
    robot, other = by[action.id]

    def theirs(facts: Sequence[Fact]) -> tuple[Fact, ...]:
        return tuple(
            Fact(fact.predicate, tuple(other if arg == robot else arg for arg in fact.args))
            for fact in facts
            if fact.predicate != ROBOT_POSITION
        )

    return replace(
        action,
        intended_effects=theirs(action.intended_effects),
        other_effects=theirs(action.other_effects),
        deletes=theirs(action.deletes),
    )


class DelegationRecord:
    """Records reports on delegated legs, inside the caller's transaction."""

    def __init__(self, core: Core) -> None:
        self._events = core.events

    def note(
        self, session: Session, report: DelegationReport, script: ScriptRow, mission: MissionRow
    ) -> Collection[str] | None:
        """Record who does a leg, or has done it.

        :returns: the packets whose end this tells; None if nothing of it is granted.
        """
        leg = next((one for one in script.body.get("delegable", ()) if one["id"] == report.leg), None)
        may = granted_packets(script, report.leg, report.robot) if report.robot else ()
        is_nobodys = report.state is DelegationState.NOT_TAKEN and not report.robot
        if leg is None or not (may or is_nobodys):
            return None
        hear(script, ScriptState.RUNNING, report.at_s)
        if report.state is DelegationState.AWARDED and mission.enquire_at_s is not None:
            ends_s = report.at_s + report.expected_s + mission.margin_s
            mission.enquire_at_s = max(mission.enquire_at_s, ends_s)
        left = [one for one in leg["packets"] if script.packets.get(one, {}).get("state") not in ENDED]
        if report.state is DelegationState.DONE:
            finish_by(script, dict.fromkeys(left, report.robot), report.at_s)
        else:
            is_under_way = report.state is DelegationState.AWARDED
            _assign(script, left, report.robot if is_under_way else "", report.at_s)
        self._events.append(
            session,
            LegDelegated(
                subject=mission.id,
                robot=script.robot,
                to=report.robot,
                state=report.state,
                packets=tuple(leg["packets"]),
                bids=report.bids,
                at_s=report.at_s,
                detail=report.detail,
            ),
        )
        return left if report.state is DelegationState.DONE else ()


def finish_by(script: ScriptRow, done_by: Mapping[str, str], at_s: float) -> None:
    """Record that other robots have done packets of the script.

    NOTE: as `implied`: when each of them began and ended nobody has reported.
    """
    told = {"state": PacketState.FINISHED.value, "at_s": at_s, "finished_at_s": at_s, "implied": True}
    packets = dict(script.packets)
    for packet, robot in done_by.items():
        packets[packet] = {**packets.get(packet, {}), **told, DONE_BY: robot, "detail": ""}
    script.packets = packets


def stand_after(report: DelegationReport, robot: str) -> tuple[Fact, ...]:
    """Where the two robots stand once the leg is done, as far as the report says it."""
    stands = ((report.robot, report.stands), (robot, report.aside))
    return tuple(Fact(ROBOT_POSITION, (name, NEAR, place)) for name, place in stands if place)


def _assign(script: ScriptRow, packets: Sequence[str], robot: str, at_s: float) -> None:
    """Note who does packets that are not done yet; nobody else if it is empty. What is newer stands."""
    known = dict[str, Any](script.packets)
    for packet in packets:
        before = known.get(packet, {"state": PacketState.WAITING.value, "at_s": at_s})
        if before.get(TOLD_AT_S, at_s) > at_s:
            continue
        without = {name: value for name, value in before.items() if name != DONE_BY}
        known[packet] = without | {TOLD_AT_S: at_s} | ({DONE_BY: robot} if robot else {})
    script.packets = known
