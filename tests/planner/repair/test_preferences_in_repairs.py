"""Repairs keep the preferences that the plan has kept, as long as that pays."""

from dataclasses import replace

import pytest

from planner import Fact, PlanNet, PlanningProblem, PlanningRequest, Preference, load_knowledge_base
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.engines.registry import engine_named
from planner.repair import NOT_BEGUN, MissionProgress, Repair, repair
from tests.planner.store import inside, store_problem

BASE = load_knowledge_base()
QUICK = PlanningRequest(effort_s=0.0)
STORED = store_problem([inside("sample_1", "bay_7")])


@pytest.fixture(scope="module", autouse=True)
def warm() -> None:
    """What is compiled first takes none of the time limits."""
    HierarchicalEngine(BASE).warm_up()


def without(robot: str, cost_s: float) -> Preference:
    can = frozenset(fact for fact in STORED.facts if fact.predicate == "can" and fact.args[0] == robot)
    return Preference(words=f"without {robot}", cost_s=cost_s, withheld=can)


def planned(stated: PlanningProblem) -> PlanNet:
    plan_net = engine_named("macta", BASE).plan(stated, QUICK).plan_net
    assert plan_net is not None
    return plan_net


def yard_robot(plan_net: PlanNet) -> str:
    (robot,) = [robot for robot in plan_net.robots if robot.startswith("yard")]
    return robot


def repaired(plan_net: PlanNet, problem: PlanningProblem, progress: MissionProgress = NOT_BEGUN) -> Repair:
    found = repair(engine_named("macta", BASE), BASE, plan_net, problem, progress, QUICK)
    assert found.plan_net is not None
    assert found.result.preferences is not None
    kept = [one.is_kept_by(found.plan_net) for one in problem.preferences]
    assert [one.is_kept for one in found.result.preferences.outcomes] == kept
    return found


BUSY = "yard_1"
OTHER = "yard_2"


def test_what_the_plan_has_kept_is_kept_though_a_shorter_repair_breaks_it() -> None:
    assert yard_robot(planned(STORED)) == BUSY
    stated = replace(STORED, preferences=(without(BUSY, 100.0),))
    plan_net = planned(stated)
    assert yard_robot(plan_net) == OTHER
    moved = frozenset(f for f in STORED.facts if f.predicate == "object_position" and f.args[0] == "sample_1")
    elsewhere = replace(
        stated,
        facts=stated.facts - moved - {Fact("vacant", ("door_2",))}
        | {inside("sample_1", "door_2"), Fact("vacant", ("door_1",))},
    )
    again = repaired(plan_net, elsewhere)
    assert again.plan_net is not None
    assert yard_robot(again.plan_net) == OTHER


def test_a_preference_that_no_repair_can_keep_is_broken_and_told() -> None:
    stated = replace(STORED, preferences=(without(BUSY, 100.0),))
    plan_net = planned(stated)
    lost = repaired(plan_net, stated, MissionProgress(lost=frozenset({OTHER})))
    assert lost.plan_net is not None
    assert yard_robot(lost.plan_net) == BUSY
    assert lost.result.preferences is not None
    (broken,) = lost.result.preferences.outcomes
    assert broken.reason == "no better repair that keeps it was found"
    assert lost.result.preferences.bound_s == 0.0, "of repairs nothing is proven"


def test_a_preference_that_the_plan_has_broken_does_not_change_its_repair() -> None:
    stated = replace(STORED, preferences=(without(BUSY, 1.0),))
    plan_net = planned(stated)
    assert yard_robot(plan_net) == BUSY
    again = repaired(plan_net, stated)
    assert again.plan_net is not None
    assert [a.tag for a in again.plan_net.actions] == [a.tag for a in plan_net.actions]
    assert yard_robot(again.plan_net) == BUSY


def test_breaking_one_that_has_become_dear_to_keep_pays() -> None:
    """The robot that is rather not used has become the only quick one."""
    stated = replace(STORED, preferences=(without(BUSY, 10.0),))
    plan_net = planned(stated)
    assert yard_robot(plan_net) == OTHER
    slow = replace(stated, functions={**stated.functions, ("speed_m_s", (OTHER,)): 0.05})
    again = repaired(plan_net, slow)
    assert again.plan_net is not None
    assert yard_robot(again.plan_net) == BUSY
