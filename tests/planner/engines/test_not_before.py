"""Goals that are not to be true before a time: planned, validated, forecast."""

from dataclasses import replace

import pytest

from planner import Fact, PlanNet, PlanningProblem, PlanningRequest, PlanningStatus, faults_of
from planner.engines.registry import engine_named
from planner.plan_nets.completion import completion_samples, forecast
from tests.planner.engines.test_oversubscription import BASE, done, problem


def planned(stated: PlanningProblem) -> PlanNet:
    result = engine_named("macta", BASE).plan(stated, PlanningRequest(effort_s=0.0))
    assert result.status is PlanningStatus.SOLVED, result.reason
    assert result.plan_net is not None
    assert faults_of(result.plan_net, stated.facts, BASE) == []
    return result.plan_net


def window(start_s: float, due_s: float | None = None) -> PlanningProblem:
    """Two jobs of 10 s by two robots, the first not done before `start_s`."""
    stated = problem([10, 10], [None, None], deadline_s=None, robots=2)
    due = {} if due_s is None else {done(0): due_s}
    return replace(stated, not_before_s={done(0): start_s}, deadlines_s=due)


def achiever(plan_net: PlanNet, goal: Fact) -> tuple[float, float]:
    (action,) = [one for one in plan_net.actions if goal in one.intended_effects]
    return action.earliest_start_s, action.not_before_s


def test_what_achieves_it_does_not_start_before_so_that_it_is_not_true_before() -> None:
    plan_net = planned(window(30.0))
    assert achiever(plan_net, done(0)) == (30.0, 30.0)
    assert achiever(plan_net, done(1)) == (0.0, 0.0)
    assert plan_net.makespan_s == 40.0
    assert plan_net.critical_path == tuple(one.id for one in plan_net.actions if one.not_before_s)


def test_a_time_that_is_over_delays_nothing() -> None:
    assert planned(window(-5.0)) == planned(window(0.0))
    assert planned(window(-5.0)).makespan_s == 10.0


def test_a_window_that_is_too_narrow_is_missed_and_said() -> None:
    assert planned(window(30.0, due_s=45.0)).late == {}
    assert planned(window(30.0, due_s=35.0)).late == {done(0): 5.0}


def test_no_sample_of_a_forecast_has_it_true_before() -> None:
    plan_net = planned(window(30.0))
    assert float(completion_samples(plan_net, {})[done(0)].min()) > 30.0
    assert float(completion_samples(plan_net, {})[done(1)].min()) < 10.0
    assert forecast(plan_net, {done(0): 30.0}, {}).on_time() == 0.0


def test_one_robot_does_what_is_not_bound_first() -> None:
    stated = replace(problem([10, 10], [None, None], deadline_s=None), not_before_s={done(0): 15.0})
    plan_net = planned(stated)
    assert plan_net.makespan_s == pytest.approx(25.0) or plan_net.makespan_s == pytest.approx(35.0)
    assert achiever(plan_net, done(0))[0] >= 15.0


def test_a_plan_that_starts_it_too_early_is_faulty() -> None:
    stated = window(30.0)
    plan_net = planned(stated)
    early = tuple(
        replace(one, earliest_start_s=20.0) if one.not_before_s else one for one in plan_net.actions
    )
    faults = faults_of(replace(plan_net, actions=early), stated.facts, BASE)
    assert [fault for fault in faults if "starts before 30 s" in fault]


def test_a_plan_in_which_something_else_brings_it_about_earlier_is_faulty() -> None:
    stated = window(30.0)
    plan_net = planned(stated)
    other = next(one for one in plan_net.actions if not one.not_before_s)
    also = tuple(replace(one, other_effects=(done(0),)) if one is other else one for one in plan_net.actions)
    faults = faults_of(replace(plan_net, actions=also), stated.facts, BASE)
    assert [fault for fault in faults if f"brings about {done(0)} before" in fault]
