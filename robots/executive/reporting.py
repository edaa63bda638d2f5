"""What the executive says of a script and its packets, as reports for the service."""

from robots.conditions.facts import perceived
from robots.executive.packet_run import PacketRun
from robots.perception.percepts import Percepts
from robots.wire import (
    BehaviourScript,
    FailureCategory,
    PacketReport,
    PacketState,
    ScriptReport,
    ScriptState,
    UpkeepReport,
)

Report = PacketReport | ScriptReport | UpkeepReport
TOLD = (PacketState.RUNNING, PacketState.FINISHED, PacketState.FAILED)
"""Of packets of the robot's own only this is reported."""


def packet_report(
    script: BehaviourScript,
    run: PacketRun,
    state: PacketState,
    percepts: Percepts | None,
    at_s: float,
    detail: str = "",
    events: tuple[str, ...] = (),
) -> list[Report]:
    """What to say of a packet's state or news: one report, or none."""
    if script.is_own:
        return _upkeep_report(run, state, percepts, at_s, detail)
    return [
        PacketReport(
            script_id=script.id,
            packet_id=run.packet.id,
            state=state,
            at_s=at_s,
            perceived=perceived(percepts),
            events=events,
            detail=detail,
        )
    ]


def _upkeep_report(
    run: PacketRun, state: PacketState, percepts: Percepts | None, at_s: float, detail: str
) -> list[Report]:
    """Once it has begun to go somewhere it is not where it was, and perceives no more than that."""
    if state not in TOLD:
        return []
    driver = run.packet.arguments.get("driver")
    sets_off = state is PacketState.RUNNING and (run.content.goal or driver) is not None
    facts = () if sets_off else perceived(percepts)
    tag = run.packet.tag
    return [UpkeepReport(tag=tag, state=state, at_s=at_s, perceived=facts, detail=detail, driver=driver)]


def script_report(
    script: BehaviourScript,
    index: int,
    state: ScriptState,
    percepts: Percepts | None,
    at_s: float,
    category: FailureCategory | None = None,
    detail: str = "",
) -> list[Report]:
    """How a script ended, at the packet of an index; of the robot's own nothing is said."""
    if script.is_own:
        return []
    return [
        ScriptReport(
            script_id=script.id,
            state=state,
            at_s=at_s,
            packet_id=script.packets[index].id,
            category=category,
            perceived=perceived(percepts),
            detail=detail,
        )
    ]


def forgone_report(script_id: str, percepts: Percepts | None, at_s: float) -> list[Report]:
    """A script was cancelled before it arrived."""
    return [
        ScriptReport(
            script_id=script_id,
            state=ScriptState.CANCELLED,
            at_s=at_s,
            category=FailureCategory.CANCELLED,
            perceived=perceived(percepts),
            detail="cancelled before it arrived",
        )
    ]
