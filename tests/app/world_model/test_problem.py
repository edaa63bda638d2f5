"""The planning problem, reservations and what a plan-net rests on."""

from math import dist

from app.world_model import (
    Reservation,
    broken,
    planning_problem,
    reservation_of,
    rests_on,
    revised,
)
from planner import INITIAL, Fact
from tests.app.store import Store

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
    facts = revised(STORE.facts, [Fact("robot_position", ("yard_1", "near", "yard_1_spot"))])
    problem = planning_problem(STORE.world, facts, [], spots={"yard_1_spot": (5.0, 2.0)})
    assert problem.functions["distance_m", ("yard_1_spot", "door_1")] == round(
        dist((5.0, 2.0), (2.0, 0.4)), 3
    )
    assert problem.objects["yard_1_spot"] == "location"
    assert "yard_2_spot" not in problem.objects


def test_reserved_robots_can_do_nothing_and_reserved_places_and_samples_are_left_alone() -> None:
    reserved = Reservation(
        robots=frozenset({"yard_1"}), locations=frozenset({"interchange_2"}), samples=frozenset({"sample_1"})
    )
    problem = planning_problem(STORE.world, STORE.facts, [], reserved=reserved)
    left_out = STORE.facts - problem.facts
    assert {f.predicate for f in left_out} == {"can", "clear", "vacant", "object_position"}
    assert {f.args[0] for f in left_out} == {"yard_1", "interchange_2", "sample_1"}


def test_a_plan_net_reserves_its_robots_places_and_samples() -> None:
    reserved = reservation_of(STORE.store_sample_1())
    assert reserved == Reservation(
        robots=frozenset({"yard_1", "store_2"}),
        locations=frozenset({"home_yard_1", "door_1", "interchange_2", "home_store_2", "bay_7"}),
        samples=frozenset({"sample_1"}),
    )


def test_reservations_overlap_in_what_both_use() -> None:
    one = reservation_of(STORE.store_sample_1())
    other = Reservation(robots=frozenset({"store_2"}), locations=frozenset({"bay_7", "bay_8"}))
    assert one.overlaps(other)
    assert one.shared(other) == ("bay_7", "store_2")
    assert not one.overlaps(Reservation(robots=frozenset({"yard_2"})))


def test_a_plan_net_rests_on_its_links_from_the_initial_state() -> None:
    net = STORE.store_sample_1()
    assert rests_on(net) <= STORE.facts
    assert STORE.fact("in(sample_1, door_1)") in rests_on(net)
    assert {link.fact for link in net.causal_links if link.producer == INITIAL} == rests_on(net)
    assert broken(net, STORE.facts) == ()


def test_what_has_changed_under_a_plan_net_is_named() -> None:
    taken = revised(STORE.facts, [STORE.fact("in(sample_2, bay_7)")])
    assert broken(STORE.store_sample_1(), taken) == (Fact("vacant", ("bay_7",)),)
    unrelated = revised(STORE.facts, [STORE.fact("in(sample_2, bay_1)")])
    assert broken(STORE.store_sample_1(), unrelated) == ()
