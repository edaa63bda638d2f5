"""Goals that join what is running: nothing committed is done otherwise or delayed."""

from dataclasses import replace

import pytest

from benchmarks.planner.scheduled_progress import as_scheduled
from planner import Fact, KnowledgeBase, PlanNet, PlanningProblem, PlanningRequest, PlanningStatus
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.repair import NOT_BEGUN, Course, MissionProgress, Repair, join
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.repair.carrying import GOALS, check_repair, moved, problem, with_another
from tests.planner.store import inside

REQUEST = PlanningRequest(time_limit_s=30, effort_s=0)


def checked(
    engine: HierarchicalEngine,
    knowledge_base: KnowledgeBase,
    plan_net: PlanNet,
    present: PlanningProblem,
    goals: tuple[Fact, ...],
    progress: MissionProgress = NOT_BEGUN,
) -> Repair:
    """What joined, held to account: all that was left is kept and starts no later than it may."""
    made = join(engine, knowledge_base, plan_net, present, progress, goals, REQUEST)
    left = [action for action in plan_net.actions if action.id not in progress.done]
    every = replace(present, goals=(*plan_net.goals, *goals))
    joined = check_repair(made, left, every, knowledge_base)
    assert made.difference is not None
    assert made.course is Course.JOINED
    for action in left:
        latest_s = max(0.0, action.latest_start_s - progress.elapsed_s)
        assert joined.action(made.difference.kept[action.id]).earliest_start_s <= latest_s + 0.02
    return made


@pytest.mark.parametrize("elapsed_s", [0.0, 7.0, 12.0, 30.0, 50.0])
def test_new_goals_leave_what_is_committed_as_it_is(
    planner: HierarchicalEngine, knowledge_base: KnowledgeBase, plan_net: PlanNet, elapsed_s: float
) -> None:
    start = with_another(problem(), "s2", "bay_0_5")
    facts, progress = as_scheduled(plan_net, start.facts, elapsed_s)
    present = replace(start, facts=facts)
    made = checked(planner, knowledge_base, plan_net, present, (inside("s2", "door_0"),), progress)
    assert made.difference is not None
    assert not made.difference.dropped


def test_a_robot_that_is_free_begins_at_once(
    knowledge_base: KnowledgeBase, planner: HierarchicalEngine
) -> None:
    store = Store(yard_robots=3, aisles=3)
    goals = GOALS
    samples = {"s0": "door_0", "s1": "door_1", "s2": "bay_2_3"}
    present = store.problem(goals, samples)
    plan_net = planner.plan(present, REQUEST).plan_net
    assert plan_net is not None
    made = checked(planner, knowledge_base, plan_net, present, (inside("s2", "bay_2_0"),))
    assert made.plan_net is not None
    assert made.difference is not None
    new = [made.plan_net.action(name) for name in made.difference.added]
    assert {action.agents for action in new} == {("store_2_0",)}
    assert min(action.earliest_start_s for action in new) == 0.0
    assert made.plan_net.makespan_s == plan_net.makespan_s


def test_who_has_the_time_is_preferred_to_who_is_nearer(
    knowledge_base: KnowledgeBase, planner: HierarchicalEngine
) -> None:
    """One store robot is busy in the aisle, its colleague there has nothing to do."""
    store = Store(aisles=1, store_robots=2, bays=8)
    samples = {"s0": "bay_0_0", "s1": "bay_0_1", "s2": "bay_0_2"}
    busy = store.problem([inside("s0", "bay_0_6"), inside("s1", "bay_0_7")], samples)
    one_alone = replace(
        busy, facts=frozenset(f for f in busy.facts if f != Fact("can", ("store_0_1", "DOCK")))
    )
    plan_net = planner.plan(one_alone, REQUEST).plan_net
    assert plan_net is not None
    assert plan_net.robots == ("store_0_0",)
    made = checked(planner, knowledge_base, plan_net, busy, (inside("s2", "bay_0_5"),))
    assert made.plan_net is not None
    assert made.plan_net.makespan_s == plan_net.makespan_s
    assert "store_0_1" in made.plan_net.robots


def test_goals_join_only_what_still_works(
    planner: HierarchicalEngine, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    present = replace(problem(), facts=moved(problem().facts, "s1", "door_1", "bay_1_5"))
    made = join(planner, knowledge_base, plan_net, present, NOT_BEGUN, GOALS[:1], REQUEST)
    assert made.plan_net is None
    assert made.result.status is PlanningStatus.NOT_FOUND
    assert made.result.reason.startswith(
        "what is committed needs repair first: DOCK(s1, yard_1, near, door_1)"
    )
    lost = MissionProgress(lost=frozenset({"yard_0"}))
    made = join(planner, knowledge_base, plan_net, problem(), lost, GOALS[:1], REQUEST)
    assert (
        made.result.reason == "what is committed needs repair first: a robot is lost, or one of its places is"
    )


def test_goals_that_cannot_be_reached_say_why(
    planner: HierarchicalEngine, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    here = with_another(problem(), "s2", "bay_0_5")
    kept_in = replace(here, facts=frozenset(f for f in here.facts if f.args != ("store_0_0", "bay_0_5")))
    made = join(planner, knowledge_base, plan_net, kept_in, NOT_BEGUN, (inside("s2", "bay_0_1"),), REQUEST)
    assert made.plan_net is None
    assert "bay_0_5" in made.result.reason
