"""The planning problem, and what a plan-net rests on."""

from math import dist

import pytest

from app.domain.world_model import broken_support, initial_support, planning_problem, revise_beliefs
from app.domain.world_model.edits import changed
from planner import INITIAL, Fact
from robots.world import Zone, ZoneRule
from robots.world.file import ROBOT_WIDTH_M
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


def test_the_part_of_a_way_in_a_slow_zone_counts_by_the_time_that_it_takes() -> None:
    gate = Zone(name="gate", x=(0, 8), y=(1.0, 2.0), rule=ZoneRule.SLOW, max_speed_m_s=0.1)
    world = changed(STORE.world, zones=(gate,))
    functions = planning_problem(world, STORE.facts, []).functions
    inside_m = 1.0 + ROBOT_WIDTH_M  # its hull is in before its middle is
    way_m = 3.2 - inside_m + inside_m * 0.5 / 0.1
    assert functions["distance_m", ("door_1", "interchange_1")] == pytest.approx(way_m, abs=0.001)
    assert functions["distance_m", ("bay_1", "bay_2")] == 1.4
    fast = gate.model_copy(update={"max_speed_m_s": 0.5})  # as fast as the robots
    functions = planning_problem(changed(STORE.world, zones=(fast,)), STORE.facts, []).functions
    assert functions["distance_m", ("door_1", "interchange_1")] == 3.2


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
