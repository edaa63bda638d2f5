"""What the constraints on a plan cost."""

from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from planner import (
    UNOBSERVED,
    Observer,
    PlanNet,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    load_knowledge_base,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.explanation import ConstraintCost, explain
from planner.explanation.constraining import constraint_costs
from planner.problem.solving import TimeLimitedEngine
from tests.planner.stepped_clock import TickingClock
from tests.planner.store import inside, store_problem

BASE = load_knowledge_base()
FREE = store_problem([inside("sample_1", "bay_7")])
FIRST = PlanningRequest(effort_s=0.0)


def without_robot(problem: PlanningProblem, robot: str) -> PlanningProblem:
    facts = (fact for fact in problem.facts if fact.predicate != "can" or fact.args[0] != robot)
    return replace(problem, facts=frozenset(facts))


def solved(problem: PlanningProblem) -> PlanNet:
    plan_net = HierarchicalEngine(BASE).plan(problem, FIRST).plan_net
    assert plan_net is not None
    return plan_net


def test_a_robot_that_must_not_act_costs_the_time_that_the_others_need_more() -> None:
    given = without_robot(FREE, "yard_1")
    plan_net, best = solved(given), solved(FREE)
    why = explain(
        plan_net,
        given,
        BASE,
        HierarchicalEngine(BASE),
        FIRST,
        without={"without yard_1": FREE, "again": given},
    )
    costs, again = why.constraints
    assert costs.at_least_s == pytest.approx(plan_net.makespan_s - best.makespan_s)
    assert costs.at_least_s > 1.0
    assert (again.at_least_s, again.constraint) == (0.0, "again")


def test_without_an_engine_or_time_nothing_is_said_of_constraints() -> None:
    plan_net = solved(FREE)
    assert explain(plan_net, FREE, BASE, None, without={"without yard_2": FREE}).constraints == ()
    over = replace(FIRST, time_limit_s=0.001, clock=TickingClock())
    engine = HierarchicalEngine(BASE)
    assert explain(plan_net, FREE, BASE, engine, over, without={"without yard_2": FREE}).constraints == ()


class Scripted(PlanningEngine):
    """Answers the plan-net with a makespan and a bound; neither if it is to find nothing."""

    name = "scripted"

    def __init__(self, makespan_s: float | None, bound_s: float | None) -> None:
        self._found: Any = None if makespan_s is None else SimpleNamespace(makespan_s=makespan_s)
        self._bound_s = bound_s

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        status = PlanningStatus.NOT_FOUND if self._found is None else PlanningStatus.SOLVED
        return PlanningResult(
            status=status, engine="", planning_s=0, plan_net=self._found, lower_bound_s=self._bound_s
        )


@pytest.mark.parametrize(
    ("longer", "bound", "least", "most", "words"),
    [
        (0.5, None, 0.5, None, "at least: so much shorter is a plan without it"),
        (
            0.5,
            0.25,
            0.5,
            0.75,
            "at least: so much shorter is a plan without it; no plan without it is more than",
        ),
        (0.5, 0.5, 0.5, 0.5, "so much shorter is the shortest plan without it"),
        (2.0, 0.75, 0.0, 0.25, "no shorter plan without it was found; no plan without it is more than"),
        (2.0, None, 0.0, None, "no shorter plan without it was found"),
        (2.0, 0.0, 0.0, None, "no shorter plan without it was found"),
        (None, 1.0, 0.0, 0.0, "it costs no time: no plan without it is shorter"),
        (1.0, 1.5, 0.0, 0.0, "it costs no time: no plan without it is shorter"),
    ],
)
def test_what_is_found_and_what_is_proven_are_both_told(
    longer: float | None, bound: float | None, least: float, most: float | None, words: str
) -> None:
    plan_net = solved(FREE)
    whole_s = plan_net.makespan_s
    engine = Scripted(*(None if part is None else part * whole_s for part in (longer, bound)))
    without: Mapping[str, PlanningProblem] = {"avoiding bay_3": FREE}
    (cost,) = constraint_costs(plan_net, without, TimeLimitedEngine(engine, FIRST, UNOBSERVED))
    expected = ConstraintCost(
        constraint="avoiding bay_3",
        at_least_s=pytest.approx(least * whole_s),
        at_most_s=None if most is None else pytest.approx(most * whole_s),
    )
    assert cost == expected
    assert words in cost.words
