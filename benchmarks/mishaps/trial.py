"""One case in one seed's world, and how it ended."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.mishaps.acts import Stage
from benchmarks.mishaps.cases import Case, cases
from benchmarks.mishaps.injection import FaultInjector
from robots.physical.body import RADIUS_M, Pose
from robots.wire import PacketState, ScriptState
from robots.world import WorldFile
from robots.world.walls import clearance_m, panels_of
from sim.trials.script_runner import ScriptRunner

WALL_M = RADIUS_M - 0.03
"""A rover whose middle is nearer to a wall's surface than this is in it."""
OUTCOMES = ("recovered", "reported", "wrong", "silent")


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How one trial ended: `took_s` after the mishap, None without one; `walled`: the robot was in a wall.

    `end`: its true pose.
    """

    how: str
    took_s: float | None
    words: str = ""
    walled: bool = False
    end: Pose | None = None


def with_rules(world: WorldFile, rules: Mapping[str, str]) -> WorldFile:
    """The world with these rule files on all of its robots."""
    data = world.model_dump()
    robots = [{**robot, "rules": dict(rules)} for robot in data["robots"]]
    return WorldFile.model_validate({**data, "robots": robots})


class Trial:
    """One case in one seed's world."""

    def __init__(self, case: Case, seed: int, rules: Mapping[str, str] | None = None) -> None:
        """:param rules: rule files of all robots, by name; None: those of the world."""
        faults = FaultInjector()
        self._case, self._work = case, case.of()
        world = self._work.world if rules is None else with_rules(self._work.world, rules)
        self._runner = ScriptRunner(world, seed=seed, make_agent=faults.make_agent)
        self._stage = Stage(
            simulation=self._runner.simulation,
            faults=faults,
            rng=np.random.default_rng(seed),
            robot=case.robot,
            sample=self._work.sample,
        )
        self._panels = panels_of(self._runner.world.walls)
        self._done_s: float | None = None
        self._undone = self._given_up = False
        self._walled = False

    def run(self) -> Outcome:
        work, simulation = self._work, self._runner.simulation
        try:
            over = self._runner.run(work.scripts, timeout_s=work.limit_s, meanwhile=self._meddle)
            truth = simulation.truth()
        finally:
            simulation.close()
        sample, ended = truth.samples[work.sample], self._runner.ended.values()
        failed = [one.detail for one in ended if one.state is ScriptState.FAILED]
        right = sample.place == work.goal and not sample.holders
        words = "; ".join(failed)
        if not over:
            how = "silent"
        elif failed:
            how = "reported"
        else:
            how, words = ("recovered", "") if right else ("wrong", f"{work.sample} is in {sample.ref}")
        return Outcome(
            how=how,
            took_s=None if self._done_s is None else truth.time_s - self._done_s,
            words=words,
            walled=self._walled,
            end=truth.robots[self._case.robot],
        )

    def _meddle(self) -> None:
        now_s, case = self._runner.simulation.clock.now_s(), self._case
        if self._done_s is None and self._ran_s() >= case.after_s:
            self._done_s = now_s
            case.do(self._stage)
        elif (
            self._done_s is not None
            and case.undo
            and not self._undone
            and now_s - self._done_s >= case.undo_s
        ):
            self._undone = True
            case.undo(self._stage)
        if not self._given_up and any(
            one.state is not ScriptState.FINISHED for one in self._runner.ended.values()
        ):
            self._given_up = True
            self._make_safe()
        pose = self._stage.pose
        self._walled |= clearance_m((pose.x_m, pose.y_m), self._panels) < WALL_M

    def _make_safe(self) -> None:
        """Stop the others once one robot has failed, as the service does."""
        for script in self._work.scripts:
            if script.id not in self._runner.ended:
                self._runner.cancel(script)

    def _ran_s(self) -> float:
        """How long the patterns of the case's packet have acted; -1 if they do not."""
        mine = {one.id for one in self._work.scripts if one.robot == self._case.robot}
        last = next((one for one in reversed(self._runner.reports) if one.script_id in mine), None)
        if (
            last is None
            or last.state is not PacketState.RUNNING
            or not last.packet_id.endswith(f"_{self._case.during.lower()}")
        ):
            return -1.0
        return self._runner.simulation.clock.now_s() - last.at_s


def run(order: tuple[int, int]) -> Outcome:
    """One trial. :param order: the case's number among `cases()`, and the seed."""
    number, seed = order
    return Trial(tuple(cases())[number], seed).run()
