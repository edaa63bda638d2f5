"""A mission carried out in a simulated world in this process, flat out, without a service."""

from collections.abc import Sequence
from dataclasses import dataclass

from app.cli.truth import holds
from app.trials.offline_mission import Mission
from app.trials.sweep_results import Outcome
from robots.wire import BehaviourScript, ScriptReport, ScriptState, SymbolicFact
from sim import Truth
from sim.trials.script_runner import ScriptRunner

PATIENCE_S, PATIENCE_FACTOR = 300.0, 6.0
"""The longest that a mission may take: so much, and so many times its estimate."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How a mission ended, in the simulated world itself and in the robots' own words."""

    truth: Truth
    reports: Sequence[ScriptReport]
    outcome: Outcome
    packet: str | None = None
    reason: str = ""

    @property
    def came_true(self) -> bool:
        return self.outcome is Outcome.CAME_TRUE

    @property
    def words(self) -> list[str]:
        return [f"{report.script_id}: {report.state} {report.detail}" for report in self.reports]


def carry_out(mission: Mission, *, seed: int) -> Ended:
    """Have the simulated robots do it, until all have finished or one has failed."""
    limit_s = PATIENCE_S + PATIENCE_FACTOR * mission.plan_net.makespan_s
    with ScriptRunner(mission.world, seed=seed) as runner:
        runner.send(mission.scripts)
        names = {script.id for script in mission.scripts}

        def over() -> bool:
            runner.receive()
            return bool(_failed(runner) or runner.refused) or names <= set(runner.ended)

        runner.simulation.run_until(over, timeout_s=limit_s)
        return _ended(runner, mission, limit_s)


def _failed(runner: ScriptRunner) -> list[ScriptReport]:
    return [report for report in runner.ended.values() if report.state is not ScriptState.FINISHED]


def _ended(runner: ScriptRunner, mission: Mission, limit_s: float) -> Ended:
    truth, reports = runner.simulation.truth(), tuple(runner.ended.values())
    outcome, packet, reason = Outcome.CAME_TRUE, None, ""
    if failed := _failed(runner):
        script = next(script for script in runner.scripts if script.id == failed[0].script_id)
        outcome, packet, reason = Outcome.FAILED, _tag(script, failed[0].packet_id), failed[0].detail
    elif runner.refused:
        outcome, reason = Outcome.FAILED, f"refused: {next(iter(runner.refused.values())).reason}"
    elif len(reports) < len(mission.scripts):
        outcome, reason = Outcome.UNENDED, f"not ended after {limit_s:.0f} s: {', '.join(_under_way(runner))}"
    elif untrue := [goal for goal in mission.goals if not holds(goal, mission.world, truth)]:
        outcome, reason = Outcome.UNTRUE, ", ".join(_found(goal, truth) for goal in untrue)
    return Ended(truth=truth, reports=reports, outcome=outcome, packet=packet, reason=reason)


def _tag(script: BehaviourScript, packet_id: str | None) -> str | None:
    return next((packet.tag for packet in script.packets if packet.id == packet_id), None)


def _under_way(runner: ScriptRunner) -> list[str]:
    """Each robot that has not ended, with the packet it is at."""
    under_way = [script for script in runner.scripts if script.id not in runner.ended]
    latest = {report.script_id: report for report in runner.reports}
    return [
        f"{script.robot} {_tag(script, report.packet_id)} {report.state}"
        for script in under_way
        if (report := latest.get(script.id)) is not None
    ]


def _found(goal: SymbolicFact, truth: Truth) -> str:
    sample = truth.samples.get(goal.args[0])
    where = f": it is in {sample.ref or 'no place'}" if sample is not None else ""
    return f"{goal} is not true{where}"
