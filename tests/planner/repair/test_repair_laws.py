"""Laws of repair, on random stores, moments and mishaps: valid always, and kept what is said to be kept."""

import random
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache

from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.planner.scheduled_progress import as_scheduled
from planner import PlanNet, PlanningProblem, PlanningRequest, load_knowledge_base
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.repair import MissionProgress, join, repair
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.exploring import first_fault
from tests.planner.repair.carrying import check_repair, moved, with_another
from tests.planner.store import inside

BASE = load_knowledge_base()
REQUEST = PlanningRequest(time_limit_s=3, effort_s=0, clock=time.process_time)
Case = tuple[PlanningProblem, MissionProgress]


@cache
def engine() -> HierarchicalEngine:
    made = HierarchicalEngine(BASE)
    made.warm_up()
    return made


def store_plan(choose: random.Random) -> tuple[PlanningProblem, PlanNet]:
    """A random store with one to three errands, and its plan."""
    store = Store(aisles=choose.randint(1, 2), yard_robots=choose.randint(1, 3), doors=4)
    bays = [f"bay_{aisle}_{n}" for aisle in range(store.aisles) for n in range(store.bays)]
    places = choose.sample([*bays, *(f"door_{n}" for n in range(store.doors))], 7)
    samples = {f"s{n}": places[n] for n in range(4)}
    goals = [inside(f"s{n}", places[4 + n]) for n in range(choose.randint(1, 3))]
    problem = store.problem(goals, samples)
    plan_net = engine().plan(problem, REQUEST).plan_net
    assert plan_net is not None
    return problem, plan_net


def lying(problem: PlanningProblem) -> Mapping[str, str]:
    """Samples that lie at a place."""
    positions = [fact.args for fact in sorted(problem.facts) if fact.predicate == "object_position"]
    return {sample: place for sample, _, place in positions if problem.objects[place] == "location"}


def free(problem: PlanningProblem) -> list[str]:
    return sorted(f.args[0] for f in problem.facts if f.predicate == "vacant" and "home" not in f.args[0])


def nothing(case: Case, choose: random.Random) -> Case:
    return case


def sample_moved(case: Case, choose: random.Random) -> Case:
    """Not one that a robot is about to grip."""
    problem, progress = case
    still = lying(problem)
    if not still:
        return case
    sample = choose.choice(sorted(still))
    facts = moved(problem.facts, sample, still[sample], choose.choice(free(problem)))
    return replace(problem, facts=facts), progress


def place_taken(case: Case, choose: random.Random) -> Case:
    problem, progress = case
    return with_another(problem, "stray", choose.choice(free(problem))), progress


def robot_lost(case: Case, choose: random.Random) -> Case:
    """It stops; what it had begun does not end."""
    problem, progress = case
    robots = [name for name, kind in problem.objects.items() if kind == "robot" and name.startswith("yard")]
    return problem, replace(progress, lost=frozenset({choose.choice(robots)}))


def goal_added(case: Case, choose: random.Random) -> Case:
    problem, progress = case
    return replace(problem, goals=(*problem.goals, inside("s3", choose.choice(free(problem))))), progress


MISHAPS: list[Callable[[Case, random.Random], Case]] = [
    nothing,
    sample_moved,
    place_taken,
    robot_lost,
    goal_added,
]


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32), mishap=st.sampled_from(MISHAPS), share=st.floats(0, 1))
def test_a_repaired_plan_net_is_valid_and_kept_is_what_is_said_to_be_kept(
    seed: int, mishap: Callable[[Case, random.Random], Case], share: float
) -> None:
    choose = random.Random(seed)
    problem, plan_net = store_plan(choose)
    facts, progress = as_scheduled(plan_net, problem.facts, round(share * plan_net.makespan_s, 1))
    present, progress = mishap((replace(problem, facts=facts), progress), choose)
    made = repair(engine(), BASE, plan_net, present, progress, REQUEST)
    if made.plan_net is None:
        assert made.result.reason
        assert mishap is not nothing
        return
    left = [action for action in plan_net.actions if action.id not in progress.done]
    repaired = check_repair(made, left, present, BASE)
    assert progress.lost.isdisjoint(repaired.robots)
    under_way = {a for a in progress.under_way if progress.lost.isdisjoint(plan_net.action(a).agents)}
    assert made.difference is not None
    if mishap in (nothing, goal_added):
        assert under_way <= made.difference.kept.keys()
        assert sum(action.under_way for action in repaired.actions) == len(under_way)


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 2**32), share=st.floats(0, 1))
def test_who_joins_disturbs_nobody(seed: int, share: float) -> None:
    choose = random.Random(seed)
    problem, plan_net = store_plan(choose)
    facts, progress = as_scheduled(plan_net, problem.facts, round(share * plan_net.makespan_s, 1))
    present = replace(problem, facts=facts)
    goals = [inside("s3", choose.choice(free(present)))]
    made = join(engine(), BASE, plan_net, present, progress, goals, REQUEST)
    if made.plan_net is None:
        assert made.result.reason
        return
    left = [action for action in plan_net.actions if action.id not in progress.done]
    joined = check_repair(made, left, replace(present, goals=(*problem.goals, *goals)), BASE)
    assert made.difference is not None
    assert set(made.difference.kept) == {action.id for action in left}
    for action in left:
        latest_s = max(0.0, action.latest_start_s - progress.elapsed_s)
        assert joined.action(made.difference.kept[action.id]).earliest_start_s <= latest_s + 0.05


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**32), share=st.floats(0, 1))
def test_a_repaired_plan_net_is_safe_in_every_order_of_events(seed: int, share: float) -> None:
    choose = random.Random(seed)
    problem, plan_net = store_plan(choose)
    facts, progress = as_scheduled(plan_net, problem.facts, round(share * plan_net.makespan_s, 1))
    present, progress = place_taken((replace(problem, facts=facts), progress), choose)
    made = repair(engine(), BASE, plan_net, present, progress, REQUEST)
    if made.plan_net is not None and len(made.plan_net.actions) <= 20:
        assert first_fault(made.plan_net, made.problem.facts, made.problem.objects, BASE) is None
