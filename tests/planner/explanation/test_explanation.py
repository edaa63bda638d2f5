"""Why a plan-net is as it is: purposes, robots, order and time, each held against the plan-net itself."""

from dataclasses import replace
from itertools import pairwise

import pytest

from planner import (
    GOAL,
    UNOBSERVED,
    KnowledgeBase,
    Observer,
    OrderingReason,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
)
from planner.engines.fast_downward import FastDownwardEngine
from planner.explanation import Explanation, explain
from planner.problem.static_facts import StaticFacts
from tests.planner.store import inside, store_problem

REQUEST = PlanningRequest(time_limit_s=60)


def solved(engine: FastDownwardEngine, problem: PlanningProblem, observer: Observer = UNOBSERVED) -> PlanNet:
    plan_net = engine.plan(problem, REQUEST, observer).plan_net
    assert plan_net is not None
    return plan_net


@pytest.fixture(scope="module")
def problem() -> PlanningProblem:
    """The samples cross in interchange_2, and yard_1 comes and goes there."""
    return store_problem(
        [inside("sample_1", "bay_7"), inside("sample_2", "bay_8")],
        samples={"sample_1": "door_1", "sample_2": "door_2"},
    )


@pytest.fixture(scope="module")
def plan_net(engine: FastDownwardEngine, problem: PlanningProblem) -> PlanNet:
    return solved(engine, problem)


@pytest.fixture(scope="module")
def explanation(
    plan_net: PlanNet, problem: PlanningProblem, knowledge_base: KnowledgeBase, engine: FastDownwardEngine
) -> Explanation:
    return explain(plan_net, problem, knowledge_base, engine, REQUEST)


def test_each_action_serves_a_goal_through_a_chain_of_the_plans_own_links(
    plan_net: PlanNet, explanation: Explanation, knowledge_base: KnowledgeBase
) -> None:
    assert [one.action for one in explanation.actions] == [action.id for action in plan_net.actions]
    for one in explanation.actions:
        assert set(one.goals) <= set(plan_net.goals)
        assert set(one.chain) <= set(plan_net.causal_links)
        assert one.chain[0].producer == one.action
        assert one.chain[-1].consumer == GOAL
        assert one.chain[-1].fact in one.goals
        assert all(link.consumer == other.producer for link, other in pairwise(one.chain))
        first = one.chain[0].fact
        is_intended = first in plan_net.action(one.action).intended_effects
        assert is_intended or knowledge_base.predicates[first.predicate].make_way


def test_an_action_that_serves_one_goal_is_not_said_to_serve_the_other(
    plan_net: PlanNet, explanation: Explanation
) -> None:
    (link,) = [link for link in plan_net.causal_links if link.fact == inside("sample_1", "bay_7")]
    last = explanation.of(link.producer)
    assert inside("sample_2", "bay_8") not in last.goals or len(last.chain) > 1
    assert f"{last.action} RELEASE2 brings about that sample_1 is in bay_7: a goal" in last.because


def test_every_ordering_is_explained_to_both_its_actions(plan_net: PlanNet, explanation: Explanation) -> None:
    for ordering in plan_net.orderings:
        before = plan_net.action(ordering.before)
        after = plan_net.action(ordering.after)
        (chain_in_words,) = [
            words
            for words in explanation.of(after.id).order
            if words.startswith(f"after {before.id} {before.tag}: ")
        ]
        why = chain_in_words.split(": ", 1)[1]
        assert f"before {after.id} {after.tag}: {why}" in explanation.of(before.id).order
        if ordering.reason is OrderingReason.CAUSAL:
            assert "brings about that" in why


def test_doing_without_a_robot_costs_what_solving_without_it_says(
    problem: PlanningProblem, knowledge_base: KnowledgeBase, engine: FastDownwardEngine
) -> None:
    problem = replace(problem, goals=(inside("sample_1", "bay_7"),))
    plan_net = solved(engine, problem)
    assert plan_net.robots == ("store_2", "yard_1")
    explanation = explain(plan_net, problem, knowledge_base, engine, REQUEST)
    other = solved(engine, StaticFacts(knowledge_base, problem).without({"yard_1"}))
    words = f"yard_2 instead of yard_1: {other.makespan_s - plan_net.makespan_s:+.1f} s"
    assert explanation.robots["yard_1"] == words
    assert explanation.robots["store_2"] == "there is no plan without store_2: then no robot reaches bay_7"
    for action in plan_net.actions:
        one = explanation.of(action.id)
        assert tuple(one.robots) == action.agents
        if action.tag == "TRANSPORT":
            why = one.robots[action.agents[0]]
            assert (
                why.startswith(words) if "yard_1" in action.agents else why == "no other robot reaches bay_7"
            )


def test_a_robot_with_an_obstacle_is_named_with_it(
    problem: PlanningProblem, knowledge_base: KnowledgeBase, engine: FastDownwardEngine
) -> None:
    problem = replace(problem, goals=(inside("sample_1", "bay_7"),))
    plan_net = solved(engine, problem)
    explanation = explain(plan_net, problem, knowledge_base, None)
    assert explanation.robots == {}
    (drive,) = [a for a in plan_net.of_robot("yard_1") if a.tag == "NAVIGATE"]
    assert explanation.of(drive.id).robots == {
        "yard_1": "yard_2 could do it, too; store_1 does not reach door_1 (likewise store_2)"
    }
    (dock,) = [a for a in plan_net.of_robot("yard_1") if a.tag == "DOCK"]
    elsewhere = "nothing brings about that store_1 is near door_1 (likewise store_2)"
    assert explanation.of(dock.id).robots == {"yard_1": f"yard_2 could do it, too; {elsewhere}"}


def test_who_stops_the_trials_still_gets_what_needs_none(
    plan_net: PlanNet, problem: PlanningProblem, knowledge_base: KnowledgeBase, engine: FastDownwardEngine
) -> None:
    class Impatient(Observer):
        def should_stop(self) -> bool:
            return True

    explanation = explain(plan_net, problem, knowledge_base, engine, REQUEST, Impatient())
    assert explanation.robots == {}
    assert len(explanation.actions) == len(plan_net.actions)


def test_the_makespan_is_made_of_the_critical_path(plan_net: PlanNet, explanation: Explanation) -> None:
    words = "\n".join(explanation.makespan)
    places = [words.index(f"{one} {plan_net.action(one).tag}") for one in plan_net.critical_path]
    assert places == sorted(places)
    assert f"{plan_net.makespan_s:.1f} s" in explanation.makespan[-1]


def test_waits_are_the_gaps_in_the_robots_lanes(plan_net: PlanNet, explanation: Explanation) -> None:
    assert explanation.waits
    assert [w.span_s for w in explanation.waits] == sorted(
        (w.span_s for w in explanation.waits), reverse=True
    )
    for robot in plan_net.robots:
        busy_s = sum(action.duration_s for action in plan_net.of_robot(robot))
        idle_s = sum(wait.span_s for wait in explanation.waits if wait.robot == robot)
        assert busy_s + idle_s == pytest.approx(plan_net.of_robot(robot)[-1].earliest_end_s, abs=0.05)
    for wait in explanation.waits:
        assert plan_net.action(wait.awaited).earliest_end_s == pytest.approx(
            plan_net.action(wait.action).earliest_start_s, abs=0.01
        )
        assert wait.from_s + wait.span_s == pytest.approx(
            plan_net.action(wait.action).earliest_start_s, abs=0.0015
        )
        assert wait.robot in wait.words
