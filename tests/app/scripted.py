"""A planning worker that always has the same plan."""

from concurrent.futures import Future

from app.planning.pool.pool import PlanningWorker
from planner import PlanNet, PlanningProblem, PlanningRequest, PlanningResult, PlanningStatus


class ScriptedWorker(PlanningWorker):
    """Answers with a plan-net made by hand, without a process."""

    def __init__(self, plan_net: PlanNet) -> None:
        self._plan_net = plan_net

    def warm_up(self) -> "Future[bool]":
        ready: Future[bool] = Future()
        ready.set_result(True)
        return ready

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, watch: object = None
    ) -> PlanningResult:
        return PlanningResult(
            status=PlanningStatus.SOLVED, engine="scripted", planning_s=0.0, plan_net=self._plan_net
        )

    def close(self) -> None: ...
