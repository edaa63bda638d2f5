"""What is under way goes on at once, or there is no repaired plan-net."""

import pytest

from planner import Fact, PlanNet, PlanningProblem, PlanningRequest
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.repair import MissionProgress, Remaining, join, repair
from tests.planner.plan_nets.test_intended_effects import BASE, READY

LAMPS = {"lamp_1": "lamp", "lamp_2": "lamp"}
LIT = tuple(Fact("lit", (lamp,)) for lamp in LAMPS)
PROBLEM = PlanningProblem(objects={"fred": "robot", **LAMPS}, facts=frozenset({READY}), goals=LIT)
REQUEST = PlanningRequest(time_limit_s=10, effort_s=0)
BOTH = MissionProgress(under_way={"a1": 2.0, "a2": 3.0}, elapsed_s=1.0)
"""One robot reports two actions at a time, of which it can only carry out one after the other."""


@pytest.fixture(scope="module")
def engine() -> HierarchicalEngine:
    return HierarchicalEngine(BASE)


@pytest.fixture(scope="module")
def lighting(engine: HierarchicalEngine) -> PlanNet:
    found = engine.plan(PROBLEM, REQUEST).plan_net
    assert found is not None
    assert [action.tag for action in found.actions] == ["LIGHT", "LIGHT"]
    return found


def test_an_action_under_way_that_would_have_to_wait_makes_a_plan_net_unacceptable(lighting: PlanNet) -> None:
    remaining = Remaining(lighting, PROBLEM, BOTH, BASE)
    assert remaining.finished(remaining.under_way, LIT) == "a2 LIGHT is under way, yet would wait"


def test_one_action_under_way_goes_on_at_once(lighting: PlanNet) -> None:
    remaining = Remaining(lighting, PROBLEM, MissionProgress(under_way={"a1": 2.0}, elapsed_s=1.0), BASE)
    plan_net = remaining.finished((*remaining.under_way, *remaining.rest), LIT)
    assert isinstance(plan_net, PlanNet)
    assert [(action.under_way, action.earliest_start_s) for action in plan_net.actions] == [
        (True, 0.0),
        (False, 2.0),
    ]


def test_neither_repair_nor_new_goals_let_what_is_under_way_wait(
    engine: HierarchicalEngine, lighting: PlanNet
) -> None:
    repaired = repair(engine, BASE, lighting, PROBLEM, BOTH, REQUEST)
    assert repaired.plan_net is None
    joined = join(engine, BASE, lighting, PROBLEM, BOTH, [], REQUEST)
    assert joined.plan_net is None
    assert "a2 LIGHT is under way, yet would wait" in joined.result.reason
