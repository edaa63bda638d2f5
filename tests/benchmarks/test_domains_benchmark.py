"""The benchmark on planning domains: its problems, its judgement of plans, its scores."""

from typing import Any

import pytest
from unified_planning.engines import PlanGenerationResultStatus as Status
from unified_planning.environment import get_environment
from unified_planning.plans import ActionInstance, SequentialPlan

from benchmarks.domains.__main__ import options, tasks
from benchmarks.domains.catalogue import DOMAINS, FIRST_SEED, SIZES
from benchmarks.domains.judge import fault_of, quality_of
from benchmarks.domains.measure import Measure, Task
from benchmarks.domains.model import Form
from benchmarks.domains.partial_order import PartialOrderPlanner
from benchmarks.domains.planners import OURS
from benchmarks.domains.table import by_domain, faults, score, summary
from planner.engines.registry import portfolio
from planner.up_engine import MactaEngine


@pytest.fixture(autouse=True)
def _quiet() -> None:
    get_environment().credits_stream = None


def problem(domain: str, form: Form, seed: int = FIRST_SEED) -> Any:
    return DOMAINS[domain](SIZES[domain][0], seed, form)


@pytest.mark.parametrize("form", Form)
@pytest.mark.parametrize("domain", DOMAINS)
def test_problems_depend_on_size_seed_and_form_alone(domain: str, form: Form) -> None:
    assert problem(domain, form) == problem(domain, form)
    assert problem(domain, form) != problem(domain, form, FIRST_SEED + 1)


@pytest.mark.parametrize("form", Form)
@pytest.mark.parametrize("domain", DOMAINS)
def test_the_smallest_problem_of_each_domain_has_a_plan(domain: str, form: Form) -> None:
    stated = problem(domain, form)
    result = MactaEngine(make_engine=portfolio).solve(stated, timeout=60.0)
    assert result.status is Status.SOLVED_SATISFICING, result.log_messages
    assert quality_of(result.plan) > 0.0
    assert fault_of(stated, result.plan) is None


def test_a_plan_with_a_step_left_out_is_faulty() -> None:
    stated = problem("blocksworld", Form.CLASSICAL)
    arm, block = stated.object("arm1"), stated.object("block1")
    step = ActionInstance(
        stated.action("put_down"), tuple(map(stated.environment.expression_manager.ObjectExp, (arm, block)))
    )
    assert fault_of(stated, SequentialPlan([step])) is not None


@pytest.mark.parametrize(
    ("domain", "size"), [("blocksworld", 2), ("logistics", 2), ("satellite", 2), ("depots", 1)]
)
def test_the_partial_order_planner_solves_the_smallest_of_all(domain: str, size: int) -> None:
    stated = DOMAINS[domain](size, FIRST_SEED, Form.CLASSICAL)
    (result,) = PartialOrderPlanner().get_solutions(stated, timeout=60.0)
    assert result.plan is not None
    assert fault_of(stated, result.plan) is None


def measure(planner: str, best: float | None, *, size: int = 3, fault: str | None = None) -> Measure:
    task = Task(planner=planner, domain="depots", form=Form.TEMPORAL, size=size, seed=1000, limit_s=1.0)
    first_s = None if best is None else 0.5
    return Measure(task=task, first=best, first_s=first_s, best=best, best_s=first_s, fault=fault)


def test_quality_is_relative_to_the_best_that_any_planner_found() -> None:
    measures = [
        measure(OURS, 20.0),
        measure("lpg", 10.0),
        measure(OURS, None, size=6),
        measure("lpg", 8.0, size=6),
    ]
    assert by_domain(measures, [OURS, "lpg"])[-1] == "| depots | temporal | 1 of 2, 2.00 | 2 of 2, 1.00 |"
    ours, lpg = summary(measures, [OURS, "lpg"])[2:]
    assert "| 1 of 2 | 0.5 | 0.5 | 2.00 |" in ours
    assert "| 2 of 2 | 2.0 | 2.0 | 1.00 |" in lpg


def test_without_a_plan_the_score_is_nothing() -> None:
    assert score(None, 8.0) == 0.0
    assert score(16.0, 8.0) == 0.5


def test_faulty_plans_are_named() -> None:
    assert faults([measure(OURS, 9.0)]) == []
    assert "depots temporal 3 seed 1000, lpg" in faults([measure("lpg", 9.0, fault="goal missed")])[0]


def test_each_planner_is_asked_for_the_forms_and_sizes_that_are_named() -> None:
    words = [
        "--domains",
        "depots",
        "rovers",
        "--sizes",
        "2",
        "5",
        "--planners",
        "fast-downward",
        "lpg",
        "--seeds",
        "2",
    ]
    asked = tasks(options(words))
    assert {(task.domain, task.size, task.seed) for task in asked} == {
        (domain, size, seed) for domain in ("depots", "rovers") for size in (2, 5) for seed in (1000, 1001)
    }
    assert {task.form for task in asked if task.planner == "fast-downward"} == {Form.CLASSICAL}
    assert len(asked) == 8 + 16
    assert {task.size for task in tasks(options(["--domains", "depots"]))} == set(SIZES["depots"])
