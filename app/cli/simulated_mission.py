"""Runs a mission in a simulated world, in this process, as fast as possible and without a service."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from app.cli.ground_truth import holds, is_near
from app.cli.trials.offline_mission import Mission
from app.cli.trials.sweep_results import Outcome
from robots.wire import BehaviourScript, PacketReport, PacketState, ScriptReport, ScriptState, SymbolicFact
from robots.world import WorldFile
from sim import Truth
from sim.trials.script_runner import ScriptRunner
from sim.world.agents import agents_with

BASE_LIMIT_S = 300.0
LIMIT_FACTOR = 6.0
"""A mission may take the base limit and this factor times its estimate."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionResult:
    """How a mission ended: the simulation's ground truth and the robots' reports."""

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


@dataclass
class _Witness:
    """Notes which facts packets brought about where they say: at their end, in the simulated world.

    Of facts that leave no trace there, such as that a place was inspected, this is the ground truth: a packet that
    achieves the fact has ended, and robots that carry it out truly stand by the places that the fact names.
    """

    world: WorldFile
    seen: set[SymbolicFact] = field(default_factory=set)
    _noted: int = 0

    def note(self, runner: ScriptRunner) -> None:
        for report in runner.reports[self._noted :]:
            if report.state is PacketState.FINISHED:
                self._note(report, runner)
        self._noted = len(runner.reports)

    def _note(self, report: PacketReport, runner: ScriptRunner) -> None:
        parts = {
            script.robot: p for script in runner.scripts for p in script.packets if p.id == report.packet_id
        }
        truth = runner.simulation.truth()
        places = {place.name for place in self.world.places}
        for fact in next(iter(parts.values())).achieves:
            named = places.intersection(fact.args)
            if named and all(
                any(is_near(truth, robot, place, self.world) for robot in parts) for place in named
            ):
                self.seen.add(fact)


def simulate_mission(
    mission: Mission,
    *,
    seed: int,
    packet_files: Sequence[Path] | None = None,
    watch: Callable[[Truth], None] | None = None,
) -> MissionResult:
    """Run until all scripts have finished, or one has failed or was refused.

    :param packet_files: of the robots' repertoires; None: the packets of `store`.
    :param watch: called with the ground truth 20 times a second of the world's time.
    """
    limit_s = BASE_LIMIT_S + LIMIT_FACTOR * mission.plan_net.makespan_s
    with ScriptRunner(mission.world, seed=seed, make_agent=agents_with(packet_files)) as runner:
        witness = _Witness(mission.world)
        runner.send(mission.scripts)
        names = {script.id for script in mission.scripts}

        def is_over() -> bool:
            if watch is not None:
                watch(runner.simulation.truth())
            runner.receive()
            witness.note(runner)
            return bool(_failed(runner) or runner.refused) or names <= set(runner.ended)

        runner.simulation.run_until(is_over, timeout_s=limit_s)
        return _result(runner, mission, limit_s, witness.seen)


def _failed(runner: ScriptRunner) -> list[ScriptReport]:
    return [report for report in runner.ended.values() if report.state is not ScriptState.FINISHED]


def _result(
    runner: ScriptRunner, mission: Mission, limit_s: float, witnessed: Collection[SymbolicFact]
) -> MissionResult:
    truth = runner.simulation.truth()
    result = partial(MissionResult, truth=truth, reports=tuple(runner.ended.values()))
    if failed := _failed(runner):
        script = next(script for script in runner.scripts if script.id == failed[0].script_id)
        packet = _tag(script, failed[0].packet_id)
        return result(outcome=Outcome.FAILED, packet=packet, reason=failed[0].detail)
    if runner.refused:
        refusal = next(iter(runner.refused.values()))
        return result(outcome=Outcome.FAILED, reason=f"refused: {refusal.reason}")
    if len(runner.ended) < len(mission.scripts):
        reason = f"not ended after {limit_s:.0f} s: {', '.join(_under_way(runner))}"
        return result(outcome=Outcome.UNENDED, reason=reason)
    held = {goal: holds(goal, mission.world, truth) for goal in mission.goals}
    if untrue := [goal for goal, true in held.items() if not (goal in witnessed if true is None else true)]:
        return result(outcome=Outcome.UNTRUE, reason=", ".join(_found(goal, truth) for goal in untrue))
    return result(outcome=Outcome.CAME_TRUE)


def _tag(script: BehaviourScript, packet_id: str | None) -> str | None:
    return next((packet.tag for packet in script.packets if packet.id == packet_id), None)


def _under_way(runner: ScriptRunner) -> list[str]:
    """Each robot that has not ended, with its current packet."""
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
