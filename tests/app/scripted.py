"""A planning worker without processes."""

from collections.abc import Callable
from concurrent.futures import Future

from app.background_compilation import Stage
from app.planning.pool.pool import PlanningWorker
from app.planning.pool.process import Watch
from app.planning.pool.status import PoolStatus
from app.planning.pool.waiting_line import Job
from app.planning.pool.work import Answer, Work, WorkResult
from planner import (
    UNOBSERVED,
    Observer,
    PlanNet,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)


class InProcessWorker(PlanningWorker):
    """Does the work with an engine of the test, in the thread that asks for it."""

    def __init__(self, engine: PlanningEngine) -> None:
        self._engine = engine

    def warm_up(self) -> "Future[bool]":
        ready: Future[bool] = Future()
        ready.set_result(True)
        return ready

    def do(
        self,
        work: Work[Answer],
        time_limit_s: float,
        watch: Watch | None = None,
        job: Job | None = None,
        *,
        renew: Callable[[], Work[Answer]] | None = None,
        conclude: Callable[[WorkResult[Answer]], None] = lambda _: None,
    ) -> WorkResult[Answer]:
        """The work never waits, so it is never renewed."""
        result = work(self._engine, watch or UNOBSERVED)
        conclude(result)
        return result

    def status(self) -> PoolStatus:
        return PoolStatus(compilation=Stage.COMPILED)

    def close(self) -> None: ...


class ScriptedEngine:
    """Always has the same plan."""

    name = "scripted"

    def __init__(self, plan_net: PlanNet) -> None:
        self._plan_net = plan_net

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        return PlanningResult(
            status=PlanningStatus.SOLVED, engine=self.name, planning_s=0.0, plan_net=self._plan_net
        )


class ScriptedWorker(InProcessWorker):
    """Answers with a plan-net made by hand."""

    def __init__(self, plan_net: PlanNet) -> None:
        super().__init__(ScriptedEngine(plan_net))
