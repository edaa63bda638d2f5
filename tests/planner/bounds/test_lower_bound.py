"""No plan-net is quicker than the bound, and the bound is no trifle."""

from dataclasses import replace
from itertools import pairwise, product

import pytest

from benchmarks.planner.instances import FAMILIES
from benchmarks.planner.optimum import optimum
from planner import Fact, KnowledgeBase, PlanningProblem, PlanningRequest, read_knowledge_base
from planner.bounds import lower_bound_s
from planner.bounds.network import Network
from planner.bounds.world import World
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.knowledge import scale_term
from planner.plan_nets.assembly import assemble
from planner.plan_nets.extraction import extract
from planner.problem.robot_classes import AgentClasses
from tests.planner.engines.hierarchical.survey import SURVEY, survey
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.large_store import LargeStore
from tests.planner.store import inside, store_problem


@pytest.mark.parametrize("family", ["store", "mixed", "retrieve"])
def test_the_bound_of_one_sample_is_the_optimum(knowledge_base: KnowledgeBase, family: str) -> None:
    problem = FAMILIES[family](1, 0).problem(knowledge_base)
    best = optimum(knowledge_base, problem, time_limit_s=240.0)
    assert best.is_proven
    assert lower_bound_s(knowledge_base, problem) == pytest.approx(best.makespan_s)


@pytest.mark.parametrize(("family", "share"), [("store", 0.8), ("retrieve", 0.9), ("mixed", 0.7)])
def test_the_bound_is_close_below_the_optimum(
    knowledge_base: KnowledgeBase, family: str, share: float
) -> None:
    problem = FAMILIES[family](3, 1).problem(knowledge_base)
    best = optimum(knowledge_base, problem, time_limit_s=240.0)
    assert best.is_proven
    assert best.makespan_s is not None
    assert share * best.makespan_s <= lower_bound_s(knowledge_base, problem) <= best.makespan_s


@pytest.mark.parametrize("samples", [1, 5, 12])
def test_a_plan_without_search_is_never_below_the_bound(knowledge_base: KnowledgeBase, samples: int) -> None:
    store = LargeStore(aisles=3, samples=samples)
    problem = store.problem()
    order = extract(store.sequence(problem, knowledge_base), problem.facts, problem.goals)
    plan_net = assemble(order, problem.goals, knowledge_base, {})
    assert 0 < lower_bound_s(knowledge_base, problem) <= plan_net.makespan_s


def test_learned_durations_count(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    slower = {**problem.functions, scale_term("RELEASE2", 1): 2.0}
    bound_s = lower_bound_s(knowledge_base, problem)
    # Two legs, two releases of 5 s, both on the critical path.
    assert lower_bound_s(knowledge_base, replace(problem, functions=slower)) == pytest.approx(bound_s + 10.0)


def test_a_bound_does_not_depend_on_what_was_bounded_before(knowledge_base: KnowledgeBase) -> None:
    """What a problem shares with the one before is not made again: problems that differ in one part, in every order."""
    problem = store_problem([inside("sample_1", "bay_7")])
    moved = replace(problem, goals=(inside("sample_4", "door_2"), inside("sample_1", "bay_9")))
    slower = {name: 2 * value for name, value in problem.functions.items()}
    stands = next(f for f in problem.facts if f.predicate == "robot_position" and f.args[0] == "yard_1")
    elsewhere = problem.facts - {stands} | {Fact("robot_position", ("yard_1", "near", "door_2"))}
    one_less = frozenset(f for f in problem.facts if f.predicate != "can" or f.args[0] != "yard_1")
    lies = next(f for f in problem.facts if f.predicate == "object_position" and f.args[0] == "sample_1")
    put = problem.facts - {lies} | {inside("sample_1", "bay_5")}
    every = [
        problem,
        moved,
        replace(problem, functions=slower),
        replace(problem, facts=elsewhere),
        replace(problem, facts=one_less),
        replace(problem, facts=put),
        replace(problem, recruits={problem.goals[0]: frozenset({"yard_2", "store_1"})}),
    ]
    found: dict[int, dict[int, float]] = {before: {} for before in range(len(every))}
    for before, after in product(range(len(every)), repeat=2):
        lower_bound_s(knowledge_base, every[before])
        found[before][after] = lower_bound_s(knowledge_base, every[after])
    assert all(bounds == found[0] for bounds in found.values())
    assert len(set(found[0].values())) >= 4


def test_a_network_is_taken_over_by_a_problem_in_which_the_same_is_within_reach(
    knowledge_base: KnowledgeBase,
) -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    lies = next(f for f in problem.facts if f.predicate == "object_position" and f.args[0] == "sample_1")
    put = replace(problem, facts=problem.facts - {lies} | {inside("sample_1", "bay_5")})
    cannot = Fact("can", ("yard_1", "DOCK"))
    assert cannot in problem.facts
    one_less = replace(problem, facts=problem.facts - {cannot})

    def network_of(one: PlanningProblem, like: Network | None = None) -> Network:
        return Network(World(knowledge_base, one, AgentClasses(knowledge_base, one)), like=like)

    first = network_of(problem)
    assert network_of(put, first).thing_edges is first.thing_edges
    assert network_of(one_less, first).thing_edges is not first.thing_edges


def test_a_goal_that_holds_needs_nothing(knowledge_base: KnowledgeBase) -> None:
    held = next(fact for fact in store_problem([]).facts if fact.predicate == "object_position")
    assert lower_bound_s(knowledge_base, store_problem([held])) == 0.0


def test_a_robots_own_goal_needs_its_way_there(knowledge_base: KnowledgeBase) -> None:
    store = Store()
    goal = Fact("robot_position", ("yard_0", "near", "door_0"))
    problem = store.problem([goal], {})
    drive = {"robots": "yard_0", "rel1": "near", "ref1": "home_yard_0", "rel2": "near", "ref2": "door_0"}
    action = knowledge_base.ground(
        "NAVIGATE", {**drive, "area": "yard"}, problem.functions, objects=problem.objects
    )
    assert lower_bound_s(knowledge_base, problem) == pytest.approx(action.duration_s)


def test_work_adds_up_over_what_few_robots_must_do(knowledge_base: KnowledgeBase) -> None:
    """One robot of the yard, four samples: the bound grows by more than a leg's handling with each."""
    store = Store(aisles=2, yard_robots=1, doors=4)
    samples = {f"sample_{n}": f"door_{n}" for n in range(4)}
    goals = [inside(f"sample_{n}", f"bay_{n % 2}_{n}") for n in range(4)]
    bounds = [lower_bound_s(knowledge_base, store.problem(goals[:n], samples)) for n in range(1, 5)]
    assert all(more - less > 7.5 for less, more in pairwise(bounds))


def test_other_knowledge_bases_are_bounded_too() -> None:
    base = read_knowledge_base(SURVEY, "survey.yaml")
    goal = Fact("stands", ("box", "fork"))
    problem = survey([goal], rovers={"ann": "base", "bob": "fork"}, strong=["ann", "bob"])
    # Bob drives 10 m at 2 m/s to the box, then both carry it 10 m at 1 m/s.
    result = HierarchicalEngine(base).plan(problem, PlanningRequest(effort_s=0.1))
    assert result.plan_net is not None
    assert 10.0 <= lower_bound_s(base, problem) <= result.plan_net.makespan_s == 15.0
