"""The lifted relaxation against one that grounds everything."""

from dataclasses import replace
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner import Fact, KnowledgeBase, PlanningProblem, load_knowledge_base
from planner.knowledge.expression import DURATION_SCALE
from planner.relaxation import Relaxation, is_relaxed_reachable, unreachable_goals
from planner.relaxation.reachability import members_of
from tests.planner.store import inside, store_problem

BASE = load_knowledge_base()
PLACES = ("door", "bay", "bench")
ROBOTS = ("ann", "bob")
SAMPLES = ("s1", "s2")
OBJECTS = (
    dict.fromkeys(PLACES, "location")
    | dict.fromkeys(ROBOTS, "robot")
    | dict.fromkeys(SAMPLES, "object")
    | {"lab": "area"}
)


def ground_relaxation(base: KnowledgeBase, problem: PlanningProblem) -> tuple[set[Fact], set[Fact]]:
    """Everything reached, and everything reached on purpose, by trying all ground actions till nothing is new."""
    members = members_of(base, problem.objects)
    actions = [
        action
        for op in base.operators
        for values in product(*(sorted(members.get(kind, ())) for kind in op.parameters.values()))
        if all(dict(zip(op.parameters, values, strict=True))[a] != dict(zip(op.parameters, values, strict=True))[b]
               for a, b in op.distinct)
        and (action := op.ground(dict(zip(op.parameters, values, strict=True)), problem.functions)) is not None
    ]  # fmt: skip
    reached = set(problem.facts)
    achieved = set(problem.facts)
    grown = True
    while grown:
        applicable = [action for action in actions if reached.issuperset(action.preconditions)]
        more = {fact for action in applicable for fact in action.effects}
        grown = not more <= reached
        reached |= more
        achieved |= {fact for action in applicable for fact in action.intended_effects}
    return reached, achieved


@st.composite
def labs(draw: st.DrawFn) -> PlanningProblem:
    """Two robots, three places and two samples, with anything missing."""
    pairs = list(product(PLACES, PLACES))
    facts = {Fact("in_area", (robot, "lab")) for robot in ROBOTS}
    facts |= {Fact("reaches", p) for p in product(ROBOTS, PLACES) if draw(st.integers(0, 4))}
    tags = ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2", "RELEASE1")
    facts |= {Fact("can", p) for p in product(ROBOTS, tags) if draw(st.integers(0, 6))}
    facts |= {Fact("robot_attribute", (robot, "gripper", "empty")) for robot in ROBOTS}
    facts |= {Fact("robot_position", (robot, "near", draw(st.sampled_from(PLACES)))) for robot in ROBOTS}
    facts |= {Fact("clear", (place, "lab")) for place in PLACES if draw(st.booleans())}
    facts |= {Fact("vacant", (place,)) for place in PLACES if draw(st.booleans())}
    facts |= {inside(sample, draw(st.sampled_from(PLACES))) for sample in SAMPLES}
    functions = {
        ("distance_m", pair): 1.0 for pair in pairs if pair[0] != pair[1] and draw(st.integers(0, 5))
    }
    functions |= {("speed_m_s", (robot,)): 0.5 for robot in ROBOTS if draw(st.integers(0, 5))}
    goals = [inside("s1", place) for place in PLACES]
    goals += [Fact("robot_position", ("ann", "near", place)) for place in PLACES]
    goals += [Fact("clear", ("bay", "lab")), Fact("object_position", ("s1", "in", "bob"))]
    return PlanningProblem(objects=OBJECTS, facts=frozenset(facts), goals=tuple(goals), functions=functions)


@settings(max_examples=40, deadline=None)
@given(labs())
def test_it_reaches_the_same_goals_as_a_ground_relaxation(problem: PlanningProblem) -> None:
    _, achieved = ground_relaxation(BASE, problem)
    assert set(unreachable_goals(BASE, problem)) == set(problem.goals) - achieved


@settings(max_examples=20, deadline=None)
@given(labs())
def test_it_reaches_the_same_observed_facts_as_a_ground_relaxation(problem: PlanningProblem) -> None:
    reached, _ = ground_relaxation(BASE, problem)
    relaxation = Relaxation(BASE, problem, observed=("robot_position", "object_position"))
    relaxation.run()
    assert all(relaxation.holds(fact) for fact in reached if fact.predicate.endswith("_position"))
    for robot, rel, place in product(ROBOTS, ("at", "near"), PLACES):
        fact = Fact("robot_position", (robot, rel, place))
        assert relaxation.holds(fact) == (fact in reached)


def test_what_a_goal_rests_on_suffices_for_it() -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    relaxation = Relaxation(BASE, problem)
    relaxation.run()
    leaves = {fact for fact in relaxation.leaves(problem.goals[0]) if fact.predicate in BASE.predicates}
    assert is_relaxed_reachable(BASE, replace(problem, facts=frozenset(leaves)))


@pytest.mark.parametrize("place", ["home_yard_1", "home_store_2"])
def test_a_place_that_holds_no_samples_is_out_of_reach(place: str) -> None:
    assert not is_relaxed_reachable(BASE, store_problem([inside("sample_1", place)]))


def test_supposing_one_reach_brings_a_bay_back() -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    reach = {fact for fact in problem.facts if fact.predicate == "reaches" and "bay_7" in fact.args}
    less = replace(problem, facts=problem.facts - reach)
    assert not is_relaxed_reachable(BASE, less)
    relaxation = Relaxation(BASE, less, supposed=reach)
    relaxation.run()
    assert relaxation.missing(problem.goals[0]) == reach


def test_what_scales_durations_is_no_matter_of_reach() -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    scaled = {(DURATION_SCALE, ("navigate", "yard_1")): 1.5}
    assert is_relaxed_reachable(BASE, replace(problem, functions={**problem.functions, **scaled}))
