"""Several problems within one time limit."""

from planner import (
    UNOBSERVED,
    Objective,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.problem.solving import TimeLimitedEngine
from tests.planner.stepped_clock import SteppedClock

PROBLEM = PlanningProblem(objects={}, facts=frozenset(), goals=())


class Noting:
    """Finds nothing and notes what it was asked for."""

    name = "noting"

    def __init__(self) -> None:
        self.requests: list[PlanningRequest] = []

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        self.requests.append(request)
        return PlanningResult(status=PlanningStatus.NOT_FOUND, engine=self.name, planning_s=0.0)


def test_the_time_limit_is_for_all_problems_together() -> None:
    engine = Noting()
    solving = TimeLimitedEngine(
        engine, PlanningRequest(time_limit_s=60, objective=Objective.ENERGY), UNOBSERVED
    )
    assert solving.plan_if_time(PROBLEM) is not None
    assert solving.plan_if_time(PROBLEM, Objective.ROBOTS) is not None
    one, other = engine.requests
    assert 60 >= one.time_limit_s > other.time_limit_s > 0
    assert (one.objective, other.objective) == (Objective.ENERGY, Objective.ROBOTS)


def test_a_problem_is_not_begun_in_less_time_than_one_took_before() -> None:
    clock = SteppedClock()

    class Slow(Noting):
        def plan(
            self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
        ) -> PlanningResult:
            clock.now_s += 20.0
            return super().plan(problem, request, observer)

    engine = Slow()
    solving = TimeLimitedEngine(engine, PlanningRequest(time_limit_s=50.0, clock=clock), UNOBSERVED)
    answers = [solving.plan_if_time(PROBLEM) for _ in range(3)]
    assert [answer is None for answer in answers] == [False, False, True]
    assert [request.time_limit_s for request in engine.requests] == [50.0, 30.0]


def test_without_time_no_problem_is_begun() -> None:
    engine = Noting()
    request = PlanningRequest(time_limit_s=0.0, clock=SteppedClock())
    assert TimeLimitedEngine(engine, request, UNOBSERVED).plan_if_time(PROBLEM) is None
    assert engine.requests == []


def test_who_wants_no_more_gets_no_more() -> None:
    class Done(Observer):
        def should_stop(self) -> bool:
            return True

    assert TimeLimitedEngine(Noting(), PlanningRequest(), Done()).plan_if_time(PROBLEM) is None
