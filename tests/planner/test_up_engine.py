"""Macta as an engine of unified-planning, on its own examples, its plans judged by its validators."""

from typing import Any

import pytest
from unified_planning.engines import PlanGenerationResultStatus as Status
from unified_planning.environment import get_environment
from unified_planning.plans import PlanKind
from unified_planning.shortcuts import (
    AnytimePlanner,
    BoolType,
    DurativeAction,
    EndTiming,
    OneshotPlanner,
    PlanValidator,
    Problem,
    StartTiming,
    UserType,
)
from unified_planning.test.examples import get_example_problems

from planner import register_with_unified_planning
from planner.engines.fast_downward import FastDownwardEngine
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.up_engine import MactaEngine

EXAMPLES = {
    name: example.problem
    for name, example in get_example_problems().items()
    if type(example.problem).__name__ == "Problem" and MactaEngine.supports(example.problem.kind)
}
NEEDS_CONCURRENCY = {"matchcellar", "matchcellar_static_duration"}


@pytest.fixture(autouse=True)
def _registered() -> None:
    register_with_unified_planning()
    get_environment().credits_stream = None


def is_valid(problem: Any, plan: Any) -> bool:
    if plan.kind is PlanKind.PARTIAL_ORDER_PLAN:
        plan = plan.convert_to(PlanKind.SEQUENTIAL_PLAN, problem)
    plain = problem.clone()
    plain.clear_quality_metrics()
    with PlanValidator(problem_kind=plain.kind, plan_kind=plan.kind) as validator:
        return bool(validator.validate(plain, plan))


def test_there_are_classical_and_durative_examples() -> None:
    durative = {name for name, problem in EXAMPLES.items() if problem.kind.has_continuous_time()}
    assert durative - NEEDS_CONCURRENCY
    assert len(EXAMPLES) - len(durative) > 8


@pytest.mark.parametrize("name", sorted(EXAMPLES.keys() - NEEDS_CONCURRENCY))
def test_plans_are_valid_in_unified_plannings_eyes(name: str) -> None:
    problem = EXAMPLES[name]
    with OneshotPlanner(name="macta", params={"make_engine": FastDownwardEngine}) as planner:
        result = planner.solve(problem, timeout=100.0)
    assert result.status is Status.SOLVED_SATISFICING, result.log_messages
    durative = problem.kind.has_continuous_time()
    assert result.plan.kind is (PlanKind.TIME_TRIGGERED_PLAN if durative else PlanKind.PARTIAL_ORDER_PLAN)
    assert is_valid(problem, result.plan)


@pytest.mark.parametrize("name", sorted(NEEDS_CONCURRENCY))
def test_what_needs_actions_inside_each_other_is_refused(name: str) -> None:
    with OneshotPlanner(name="macta") as planner:
        result = planner.solve(EXAMPLES[name])
    assert result.status is Status.UNSUPPORTED_PROBLEM
    assert "light_match" in result.log_messages[0].message


def test_a_problem_without_a_plan_is_proven_to_have_none() -> None:
    problem = EXAMPLES["hierarchical_blocks_world"].clone()
    for fluent in list(problem.explicit_initial_values):
        problem.set_initial_value(fluent, False)
    with OneshotPlanner(name="macta", params={"make_engine": FastDownwardEngine}) as planner:
        result = planner.solve(problem, timeout=100.0)
    assert result.status is Status.UNSOLVABLE_PROVEN
    assert result.log_messages[0].message


def test_the_anytime_planner_ends_with_its_best_plan() -> None:
    problem = EXAMPLES["robot_loader"]
    with AnytimePlanner(name="macta", params={"make_engine": FastDownwardEngine}) as planner:
        results = list(planner.get_solutions(problem, timeout=100.0))
    assert [result.status for result in results] == [Status.INTERMEDIATE, Status.SOLVED_SATISFICING]
    assert all(is_valid(problem, result.plan) for result in results)


def talking(tables: int) -> Any:
    """Two speakers say a word each on one channel, which each takes for two seconds; and lay tables meanwhile."""
    speaker, channel = UserType("speaker"), UserType("channel")
    problem = Problem("talking")
    is_free = problem.add_fluent("is_free", BoolType(), default_initial_value=False, c=channel)
    has_said = problem.add_fluent("has_said", BoolType(), default_initial_value=False, s=speaker)
    is_laid = problem.add_fluent("is_laid", BoolType(), default_initial_value=False, s=speaker)
    say = DurativeAction("say", s=speaker, c=channel)
    say.set_fixed_duration(2)
    say.add_condition(StartTiming(), is_free(say.c))
    say.add_effect(StartTiming(), is_free(say.c), False)
    say.add_effect(EndTiming(), is_free(say.c), True)
    say.add_effect(EndTiming(), has_said(say.s), True)
    lay = DurativeAction("lay", s=speaker)
    lay.set_fixed_duration(3)
    lay.add_effect(EndTiming(), is_laid(lay.s), True)
    problem.add_actions([say, lay])
    channels = problem.add_object("radio", channel)
    problem.set_initial_value(is_free(channels), True)
    for number in range(2):
        one = problem.add_object(f"s{number}", speaker)
        problem.add_goal(has_said(one))
        if number < tables:
            problem.add_goal(is_laid(one))
    return problem


def test_what_an_action_takes_and_gives_back_is_used_by_one_at_a_time() -> None:
    problem = talking(tables=0)
    with OneshotPlanner(name="macta", params={"make_engine": HierarchicalEngine}) as planner:
        result = planner.solve(problem, timeout=20.0)
    assert is_valid(problem, result.plan)
    assert result.metrics["makespan_s"] == "4"


@pytest.mark.parametrize("agents", [(), ("speaker",)])
def test_only_agents_that_are_named_do_one_action_at_a_time(agents: tuple[str, ...]) -> None:
    problem = talking(tables=2)
    params = {"make_engine": HierarchicalEngine, "agents": agents}
    with OneshotPlanner(name="macta", params=params) as planner:
        result = planner.solve(problem, timeout=20.0)
    assert is_valid(problem, result.plan)
    speaking_s = 4.0
    assert (float(result.metrics["makespan_s"]) > speaking_s) == bool(agents)
