"""The planner's benchmark itself: its instances, its own check of plan-nets, its exact model."""

from dataclasses import replace

import pytest

from benchmarks.planner.check import fault_in_time, fault_of
from benchmarks.planner.instances import FAMILIES, Instance
from benchmarks.planner.legs import NotModelled
from benchmarks.planner.optimum import optimum
from planner import KnowledgeBase, PlanNet, PlanningProblem, PlanningRequest, load_knowledge_base
from planner.engines.fast_downward import FastDownwardEngine
from planner.plan_nets.assembly import assemble
from planner.plan_nets.extraction import extract


@pytest.fixture(scope="module")
def base() -> KnowledgeBase:
    return load_knowledge_base()


@pytest.fixture(scope="module")
def solved(base: KnowledgeBase) -> tuple[PlanningProblem, PlanNet]:
    problem = FAMILIES["mixed"](2, 0).problem(base)
    plan_net = FastDownwardEngine(base).plan(problem, PlanningRequest(time_limit_s=60, effort_s=0.0)).plan_net
    assert plan_net is not None
    return problem, plan_net


def goals_of_four(family: str) -> int:
    """The goals of an instance with four samples: `rearranged` moves half of them."""
    return 2 if family == "rearranged" else 4


@pytest.mark.parametrize("family", FAMILIES)
def test_instances_depend_on_family_size_and_seed_alone(family: str, base: KnowledgeBase) -> None:
    make = FAMILIES[family]
    one, same, other = make(4, 1), make(4, 1), make(4, 2)
    assert one.problem(base) == same.problem(base)
    assert one.problem(base) != other.problem(base)
    assert len(one.targets) == goals_of_four(family)


@pytest.mark.parametrize("family", FAMILIES)
def test_no_goal_holds_at_the_start_and_no_two_samples_want_one_place(
    family: str, base: KnowledgeBase
) -> None:
    instance: Instance = FAMILIES[family](4, 0)
    problem = instance.problem(base)
    assert not problem.facts.intersection(problem.goals)
    assert len(set(instance.targets.values())) == goals_of_four(family)


def test_robots_grow_with_the_samples() -> None:
    assert [FAMILIES["store"](samples, 0).robots for samples in (1, 16, 64, 256)] == [4, 4, 16, 64]


def test_the_check_accepts_a_right_plan_net(
    solved: tuple[PlanningProblem, PlanNet], base: KnowledgeBase
) -> None:
    problem, plan_net = solved
    assert fault_of(plan_net, problem, base) is None


def test_the_check_finds_every_ordering_that_is_missing_between_robots(
    solved: tuple[PlanningProblem, PlanNet], base: KnowledgeBase
) -> None:
    problem, plan_net = solved
    agents = {action.id: action.agents for action in plan_net.actions}
    between = [o for o in plan_net.orderings if not set(agents[o.before]) & set(agents[o.after])]
    assert between
    loose = replace(plan_net, orderings=tuple(o for o in plan_net.orderings if o not in between))
    assert fault_of(loose, problem, base) is not None


def test_the_check_knows_the_actions_by_the_knowledge_base(
    solved: tuple[PlanningProblem, PlanNet], base: KnowledgeBase
) -> None:
    problem, plan_net = solved
    quick = replace(plan_net.actions[0], duration_s=0.5)
    changed = replace(plan_net, actions=(quick, *plan_net.actions[1:]))
    assert "duration_s" in (fault_of(changed, problem, base) or "")


@pytest.mark.parametrize(("family", "samples"), [("store", 2), ("mixed", 2), ("retrieve", 1), ("paper", 2)])
def test_the_optimum_can_be_carried_out_and_is_a_plan_net(
    family: str, samples: int, base: KnowledgeBase
) -> None:
    problem = FAMILIES[family](samples, 0).problem(base)
    best = optimum(base, problem, time_limit_s=120)
    assert best.is_proven
    assert fault_in_time(best.timed, problem) is None
    order = extract([action for _, _, action in best.timed], problem.facts, problem.goals)
    plan_net = assemble(order, problem.goals, base, {})
    assert plan_net.makespan_s == pytest.approx(best.makespan_s, abs=0.01)
    assert fault_of(plan_net, problem, base) is None


def test_no_plan_is_shorter_than_the_optimum(
    solved: tuple[PlanningProblem, PlanNet], base: KnowledgeBase
) -> None:
    problem, plan_net = solved
    assert plan_net.makespan_s >= optimum(base, problem, time_limit_s=120).bound_s - 0.01


def test_a_bystander_is_beyond_the_exact_model(base: KnowledgeBase) -> None:
    with pytest.raises(NotModelled, match="in the way"):
        optimum(base, FAMILIES["blocked"](1, 0).problem(base))
