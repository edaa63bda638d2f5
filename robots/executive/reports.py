"""The executive's reports on a script and its packets."""

from collections.abc import Sequence

from robots.conditions.facts import perceived
from robots.executive.delegation import is_awarded
from robots.executive.packet_run import PacketRun
from robots.perception.percepts import Percepts
from robots.wire import (
    BehaviourScript,
    FailureCategory,
    PacketReport,
    PacketResult,
    PacketState,
    ScriptReport,
    ScriptState,
    UpkeepReport,
)

Report = PacketReport | ScriptReport | UpkeepReport
REPORTED_OF_OWN = (PacketState.RUNNING, PacketState.FINISHED, PacketState.FAILED)
"""The states of packets of the robot's own scripts that are reported."""


def packet_report(
    script: BehaviourScript,
    run: PacketRun,
    state: PacketState,
    percepts: Percepts | None,
    at_s: float,
    detail: str = "",
    events: tuple[str, ...] = (),
    results: tuple[PacketResult, ...] = (),
) -> list[Report]:
    """One report on a packet, or none."""
    if script.is_own:
        return _upkeep_report(script, run, state, percepts, at_s, detail)
    return [
        PacketReport(
            script_id=script.id,
            packet_id=run.packet.id,
            state=state,
            at_s=at_s,
            perceived=perceived(percepts),
            events=events,
            detail=detail,
            results=results,
            cleared_by=run.cleared_by if state is PacketState.RUNNING else {},
        )
    ]


def _upkeep_report(
    script: BehaviourScript,
    run: PacketRun,
    state: PacketState,
    percepts: Percepts | None,
    at_s: float,
    detail: str,
) -> list[Report]:
    """Without facts for a packet that starts to drive somewhere: the robot is about to leave its place."""
    # NOTE: what it does of a leg the robot of the script reports; the plan would seem broken by half of the news.
    if state not in REPORTED_OF_OWN or is_awarded(script):
        return []
    driver = run.packet.arguments.get("driver")
    departs = state is PacketState.RUNNING and (run.content.goal or driver) is not None
    facts = () if departs else perceived(percepts)
    tag = run.packet.tag
    return [UpkeepReport(tag=tag, state=state, at_s=at_s, perceived=facts, detail=detail, driver=driver)]


def script_report(
    script: BehaviourScript,
    runs: Sequence[PacketRun],
    index: int,
    state: ScriptState,
    percepts: Percepts | None,
    at_s: float,
    category: FailureCategory | None = None,
    detail: str = "",
) -> list[Report]:
    """How a script ended, at the packet of an index. Of the robot's own scripts only those by which it has done
    another robot's leg are reported: where it stands, and what it holds if it has failed.
    """
    if is_awarded(script):
        return _awarded_report(script, index, state, percepts, at_s, detail)
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
            done_by={run.packet.id: run.done_by for run in runs if run.done_by},
        )
    ]


def _awarded_report(
    script: BehaviourScript,
    index: int,
    state: ScriptState,
    percepts: Percepts | None,
    at_s: float,
    detail: str,
) -> list[Report]:
    ended = PacketState.FINISHED if state is ScriptState.FINISHED else PacketState.FAILED
    own = tuple(fact for fact in perceived(percepts) if script.robot in fact.args)
    tag = script.packets[index].tag
    return [UpkeepReport(tag=tag, state=ended, at_s=at_s, perceived=own, detail=detail)]


def cancelled_before_arrival_report(script_id: str, percepts: Percepts | None, at_s: float) -> ScriptReport:
    return ScriptReport(
        script_id=script_id,
        state=ScriptState.CANCELLED,
        at_s=at_s,
        category=FailureCategory.CANCELLED,
        perceived=perceived(percepts),
        detail="cancelled before it arrived",
    )
