"""The planning problem, and what a plan-net rests on."""

from math import dist

from app.domain.world_model import broken_support, initial_support, planning_problem, revise_beliefs
from planner import INITIAL, Fact
from tests.app.sample_store import Store

STORE = Store()


def test_every_fact_of_the_problem_fits_the_knowledge_base() -> None:
    problem = planning_problem(STORE.world, STORE.facts, [STORE.fact("in(sample_1, bay_7)")])
    for fact in (*problem.facts, *problem.goals):
        STORE.base.check(fact, problem.objects)


def test_distances_join_just_the_places_that_one_robot_reaches() -> None:
    functions = planning_problem(STORE.world, STORE.facts, []).functions
    assert functions["distance_m", ("door_1", "interchange_1")] == 3.2
    assert functions["distance_m", ("interchange_1", "door_1")] == 3.2
    assert ("distance_m", ("door_1", "bay_1")) not in functions
    assert ("distance_m", ("bay_1", "bay_7")) not in functions
    assert functions["speed_m_s", ("yard_1",)] == 0.5


def test_a_robot_on_the_open_floor_is_as_far_from_places_as_its_spot() -> None:
    facts = revise_beliefs(STORE.facts, [Fact("robot_position", ("yard_1", "near", "yard_1_spot"))])
    problem = planning_problem(STORE.world, facts, [], spots={"yard_1_spot": (5.0, 2.0)})
    assert problem.functions["distance_m", ("yard_1_spot", "door_1")] == round(
        dist((5.0, 2.0), (2.0, 0.4)), 3
    )
    assert problem.objects["yard_1_spot"] == "location"
    assert "yard_2_spot" not in problem.objects


def test_a_plan_net_rests_on_its_links_from_the_initial_state() -> None:
    net = STORE.store_sample_1()
    assert initial_support(net) <= STORE.facts
    assert STORE.fact("in(sample_1, door_1)") in initial_support(net)
    assert {link.fact for link in net.causal_links if link.producer == INITIAL} == initial_support(net)
    assert broken_support(net, STORE.facts) == ()


def test_what_has_changed_under_a_plan_net_is_named() -> None:
    taken = revise_beliefs(STORE.facts, [STORE.fact("in(sample_2, bay_7)")])
    assert broken_support(STORE.store_sample_1(), taken) == (Fact("vacant", ("bay_7",)),)
    unrelated = revise_beliefs(STORE.facts, [STORE.fact("in(sample_2, bay_1)")])
    assert broken_support(STORE.store_sample_1(), unrelated) == ()
