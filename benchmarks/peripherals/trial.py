"""One mission through doors, hatches and lifts of which one fails: the whole service and simulated robots."""

import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from app.cli.ground_truth import holds
from app.composition import Service
from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.recovery import RecoveryStep
from app.planning.goal_service import GoalRequest
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from app.store import MissionRow
from benchmarks.far_world import FarWorld
from benchmarks.planned import planned
from robots.wire import SymbolicFact
from robots.world import load_world
from sim.world.mechanisms import Fault
from sim.world.radio import radios_of
from sim.world.simulation import Simulation

WORLD = "guarded_store"
RATE = 20.0
PATIENCE_S = 2.0
"""Wall-clock seconds before a silent agent counts as such."""
GIVES_UP_S = 60.0
"""World seconds after which the operator declares it lost."""
LIMIT_S = 1500.0
LOOK_S = 0.05
OPERATOR = "benchmark"
OUTCOMES = ("came true", "ended", "asked", "wrong", "silent")


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """What fails, how, and when.

    :param after_s: world seconds from the approval. :param undo_s: world seconds until it works again; None: never.
    """

    name: str
    sample: str
    place: str
    peripheral: str = ""
    fault: Fault = Fault.NONE
    after_s: float = 0.0
    undo_s: float | None = None

    def __str__(self) -> str:
        return self.name


CASES = (
    Case(name="nothing fails, gate", sample="sample_2", place="bay_1"),
    Case(name="nothing fails, hatch, gate and lift", sample="sample_1", place="bay_5"),
    Case(name="gate jams", sample="sample_2", place="bay_1", peripheral="gate_1", fault=Fault.JAMMED),
    Case(
        name="gate jams for 10 s",
        sample="sample_2",
        place="bay_1",
        peripheral="gate_1",
        fault=Fault.JAMMED,
        undo_s=10.0,
    ),
    Case(
        name="gate sticks half-way",
        sample="sample_2",
        place="bay_1",
        peripheral="gate_1",
        fault=Fault.STICKS,
    ),
    Case(name="gate is silent", sample="sample_2", place="bay_1", peripheral="gate_1", fault=Fault.SILENT),
    Case(
        name="gate shuts before the robot",
        sample="sample_2",
        place="bay_1",
        peripheral="gate_1",
        fault=Fault.SHUTS,
        after_s=18.0,
    ),
    Case(name="hatch jams", sample="sample_1", place="bay_1", peripheral="hatch_1", fault=Fault.JAMMED),
    Case(name="lift jams", sample="sample_3", place="bay_1", peripheral="lift_1", fault=Fault.JAMMED),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How one trial ended.

    :param how: of `OUTCOMES`. `came true`: completed, and the goal is true in the world; `ended`: not completed, with a
        reason; `asked`: it waits for the operator, who is told why; `wrong`: completed, but the goal is false;
        `silent`: none of these within the limit.
    :param took_s: world seconds from the approval. :param ways: the peripherals of the last plan.
    :param out_of_service: the peripherals that are so in the end. :param left_open: those not as they should be left.
    """

    how: str
    took_s: float
    reason: str
    measures: Sequence[str]
    ways: Sequence[str]
    out_of_service: Sequence[str]
    left_open: Sequence[str]


class Trial:
    """One case in one seed's world."""

    def __init__(self, case: Case, seed: int) -> None:
        self._case = case
        self._seed = seed
        self._world = load_world(WORLD)
        self._begun_s: float | None = None
        self._lost = False

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
                radios=radios_of(self._world, self._seed),
                rate=RATE,
                meanwhile=self._meddle,
            )
            with far, Service(settings, [far.running], worker=worker) as service:
                return self._carried_out(far, service)

    def _meddle(self, simulation: Simulation) -> None:
        """Break or mend the peripheral when it is due; called in the world's thread at 20 Hz."""
        case = self._case
        if self._begun_s is None or not case.peripheral:
            return
        since_s = simulation.clock.now_s() - self._begun_s - case.after_s
        if since_s >= 0:
            is_mended = case.undo_s is not None and since_s >= case.undo_s
            mechanism = simulation.peripherals.mechanisms[case.peripheral]
            mechanism.broken = Fault.NONE if is_mended else case.fault

    def _carried_out(self, far: FarWorld, service: Service) -> Outcome:
        case = self._case
        text = f"move {case.sample} to {case.place}"
        request = GoalRequest(world=WORLD, text=text, recovery="auto")
        _, plan_id = planned(service, request)
        self._begun_s = far.simulation.clock.now_s()
        if case.after_s == 0.0:
            time.sleep(2 * LOOK_S)  # the world's thread breaks it
        _, mission_id = service.plans.approve(plan_id, actor=OPERATOR, comment="")
        while True:
            mission, _ = service.missions.get(mission_id)
            now_s = far.simulation.clock.now_s()
            over = MissionState(mission.state).ended or mission.recovery_step == RecoveryStep.STUCK
            if over or now_s > self._begun_s + LIMIT_S or far.error is not None:
                break
            self._operate(service, mission, now_s)
            time.sleep(LOOK_S)
        if far.error is not None:
            raise RuntimeError(f"{case}: the world broke") from far.error
        took_s = now_s - self._begun_s
        self._wait(far, 40.0)  # for doors that close by themselves
        return self._outcome(service, mission, far.simulation, took_s)

    def _operate(self, service: Service, mission: MissionRow, now_s: float) -> None:
        """Declare a silent peripheral lost."""
        assert self._begun_s is not None
        is_due = now_s - self._begun_s > GIVES_UP_S + 60.0
        if self._case.fault is Fault.SILENT and not self._lost and is_due:
            self._lost = True
            name = self._case.peripheral
            service.lost_robots.declare_lost(mission.world, name, actor=OPERATOR, comment="")

    def _wait(self, far: FarWorld, seconds: float) -> None:
        end_s = far.simulation.clock.now_s() + seconds
        while far.simulation.clock.now_s() < end_s and far.error is None:
            time.sleep(LOOK_S)

    def _outcome(
        self, service: Service, mission: MissionRow, simulation: Simulation, took_s: float
    ) -> Outcome:
        case = self._case
        state = MissionState(mission.state)
        goal = SymbolicFact(predicate="in", args=(case.sample, case.place))
        true = holds(goal, self._world, simulation.truth())
        if state is MissionState.COMPLETED:
            how = "came true" if true else "wrong"
        elif state.ended:
            how = "ended" if mission.reason else "wrong"
        else:
            how = "asked" if mission.recovery_step == RecoveryStep.STUCK else "silent"
        reports = service.robots.peripherals(WORLD)
        plan = service.plans.get(mission.plan_id)
        mechanisms = simulation.peripherals.mechanisms
        return Outcome(
            how=how,
            took_s=took_s,
            reason=mission.reason,
            measures=[f"{one['measure'] or 'no'} {one['outcome']}" for one in mission.attempts],
            ways=[name for name in plan.body["robots"] if name in mechanisms],
            out_of_service=[one.view.name for one in reports if one.out_of_service is not None],
            left_open=[
                one.name
                for one in self._world.peripherals
                if not one.is_lift and one.name != case.peripheral and mechanisms[one.name].state != "closed"
            ],
        )
