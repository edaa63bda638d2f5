"""What planning processes are asked for, without a process."""

import pytest

from app.planning.pool.work import RepairWork
from planner import UNOBSERVED, PlanningRequest, load_knowledge_base
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.repair import Pin, pinned, unkept_pins
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.store import inside

BASE = load_knowledge_base()
ENGINE = HierarchicalEngine(BASE)
GOALS = (inside("s0", "bay_0_0"), inside("s1", "bay_0_3"))
WAYS = frozenset({"interchange_0_0", "interchange_0_1"})
EVERYBODY = frozenset({"yard_0", "yard_1", "store_0_0"})


@pytest.mark.parametrize(
    ("hopeless", "unkept"),
    [
        (Pin(goal=GOALS[0], avoided=WAYS), {GOALS[0]}),
        (Pin(goal=GOALS[0], barred=EVERYBODY), {GOALS[0]}),
        (Pin(goal=GOALS[0]), set()),
    ],
)
def test_a_repair_drops_what_is_pinned_only_for_goals_that_it_leaves_no_way_to(
    hopeless: Pin, unkept: set[object]
) -> None:
    start = Store(aisles=1, interchanges=2, yard_robots=2)
    problem = start.problem(GOALS, {"s0": "door_0", "s1": "door_1"})
    plan = ENGINE.plan(problem, PlanningRequest()).plan_net
    assert plan is not None
    (mine,) = {
        action.agents[0]
        for action in plan.actions
        if action.arguments.get("object") == "s1" and action.agents[0].startswith("yard")
    }
    problem = pinned(problem, [hopeless, Pin(goal=GOALS[1], barred=frozenset({mine}))], BASE)
    work = RepairWork(knowledge_base=BASE, plan_net=plan, problem=problem, request=PlanningRequest())
    result = work(ENGINE, UNOBSERVED)
    assert result.answer is not None, result.reason
    repaired = result.answer[0].result.plan_net
    assert repaired is not None
    assert unkept_pins(repaired, problem, BASE).keys() == unkept
    assert unkept_pins(plan, problem, BASE).keys() == {*unkept, GOALS[1]}
