"""Any engine with goals in an order."""

from dataclasses import replace

import pytest

from planner import (
    UNOBSERVED,
    Fact,
    Keeping,
    Observer,
    OrderingReason,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    faults_of,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.engines.ordered import OrderedEngine
from planner.engines.registry import engine_named
from planner.plan_nets.validation import broken_orders
from planner.problem.interface import PlanningEngine
from tests.planner.engines import test_oversubscription, test_staged
from tests.planner.engines.test_oversubscription import done

JOBS = test_oversubscription.BASE
STORE = test_staged.STORE
FIRST, SECOND, THIRD = test_staged.FIRST, test_staged.SECOND, test_staged.THIRD
REQUEST = PlanningRequest(effort_s=0.0)


class Unaware:
    """Plans without regard to the order; keeps what it was asked for."""

    name = "unaware"

    def __init__(self) -> None:
        self._engine = HierarchicalEngine(JOBS)
        self.asked: list[tuple[Fact, ...]] = []

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        self.asked.append(problem.goals)
        return self._engine.plan(replace(problem, after={}), request, observer)


def jobs(*spans: int, robots: int, after: dict[int, tuple[int, ...]]) -> PlanningProblem:
    """Jobs by their seconds, and which of them come after which."""
    stated = test_oversubscription.problem(list(spans), [None] * len(spans), deadline_s=None, robots=robots)
    return replace(stated, after={done(one): frozenset(map(done, earlier)) for one, earlier in after.items()})


def planned(stated: PlanningProblem, engine: PlanningEngine, request: PlanningRequest = REQUEST) -> PlanNet:
    result = engine.plan(stated, request)
    assert result.status is PlanningStatus.SOLVED, result.reason
    assert result.plan_net is not None
    assert broken_orders(result.plan_net, stated.after) == []
    return result.plan_net


def ends(plan_net: PlanNet) -> dict[str, float]:
    return {fact.args[0]: one.earliest_end_s for one in plan_net.actions for fact in one.intended_effects}


@pytest.mark.parametrize("engine", [engine_named("macta", JOBS), OrderedEngine(Unaware(), JOBS)])
def test_robots_of_their_own_wait_for_each_other_and_others_do_not(engine: PlanningEngine) -> None:
    net = planned(jobs(10, 10, 10, robots=3, after={0: (2,)}), engine)
    assert ends(net) == {"job_0": 20.0, "job_1": 10.0, "job_2": 10.0}
    (ordering,) = [one for one in net.orderings if one.reason is OrderingReason.ORDER]
    assert ordering.kept_by is Keeping.CLEARANCE
    assert faults_of(net, jobs(10, 10, 10, robots=3, after={}).facts, JOBS) == []


@pytest.mark.parametrize("engine", [engine_named("macta", JOBS), OrderedEngine(Unaware(), JOBS)])
@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0), (2, 0, 1)])
def test_one_robot_does_the_jobs_in_the_order_asked_for(
    engine: PlanningEngine, order: tuple[int, int, int]
) -> None:
    one, two, three = order
    net = planned(jobs(10, 10, 10, robots=1, after={three: (two,), two: (one,)}), engine)
    assert [ends(net)[f"job_{job}"] for job in order] == [10.0, 20.0, 30.0]


def test_where_no_order_of_the_plan_will_do_the_goals_are_planned_in_the_fewest_stages() -> None:
    unaware = Unaware()
    before, later = sorted(
        (0, 1), key=lambda job: ends(planned(jobs(5, 5, robots=1, after={}), unaware))[f"job_{job}"]
    )
    unaware.asked.clear()
    stated = jobs(5, 5, robots=1, after={before: (later,)})
    planned(stated, OrderedEngine(unaware, JOBS))
    assert unaware.asked == [stated.goals, (done(later),), stated.goals]


def test_the_scheduler_knows_of_the_order_and_puts_the_long_jobs_side_by_side() -> None:
    net = planned(
        jobs(30, 10, 20, 10, robots=2, after={3: (1,)}), engine_named("macta", JOBS), PlanningRequest()
    )
    assert net.makespan_s == pytest.approx(40.0)


def test_where_robots_end_may_be_in_an_order_too() -> None:
    stated = test_staged.problem(FIRST, SECOND, THIRD, after={SECOND: frozenset({FIRST})})
    net = planned(stated, engine_named("macta", STORE.base))
    starts = {action.agents[0]: action for action in net.actions}
    assert starts["store_1"].earliest_start_s >= starts["yard_2"].earliest_end_s
    assert starts["store_2"].earliest_start_s == 0.0


def test_an_order_beside_stages_binds_what_is_in_one_stage() -> None:
    stated = test_staged.problem(FIRST, SECOND, THIRD, stages={THIRD: 1}, after={SECOND: frozenset({FIRST})})
    net = planned(stated, engine_named("macta", STORE.base))
    starts = {action.agents[0]: action for action in net.actions}
    assert starts["store_1"].earliest_start_s >= starts["yard_2"].earliest_end_s
    assert starts["store_2"].earliest_start_s >= starts["store_1"].earliest_end_s


def test_a_proof_that_there_is_no_plan_stands() -> None:
    never = STORE.fact("near(yard_1, bay_1)")
    stated = test_staged.problem(never, FIRST, after={FIRST: frozenset({never})})
    assert test_staged.plan(stated).status is PlanningStatus.UNSOLVABLE


def test_an_order_that_contradicts_itself_has_no_plan_and_says_so() -> None:
    stated = jobs(5, 5, robots=1, after={0: (1,), 1: (0,)})
    found = OrderedEngine(Unaware(), JOBS).plan(stated, REQUEST)
    assert (found.status, found.plan_net) == (PlanningStatus.NOT_FOUND, None)
    assert found.reason.startswith("the order of the goals contradicts itself")


def test_orders_of_goals_that_there_are_not_change_nothing() -> None:
    unaware = Unaware()
    planned(jobs(5, robots=1, after={0: (7,), 8: (0,)}), OrderedEngine(unaware, JOBS))
    assert len(unaware.asked) == 1


def test_a_plan_net_without_the_ordering_breaks_the_order() -> None:
    net = planned(jobs(10, 5, robots=2, after={}), engine_named("macta", JOBS))
    assert broken_orders(net, {done(0): frozenset({done(1)})}) == [(done(0), done(1))]
    assert broken_orders(net, {done(0): frozenset({done(7)})}) == []
