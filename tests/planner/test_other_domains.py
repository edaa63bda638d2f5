"""Domains that are not about robots: every plan is valid in unified-planning's eyes, and a proof is one."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from unified_planning.engines import PlanGenerationResultStatus as Status
from unified_planning.environment import get_environment
from unified_planning.io import PDDLReader
from unified_planning.shortcuts import AnytimePlanner, OneshotPlanner

from planner import (
    KnowledgeBase,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    register_with_unified_planning,
)
from planner.engines.improving_portfolio import ImprovingPortfolio
from planner.engines.registry import improving_portfolio
from planner.problem.interface import UNOBSERVED, Observer
from tests.planner.test_up_engine import is_valid

DOMAINS = Path(__file__).parent / "domains"
SOLVABLE = sorted(path.name.removesuffix("_solvable.pddl") for path in DOMAINS.glob("*_solvable.pddl"))
UNSOLVABLE = sorted(path.name.removesuffix("_unsolvable.pddl") for path in DOMAINS.glob("*_unsolvable.pddl"))


@pytest.fixture(autouse=True)
def _registered() -> None:
    register_with_unified_planning()
    get_environment().credits_stream = None


def read(name: str, kind: str) -> Any:
    """The problem of that name that is `solvable` or `unsolvable`."""
    return PDDLReader().parse_problem(
        str(DOMAINS / f"{name}_domain.pddl"), str(DOMAINS / f"{name}_{kind}.pddl")
    )


class Unhurried(ImprovingPortfolio):
    """Takes as long as a busy machine needs to a first plan, and then 1.8 s for better ones."""

    def answers(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> Iterator[PlanningResult]:
        yield from super().answers(problem, replace(request, effort_s=1.8), observer)


def unhurried(knowledge_base: KnowledgeBase) -> Unhurried:
    return Unhurried(improving_portfolio(knowledge_base).engines)


@cache
def solved(name: str) -> tuple[Any, Any]:
    """The solvable problem of that name, and the engine's result."""
    problem = read(name, "solvable")
    with OneshotPlanner(name="macta") as planner:
        return problem, planner.solve(problem, timeout=60.0)


@pytest.mark.parametrize("name", SOLVABLE)
def test_every_plan_is_valid(name: str) -> None:
    problem, result = solved(name)
    assert result.status is Status.SOLVED_SATISFICING, result.log_messages
    assert is_valid(problem, result.plan)


@pytest.mark.parametrize("name", SOLVABLE)
def test_every_plan_on_the_way_is_valid(name: str) -> None:
    problem = read(name, "solvable")
    with AnytimePlanner(name="macta", params={"make_engine": unhurried}) as planner:
        results = [result for result in planner.get_solutions(problem) if result.plan]
    assert results
    assert all(is_valid(problem, result.plan) for result in results)


@pytest.mark.parametrize("name", UNSOLVABLE)
def test_what_has_no_plan_is_proven_to_have_none(name: str) -> None:
    with OneshotPlanner(name="macta") as planner:
        result = planner.solve(read(name, "unsolvable"), timeout=60.0)
    assert result.status is Status.UNSOLVABLE_PROVEN
    assert result.plan is None


def test_what_our_engine_plans_badly_others_improve() -> None:
    """Two grippers carry four balls in two trips: three steps each and the way back."""
    _, result = solved("gripper")
    assert float(result.metrics["makespan_s"]) == 7.0
