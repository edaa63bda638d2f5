"""What missions keep for themselves, and what a new plan leaves alone."""

import pytest

from app.domain.world_model import (
    Reservation,
    apply_action,
    initial_facts,
    named_in,
    needed_by,
    planning_problem,
    revise_beliefs,
    taken_by,
    union_of,
)
from app.domain.world_model.beliefs import position_of
from benchmarks.planner.timed_store import timed_store
from planner import Fact, PlanningRequest, PlanningStatus
from planner.engines.fast_downward import FastDownwardEngine
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from tests.app.sample_store import Store

STORE = Store()
ERRAND = Reservation(
    robots=frozenset({"yard_1", "store_2"}),
    locations=frozenset({"door_1", "interchange_2", "bay_7"}),
    samples=frozenset({"sample_1"}),
)
HOMES = Reservation(locations=frozenset({"home_yard_1", "home_store_2"}))


def test_a_plan_needs_everything_that_its_actions_name() -> None:
    net = STORE.store_sample_1()
    assert union_of(needed_by(action) for action in net.actions) == union_of([ERRAND, HOMES])


def test_a_plan_takes_what_it_needs_but_for_the_places_that_robots_only_leave() -> None:
    assert taken_by(STORE.store_sample_1()) == ERRAND


def test_a_robot_that_carries_a_sample_away_takes_the_sample_but_not_the_place_it_stood_at() -> None:
    held = [
        STORE.fact("in(sample_1, yard_1)"),
        Fact("robot_attribute", ("yard_1", "gripper", "full")),
        STORE.fact("near(yard_1, interchange_1)"),
    ]
    leg = {"object": "sample_1", "robots": "yard_1", "rel1": "near", "ref1": "interchange_1"}
    leg |= {"rel2": "near", "ref2": "door_2"}
    net = STORE.plan(
        [("TRANSPORT", {**leg, "area": "yard"}), ("RELEASE2", leg)],
        "in(sample_1, door_2)",
        facts=revise_beliefs(STORE.facts, held),
    )
    assert taken_by(net) == Reservation(
        robots=frozenset({"yard_1"}), locations=frozenset({"door_2"}), samples=frozenset({"sample_1"})
    )


def test_goals_name_what_a_mission_keeps_to_its_end() -> None:
    goals = [STORE.fact("in(sample_1, bay_7)"), STORE.fact("near(yard_1, door_1)")]
    assert named_in(goals) == Reservation(
        robots=frozenset({"yard_1"}),
        locations=frozenset({"bay_7", "door_1"}),
        samples=frozenset({"sample_1"}),
    )


def test_reservations_overlap_in_what_both_use() -> None:
    other = Reservation(robots=frozenset({"store_2"}), locations=frozenset({"bay_7", "bay_8"}))
    assert ERRAND.overlaps(other)
    assert ERRAND.shared(other) == ("bay_7", "store_2")
    assert not ERRAND.overlaps(Reservation(robots=frozenset({"yard_2"})))


def test_reserved_robots_can_do_nothing_and_reserved_places_and_samples_are_left_alone() -> None:
    reserved = Reservation(
        robots=frozenset({"yard_1"}), locations=frozenset({"bay_2"}), samples=frozenset({"sample_1"})
    )
    problem = planning_problem(STORE.world, STORE.facts, [], reserved=reserved)
    left_out = STORE.facts - problem.facts
    assert {f.predicate for f in left_out} == {"can", "in_area", "clear", "reaches", "object_position"}
    assert {f.args[0] for f in left_out if f.predicate == "can"} == {"yard_1"}
    assert {f.args[1] for f in left_out if f.predicate == "reaches"} == {"bay_2"}
    # sample_2 lies in bay_2.
    assert {f.args[0] for f in left_out if f.predicate == "object_position"} == {"sample_1", "sample_2"}


def test_a_plan_beside_a_mission_takes_nothing_that_the_mission_needs() -> None:
    """A robot that stands at a reserved place leaves it; nothing else there is touched."""
    facts = revise_beliefs(
        initial_facts(STORE.world, STORE.base),
        [STORE.fact("near(yard_1, interchange_2)"), STORE.fact("in(sample_2, interchange_2)")],
    )
    reserved = Reservation(
        robots=frozenset({"store_2"}),
        locations=frozenset({"interchange_2", "bay_7"}),
        samples=frozenset({"sample_2"}),
    )
    goals = [STORE.fact("in(sample_1, door_2)"), STORE.fact("near(yard_1, door_1)")]
    problem = planning_problem(STORE.world, facts, goals, reserved=reserved)
    net = FastDownwardEngine(STORE.base).plan(problem, PlanningRequest(time_limit_s=30)).plan_net
    assert net is not None
    assert any("interchange_2" in action.arguments.values() for action in net.actions)
    assert not taken_by(net).overlaps(reserved)


@pytest.mark.parametrize("ended", [1, 2])
def test_a_robot_between_two_phases_is_reserved_with_the_place_that_it_drives_to(ended: int) -> None:
    """The record has it at no place then; the one that it has left is for others to use."""
    base = timed_store()
    store = Store(base=base)
    way = {
        "robots": "yard_1",
        "rel1": "near",
        "ref1": "door_1",
        "rel2": "near",
        "ref2": "door_2",
        "area": "yard",
    }
    start = revise_beliefs(store.facts, [store.fact("near(yard_1, door_1)")])
    phases = store.plan([("NAVIGATE", way)], "near(yard_1, door_2)", facts=start).actions
    facts = start
    for phase in phases[:ended]:
        facts = apply_action(facts, phase)
    assert position_of("yard_1", facts) is None
    reserved = union_of(needed_by(phase) for phase in phases[ended:])
    assert reserved == Reservation(robots=frozenset({"yard_1"}), locations=frozenset({"door_2"}))

    goals = [store.fact("near(yard_2, door_1)")]
    problem = planning_problem(store.world, facts, goals, reserved=reserved)
    result = HierarchicalEngine(base).plan(problem, PlanningRequest(effort_s=0.0))
    assert result.plan_net is not None, result.reason
    assert result.plan_net.robots == ("yard_2",)
    for goal in ("near(yard_2, door_2)", "near(yard_1, door_1)"):
        problem = planning_problem(store.world, facts, [store.fact(goal)], reserved=reserved)
        refused = HierarchicalEngine(base).plan(problem, PlanningRequest(effort_s=0.0))
        assert refused.status is PlanningStatus.UNSOLVABLE
