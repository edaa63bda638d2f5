"""Laws of extraction and scheduling, on random walks through the sample store: no engine, many plan-nets."""

import random
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache

from hypothesis import given, settings
from hypothesis import strategies as st

from planner import Fact, GroundAction, PlanNet, PlanNetAction, PlanningProblem, load_knowledge_base
from planner.knowledge.literal import Literal
from planner.plan_nets.assembly import assemble
from planner.plan_nets.extraction import extract, fault_of
from planner.plan_nets.plan_net import GOAL, INITIAL
from planner.plan_nets.validation import faults_of, unjustified
from tests.planner.store import store_problem

BASE = load_knowledge_base()
Walk = tuple[PlanningProblem, tuple[GroundAction, ...], PlanNet]


@cache
def store() -> tuple[PlanningProblem, tuple[GroundAction, ...]]:
    """A store with two samples, and its ground actions."""
    problem = store_problem([], samples={"sample_1": "door_1", "sample_2": "bay_2"})
    return problem, tuple(ground_actions(problem))


def ground_actions(problem: PlanningProblem) -> Iterable[GroundAction]:
    for op in BASE.operators:
        statics = [literal for literal in op.preconditions if literal.predicate not in BASE.fluents]
        bindings: list[dict[str, str]] = [{}]
        for name, kind in op.parameters.items():
            values = [value for value, its in problem.objects.items() if its == kind]
            bindings = [{**b, name: value} for b in bindings for value in values if value not in b.values()]
            bindings = [b for b in bindings if hold(statics, b, op.parameters, problem.facts)]
        yield from (action for b in bindings if (action := op.ground(b, problem.functions)) is not None)


def hold(
    literals: list[Literal], bound: Mapping[str, str], parameters: Mapping[str, str], facts: frozenset[Fact]
) -> bool:
    still_open = parameters.keys() - bound.keys()
    return all(literal.ground(bound) in facts for literal in literals if still_open.isdisjoint(literal.terms))


@st.composite
def walks(draw: st.DrawFn) -> Walk:
    """A walk of up to 24 actions and the plan-net for what some of them intended and that holds in the
    end."""
    problem, actions = store()
    choose = random.Random(draw(st.integers(0, 2**32)))
    state = problem.facts
    sequence = list[GroundAction]()
    for _ in range(draw(st.integers(1, 24))):
        able = [action for action in actions if state.issuperset(action.preconditions)]
        handling = [action for action in able if action.tag in ("DOCK", "TRANSPORT", "RELEASE2")]
        action = choose.choice(handling if handling and choose.random() < 0.7 else able)
        state = (state - set(action.deletes)) | set(action.effects)
        sequence.append(action)
    intended = sorted(
        {fact for action in sequence for fact in action.intended_effects} & state - problem.facts
    )
    achieved = [fact for fact in intended if last_change_intends(sequence, fact)]
    goals = tuple(choose.sample(achieved, min(len(achieved), 3)))
    order = extract(sequence, problem.facts, goals)
    return problem, tuple(sequence), assemble(order, goals, BASE, {})


def last_change_intends(sequence: list[GroundAction], fact: Fact) -> bool:
    last = next(action for action in reversed(sequence) if fact in (*action.deletes, *action.effects))
    return fact in last.intended_effects


def random_linearisation(plan_net: PlanNet, choose: random.Random) -> list[PlanNetAction]:
    after = {
        action.id: {o.before for o in plan_net.orderings if o.after == action.id}
        for action in plan_net.actions
    }
    done: list[PlanNetAction] = []
    while len(done) < len(plan_net.actions):
        names = {action.id for action in done}
        done.append(
            choose.choice([a for a in plan_net.actions if a.id not in names and after[a.id] <= names])
        )
    return done


@settings(max_examples=30, deadline=None)
@given(walk=walks(), seed=st.integers(0, 2**32))
def test_every_linearisation_of_a_plan_net_is_valid(walk: Walk, seed: int) -> None:
    problem, _, plan_net = walk
    for number in range(8):
        sequence = random_linearisation(plan_net, random.Random(seed + number))
        assert fault_of(sequence, problem.facts, plan_net.goals) is None


@settings(max_examples=30, deadline=None)
@given(walk=walks())
def test_a_plan_net_has_no_faults(walk: Walk) -> None:
    """Support, threats, robots, schedule and replay; a random walk may well do things it does not intend."""
    problem, _, plan_net = walk
    assert set(faults_of(plan_net, problem.facts, BASE)) <= set(unjustified(plan_net, BASE))


@settings(max_examples=30, deadline=None)
@given(walk=walks())
def test_every_action_of_a_plan_net_serves_something(walk: Walk) -> None:
    _, sequence, plan_net = walk
    producers = {link.producer for link in plan_net.causal_links}
    assert {action.id for action in plan_net.actions} <= producers
    assert len(plan_net.actions) <= len(sequence)


@settings(max_examples=30, deadline=None)
@given(walk=walks(), seed=st.integers(0, 2**32))
def test_carried_out_at_any_start_within_the_windows_of_one_action_the_rest_can_follow(
    walk: Walk, seed: int
) -> None:
    """An action that starts as late as it may delays nothing beyond the makespan."""
    _, _, plan_net = walk
    if not plan_net.actions:
        return
    late = random.Random(seed).choice(plan_net.actions)
    ends: dict[str, float] = {}
    for action in sorted(plan_net.actions, key=lambda action: (action.earliest_start_s, int(action.id[1:]))):
        ready = max((ends[o.before] for o in plan_net.orderings if o.after == action.id), default=0.0)
        ends[action.id] = max(ready, late.latest_start_s if action is late else 0.0) + action.duration_s
    assert max(ends.values()) <= plan_net.makespan_s + 0.05


@settings(max_examples=20, deadline=None)
@given(walk=walks())
def test_a_plan_net_that_lost_an_ordering_is_found_faulty(walk: Walk) -> None:
    """The orderings are a reduction: each is needed, by a link, a threat or a shared robot."""
    problem, _, plan_net = walk
    linked = {(link.producer, link.consumer) for link in plan_net.causal_links}
    for ordering in plan_net.orderings:
        if (ordering.before, ordering.after) not in linked:
            without = replace(plan_net, orderings=tuple(o for o in plan_net.orderings if o != ordering))
            assert set(faults_of(without, problem.facts, BASE)) - set(unjustified(plan_net, BASE))


@given(walk=walks())
@settings(max_examples=20, deadline=None)
def test_ids_follow_the_start_order_and_the_links_name_them(walk: Walk) -> None:
    _, _, plan_net = walk
    assert [action.id for action in plan_net.actions] == [f"a{n + 1}" for n in range(len(plan_net.actions))]
    starts = [action.earliest_start_s for action in plan_net.actions]
    assert starts == sorted(starts)
    names = {action.id for action in plan_net.actions}
    assert {link.producer for link in plan_net.causal_links} <= names | {INITIAL}
    assert {link.consumer for link in plan_net.causal_links} <= names | {GOAL}
