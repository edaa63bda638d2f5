"""One mission with one mishap: the whole service, simulated robots and a simulated operator."""

import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Event

import numpy as np

from app.cli.ground_truth import holds
from app.composition import Service
from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.recovery import RecoveryStep
from app.planning.goal_service import GoalRequest
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from app.store import MissionRow, PlanRow
from benchmarks.far_world import FarWorld
from benchmarks.mishaps.injection import FaultInjector
from benchmarks.planned import planned
from benchmarks.recoveries.cases import DISPATCH, Case, MissionStage
from benchmarks.recoveries.watch import WatchedRadio
from robots.wire import SymbolicFact
from sim.truth import Truth
from sim.world.simulation import Simulation

RATE = 20.0
PATIENCE_S = 2.0
"""Wall-clock seconds before a robot counts as silent."""
GIVES_UP_S = 100.0
"""World seconds after which the operator declares a silent robot lost."""
LIMIT_S = 1500.0
"""World seconds from the approval; a mission that has not ended by then counts as silent."""
LOOK_S = 0.05
OPERATOR = "benchmark"
OUTCOMES = ("came true", "ended", "asked", "wrong", "silent")


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How one trial ended.

    :param how: of `OUTCOMES`. `came true`: completed, and the goal is true in the world; `ended`: not completed,
        with a reason; `asked`: it waits for the operator, who is told why; `wrong`: completed, but the goal is false;
        `silent`: none of these within the limit.
    :param took_s: world seconds from the mishap to the end, None without a mishap.
    :param measures: the recovery's measure and outcome, attempt by attempt.
    :param lost: the robots that the operator declared lost.
    :param beliefs: final beliefs about samples that are false in the world, unless the sample is listed as unknown.
    :param unsafe: robots still at work for the mission though it has ended, neither lost nor with a broken radio.
    """

    how: str
    took_s: float | None
    state: str
    reason: str
    measures: Sequence[str]
    decisions: int
    lost: Sequence[str]
    beliefs: Sequence[str]
    unsafe: Sequence[str]


class Trial:
    """One case in one seed's world."""

    def __init__(self, case: Case, seed: int, *, policy: str = "auto") -> None:
        self._case, self._seed, self._policy = case, seed, policy
        self._world = case.of.world_file()
        self._faults, self._rng = FaultInjector(), np.random.default_rng(seed)
        self._radios = {
            spec.name: WatchedRadio(self._world.link_of(spec), robot=spec.name, seed=seed)
            for spec in self._world.robots
        }
        self._stage: MissionStage | None = None
        self._planned: Sequence[str] = ()
        self._befallen, self._done_s, self._undone = Event(), 0.0, False
        self._silent_since_s: float | None = None
        self._lost: list[str] = []
        self._decisions = 0

    def run(self, worker: PlanningWorker) -> Outcome:
        """:raises RuntimeError: if there is no plan to begin with."""
        with tempfile.TemporaryDirectory() as folder:
            settings = Settings(
                data=Path(folder),
                token="a-token-of-the-benchmark",
                database_url=None,
                answer_patience_s=PATIENCE_S,
            )
            far = FarWorld(
                self._world,
                seed=self._seed,
                radios=self._radios,
                rate=RATE,
                make_agent=self._faults.make_agent,
                meanwhile=self._meddle,
            )
            with far, Service(settings, [far.running], worker=worker) as service:
                return self._carried_out(far, service)

    def _meddle(self, simulation: Simulation) -> None:
        """Cause or undo the mishap when it is due; called in the world's thread at 20 Hz."""
        now_s, case = simulation.clock.now_s(), self._case
        if self._befallen.is_set():
            if case.undo is not None and not self._undone and now_s - self._done_s >= case.undo_s:
                self._undone = True
                case.undo(self._at(simulation, ""))
            return
        robot = self._due(now_s)
        if robot is not None:
            self._done_s = now_s
            case.do(self._at(simulation, robot))
            self._befallen.set()

    def _due(self, now_s: float) -> str | None:
        """The robot whose mishap is due now."""
        mine = [name for name in self._radios if name.startswith(self._case.robot)]
        if self._case.during == DISPATCH:
            return next((name for name in mine if name in self._planned), None)
        for name in mine:
            begun_s = self._radios[name].watch.begun_s.get(self._case.during)
            if begun_s is not None and now_s - begun_s >= self._case.after_s:
                return name
        return None

    def _at(self, simulation: Simulation, robot: str) -> MissionStage:
        if self._stage is None:
            self._stage = MissionStage(
                simulation=simulation,
                faults=self._faults,
                rng=self._rng,
                robot=robot,
                sample=self._case.of.sample,
                radios=self._radios,
            )
        return self._stage

    def _carried_out(self, far: FarWorld, service: Service) -> Outcome:
        plan = self._plan(service)
        if self._case.during == DISPATCH:
            self._planned = list(plan.body["robots"])
            self._befallen.wait(timeout=60)
        begun_s = far.simulation.clock.now_s()
        _, mission_id = service.plans.approve(plan.id, actor=OPERATOR, comment="")
        while True:
            mission, _ = service.missions.get(mission_id)
            now_s = far.simulation.clock.now_s()
            over = MissionState(mission.state).ended or mission.recovery_step == RecoveryStep.STUCK
            if over or now_s > begun_s + LIMIT_S or far.error is not None:
                break
            self._operate(service, mission, now_s)
            time.sleep(LOOK_S)
        if far.error is not None:
            raise RuntimeError(f"{self._case}: the world broke") from far.error
        time.sleep(0.5)  # for messages under way
        return self._outcome(service, mission, far.simulation.truth())

    def _plan(self, service: Service) -> PlanRow:
        task = self._case.of
        request = GoalRequest(world=task.world, text=task.text, recovery=self._policy)
        _, plan_id = planned(service, request)
        return service.plans.get(plan_id)

    def _operate(self, service: Service, mission: MissionRow, now_s: float) -> None:
        """Approve pending repairs; declare silent robots lost."""
        if mission.recovery_step == RecoveryStep.DECIDING:
            self._decisions += 1
            service.plans.approve(mission.attempts[-1]["plan_id"], actor=OPERATOR, comment="")
        if mission.state != MissionState.UNKNOWN:
            self._silent_since_s = None
            return
        self._silent_since_s = now_s if self._silent_since_s is None else self._silent_since_s
        mended = self._case.undo is not None
        if mended or now_s - self._silent_since_s < GIVES_UP_S:
            return
        for one in service.worlds.unknown(mission.world):
            if one.name in self._radios and one.name not in self._lost:
                self._lost.append(one.name)
                service.lost_robots.declare_lost(mission.world, one.name, actor=OPERATOR, comment="")

    def _outcome(self, service: Service, mission: MissionRow, truth: Truth) -> Outcome:
        task, state = self._case.of, MissionState(mission.state)
        goal = SymbolicFact(predicate="in", args=(task.sample, task.place))
        true = holds(goal, self._world, truth)
        if state is MissionState.COMPLETED:
            how = "came true" if true else "wrong"
        elif state.ended:
            how = "ended" if mission.reason else "wrong"
        else:
            how = "asked" if mission.recovery_step == RecoveryStep.STUCK else "silent"
        unsafe = [
            name
            for name, radio in self._radios.items()
            if state.ended and radio.watch.at_work and name not in self._lost and not radio.broken
        ]
        return Outcome(
            how=how,
            took_s=truth.time_s - self._done_s if self._befallen.is_set() else None,
            state=f"{mission.state}{'' if true == (how == 'came true') else ', though it is true'}",
            reason=mission.reason,
            measures=[f"{one['measure'] or 'no'} {one['outcome']}" for one in mission.attempts],
            decisions=self._decisions,
            lost=self._lost,
            beliefs=self._false_beliefs(service, truth),
            unsafe=unsafe,
        )

    def _false_beliefs(self, service: Service, truth: Truth) -> list[str]:
        world = self._case.of.world
        rows, _ = service.worlds.facts(world)
        doubted = {one.name for one in service.worlds.unknown(world)}
        samples = truth.samples.keys() - doubted
        placed = [args for (predicate, args), _ in rows if predicate == "in" and args[0] in samples]
        return [
            f"{sample} in {ref}, is in {truth.samples[sample].ref or 'no place'}"
            for sample, ref in placed
            if ref not in (truth.samples[sample].place, *truth.samples[sample].holders)
        ]
