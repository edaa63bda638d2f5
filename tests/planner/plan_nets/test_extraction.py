"""Sequences to partial orders: redundancy, links, and sizes far beyond the sample store."""

from collections.abc import Sequence
from dataclasses import replace

import pytest

from planner import GOAL, Fact, GroundAction, InvalidPlan, KnowledgeBase
from planner.plan_nets.assembly import assemble
from planner.plan_nets.causality import Link, causal_links
from planner.plan_nets.extraction import extract, fault_of
from planner.plan_nets.redundancy import indispensable, without_redundant
from planner.plan_nets.validation import faults_of
from tests.planner.large_store import LargeStore


def act(
    name: str,
    needs: Sequence[str] = (),
    deletes: Sequence[str] = (),
    intends: Sequence[str] = (),
    other: Sequence[str] = (),
) -> GroundAction:
    return GroundAction(
        tag=name,
        arguments={},
        agents=(name.partition("_")[0],),
        preconditions=tuple(map(Fact, needs)),
        deletes=tuple(map(Fact, deletes)),
        intended_effects=tuple(map(Fact, intends)),
        other_effects=tuple(map(Fact, other)),
        duration_s=1.0,
    )


def left(sequence: Sequence[GroundAction], goals: Sequence[str], facts: Sequence[str] = ()) -> list[str]:
    """The tags that stay."""
    kept = without_redundant(sequence, frozenset(map(Fact, facts)), tuple(map(Fact, goals)))
    return [action.tag for action in kept]


def test_an_action_whose_effects_lead_to_no_goal_goes() -> None:
    sequence = [act("a", intends=["p"]), act("b", needs=["p"], intends=["q"]), act("c", intends=["goal"])]
    assert left(sequence, ["goal"]) == ["c"]


def test_a_way_out_and_back_goes_though_links_use_it() -> None:
    sequence = [
        act("away", needs=["here"], deletes=["here"], intends=["there"]),
        act("back", needs=["there"], deletes=["there"], intends=["here"]),
        act("work", needs=["here"], intends=["goal"]),
    ]
    assert left(sequence, ["goal"], ["here"]) == ["work"]


def test_a_way_out_and_back_stays_if_something_is_fetched() -> None:
    sequence = [
        act("away", needs=["here"], deletes=["here"], intends=["there"]),
        act("fetch", needs=["there"], intends=["thing"]),
        act("back", needs=["there"], deletes=["there"], intends=["here"]),
        act("work", needs=["here", "thing"], intends=["goal"]),
    ]
    assert left(sequence, ["goal"], ["here"]) == ["away", "fetch", "back", "work"]
    facts = frozenset({Fact("here")})
    goals = (Fact("goal"),)
    assert indispensable(sequence, facts, goals) == {0, 1, 2, 3, 4}


def test_one_of_two_ways_goes_and_neither_is_indispensable() -> None:
    sequence = [
        act("one", intends=["p"]),
        act("two", intends=["p"]),
        act("end", needs=["p"], intends=["goal"]),
    ]
    assert indispensable(sequence, frozenset(), (Fact("goal"),)) == {2, 3}
    assert left(sequence, ["goal"]) in (["one", "end"], ["two", "end"])


def test_a_goal_is_achieved_by_an_intended_effect_only() -> None:
    by_the_way = act("by_the_way", other=["goal"])
    assert fault_of([by_the_way], frozenset(), (Fact("goal"),)) == "the goal goal() is not achieved"
    with pytest.raises(InvalidPlan, match="is not achieved"):
        extract([by_the_way], frozenset(), (Fact("goal"),))
    assert left([by_the_way, act("on_purpose", intends=["goal"])], ["goal"]) == ["on_purpose"]


def test_the_causal_link_to_a_goal_comes_from_an_action_that_intends_it() -> None:
    sequence = [act("by_the_way", intends=["p"], other=["goal"]), act("on_purpose", intends=["goal"])]
    goals = (Fact("goal"),)
    assert causal_links(sequence, frozenset(), goals) == (Link(1, Fact("goal"), 2),)
    with pytest.raises(InvalidPlan, match=r"nothing brings about goal\(\)"):
        causal_links(sequence[:1], frozenset(), goals)


def test_an_action_that_has_a_goal_as_another_effect_is_dispensable() -> None:
    sequence = [act("by_the_way", intends=["p"], other=["goal"]), act("on_purpose", intends=["goal"])]
    assert indispensable(sequence, frozenset(), (Fact("goal"),)) == {1, 2}


def test_a_causal_link_to_a_goal_from_an_effect_that_is_not_intended_is_a_fault(
    knowledge_base: KnowledgeBase,
) -> None:
    store = LargeStore(aisles=1, samples=1)
    problem = store.problem()
    order = extract(store.sequence(problem, knowledge_base), problem.facts, problem.goals)
    plan_net = assemble(order, problem.goals, knowledge_base, {})
    (goal,) = problem.goals
    (achiever,) = (link.producer for link in plan_net.causal_links if link.consumer == GOAL)
    by_the_way = [
        replace(
            action,
            intended_effects=tuple(fact for fact in action.intended_effects if fact != goal),
            other_effects=(*action.other_effects, goal),
        )
        if action.id == achiever
        else action
        for action in plan_net.actions
    ]
    faults = faults_of(replace(plan_net, actions=tuple(by_the_way)), problem.facts, knowledge_base)
    assert f"{achiever} does not bring about {goal} for goal" in faults


def test_deletes_by_actions_that_do_not_need_the_fact_are_all_kept_away() -> None:
    """Two unordered spoilers: each needs an ordering of its own."""
    sequence = [
        act("use", needs=["p"], intends=["goal"]),
        act("one_spoils", deletes=["p"], intends=["x"]),
        act("two_spoils", deletes=["p"], intends=["y"]),
    ]
    order = extract(sequence, frozenset({Fact("p")}), tuple(map(Fact, ("goal", "x", "y"))))
    assert set(order.orderings) == {(0, 1), (0, 2)}


@pytest.fixture(scope="module")
def errands() -> tuple[LargeStore, int]:
    return LargeStore(aisles=16, samples=64), 640


def test_hundreds_of_errands_become_a_faultless_plan_net(
    knowledge_base: KnowledgeBase, errands: tuple[LargeStore, int]
) -> None:
    store, count = errands
    problem = store.problem()
    sequence = store.sequence(problem, knowledge_base)
    assert len(sequence) == count
    order = extract(sequence, problem.facts, problem.goals)
    # Every robot's last drive home serves nothing.
    assert len(order.actions) == count - 2 * store.aisles
    plan_net = assemble(order, problem.goals, knowledge_base, {})
    assert faults_of(plan_net, problem.facts, knowledge_base) == []
    assert plan_net.makespan_s < sum(action.duration_s for action in plan_net.actions) / 4


def test_orderings_in_a_circle_or_of_unknown_actions_are_faults(knowledge_base: KnowledgeBase) -> None:
    store = LargeStore(aisles=1, samples=1)
    problem = store.problem()
    order = extract(store.sequence(problem, knowledge_base), problem.facts, problem.goals)
    plan_net = assemble(order, problem.goals, knowledge_base, {})
    first = plan_net.orderings[0]
    circle = replace(first, before=first.after, after=first.before)
    cyclic = replace(plan_net, orderings=(*plan_net.orderings, circle))
    assert "cyclic" in faults_of(cyclic, problem.facts, knowledge_base)[0]
    astray = replace(plan_net, orderings=(replace(first, after="a99"),))
    assert faults_of(astray, problem.facts, knowledge_base) == ["there is no action a99"]
