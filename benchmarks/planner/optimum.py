"""The shortest makespan of a sample-store instance, proven: a job shop for CP-SAT that knows nothing of our engine.

Decided together: which robot carries which leg, the order of each robot's legs, when a place's area is clear and the
place vacant, and where a robot stops on its way to leave a place to another (with a sample in its jaws only if another
robot needs the place that it leaves, else table 3 does not allow the action).
Left out: setting a sample down anywhere but at an interchange and its goal, and more than one stop on a way.
"""

from dataclasses import dataclass

from ortools.sat.python import cp_model

from benchmarks.planner.jobs import Jobs
from benchmarks.planner.legs import ELSEWHERE, MILLISECONDS, Shop
from planner import GroundAction, KnowledgeBase, PlanningProblem

WORKERS = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class Optimum:
    """The best schedule found, its makespan, and the proven lower bound; equal if it is the optimum."""

    makespan_s: float | None
    bound_s: float
    timed: tuple[tuple[float, float, GroundAction], ...]

    @property
    def is_proven(self) -> bool:
        return self.makespan_s is not None and self.makespan_s - self.bound_s < 0.001


def optimum(
    knowledge_base: KnowledgeBase, problem: PlanningProblem, *, time_limit_s: float = 60.0
) -> Optimum:
    """Solve the instance: first with stops that block no robot, for a bound and a hint, then as it is.

    :raises NotModelled: if it is not of the sample-store kind.
    """
    shop = Shop(knowledge_base, problem)
    shared = [area for area, robots in shop.robots.items() if len(robots) > 1]
    relaxed = Jobs(shop, {area: [ELSEWHERE] for area in shared})
    solver = _solved(relaxed, time_limit_s / 2)
    bound_s = solver.best_objective_bound / MILLISECONDS
    whole = Jobs(shop, {area: shop.places(area) for area in shared})
    whole.begin_with(relaxed, solver)
    solver = _solved(whole, time_limit_s / 2)
    if not solver.response_proto.solution:
        return Optimum(makespan_s=None, bound_s=bound_s, timed=())
    return Optimum(
        makespan_s=solver.objective_value / MILLISECONDS,
        bound_s=max(bound_s, solver.best_objective_bound / MILLISECONDS),
        timed=tuple(sorted(whole.timed(solver), key=lambda step: step[:2])),
    )


def _solved(jobs: Jobs, time_limit_s: float) -> cp_model.CpSolver:
    solver = cp_model.CpSolver()
    solver.parameters.max_time_in_seconds = time_limit_s
    solver.parameters.num_workers = WORKERS
    solver.parameters.random_seed = 0
    solver.solve(jobs.model)
    return solver
