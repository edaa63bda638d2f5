"""What is believed when a script ended before its time."""

from app.domain.world_model import Facts, planning_problem, reconcile_report, revise_beliefs
from benchmarks.planner.timed_store import timed_store
from planner import Fact
from tests.app.laboratory import Laboratory
from tests.app.sample_store import Store, said

STORE = Store()
EMPTY = "robot_attribute(yard_1, gripper, empty)"
FULL = "robot_attribute(yard_1, gripper, full)"


def after(facts: Facts, *perceived: str, robot: str = "yard_1") -> Facts:
    return reconcile_report(facts, robot, [said(text) for text in perceived], STORE.base).apply(facts)


def holding() -> Facts:
    carried = Fact("transported", ("sample_1", "yard_1", "at", "door_1", "near", "interchange_2"))
    return revise_beliefs(STORE.facts, [STORE.fact("in(sample_1, yard_1)"), carried])


def test_a_robot_that_is_at_no_known_place_stands_at_its_spot() -> None:
    facts = after(STORE.facts, EMPTY)
    assert Fact("robot_position", ("yard_1", "near", "yard_1_spot")) in facts
    assert Fact("clear", ("home_yard_1", "yard")) in facts


def test_a_robot_stands_where_it_says() -> None:
    facts = after(STORE.facts, EMPTY, "near(yard_1, door_1)")
    assert Fact("robot_position", ("yard_1", "near", "door_1")) in facts
    assert Fact("clear", ("door_1", "yard")) not in facts


def test_what_it_holds_stays_in_its_gripper_and_the_transport_is_given_up() -> None:
    facts = after(holding(), FULL, "in(sample_1, yard_1)")
    assert STORE.fact("in(sample_1, yard_1)") in facts
    assert Fact("robot_attribute", ("yard_1", "gripper", "full")) in facts
    assert not [f for f in facts if f.predicate == "transported"]


def test_a_robot_that_gripped_before_it_could_say_so_holds_the_sample_now() -> None:
    facts = after(STORE.facts, FULL, "in(sample_1, yard_1)", "at(yard_1, door_1)")
    assert STORE.fact("in(sample_1, yard_1)") in facts
    assert Fact("vacant", ("door_1",)) in facts
    assert Fact("robot_position", ("yard_1", "at", "door_1")) in facts


def test_a_sample_that_it_dropped_at_a_place_lies_there() -> None:
    facts = after(holding(), "in(sample_1, interchange_2)", EMPTY)
    assert STORE.fact("in(sample_1, interchange_2)") in facts
    assert Fact("vacant", ("interchange_2",)) not in facts


def test_a_sample_that_it_dropped_anywhere_else_is_lost_and_said_to_be() -> None:
    change = reconcile_report(holding(), "yard_1", [said(EMPTY)], STORE.base)
    facts = change.apply(holding())
    assert not [f for f in facts if f.predicate == "object_position" and f.args[0] == "sample_1"]
    assert change.notes == ("sample_1 is lost: yard_1 does not hold it any longer",)


def test_a_lost_sample_is_found_again() -> None:
    lost = after(holding(), EMPTY)
    assert STORE.fact("in(sample_1, door_2)") in after(lost, EMPTY, "in(sample_1, door_2)")


def test_what_a_robot_says_of_another_is_not_taken() -> None:
    facts = after(STORE.facts, EMPTY, "in(sample_1, yard_2)", "near(yard_2, door_2)")
    assert STORE.fact("in(sample_1, door_1)") in facts
    assert Fact("robot_position", ("yard_2", "near", "home_yard_2")) in facts


def test_a_robot_with_an_empty_gripper_at_a_place_can_drive_off_from_near_it() -> None:
    facts = after(STORE.facts, EMPTY, "at(yard_1, door_2)")
    assert [f.args for f in facts if f.predicate == "robot_position" and f.args[0] == "yard_1"] == [
        ("yard_1", "near", "door_2")
    ]


def test_of_two_places_that_a_robot_says_it_stands_at_the_last_counts() -> None:
    facts = after(STORE.facts, EMPTY, "near(yard_1, door_1)", "at(yard_1, door_2)")
    assert [f.args for f in facts if f.predicate == "robot_position" and f.args[0] == "yard_1"] == [
        ("yard_1", "near", "door_2")
    ]


def test_percepts_outside_the_vocabulary_are_left_out_and_noted() -> None:
    change = reconcile_report(STORE.facts, "yard_1", [said("under(sample_1, bay_1)")], STORE.base)
    assert "under(sample_1, bay_1)" in change.notes[0]
    assert {f.predicate for f in change.add} == {"robot_position", "clear"}


def test_two_that_hold_an_object_between_them_stand_where_they_may_carry_it_on() -> None:
    lab = Laboratory()
    carried = revise_beliefs(
        lab.facts, [lab.fact(f"in(rock_sample, {robot})") for robot in ("fred", "ginger")]
    )
    for robot in ("fred", "ginger"):
        holds = [said(f"robot_attribute({robot}, gripper, full)"), said(f"in(rock_sample, {robot})")]
        carried = reconcile_report(carried, robot, holds, lab.base).apply(carried)
    way = {"rel1": "near", "ref1": "fred_spot", "rel2": "near", "ref2": "lander", "area": "lab"}
    arguments = {"object": "rock_sample", "robots": "fred+ginger", **way}
    problem = planning_problem(lab.world, carried, ())
    transport = lab.base.ground("TRANSPORT", arguments, problem.functions, objects=problem.objects)
    assert set(transport.preconditions) <= problem.facts


def test_who_dropped_its_end_stands_at_its_own_spot() -> None:
    lab = Laboratory()
    both = [lab.fact(f"in(rock_sample, {robot})") for robot in ("fred", "ginger")]
    carried = revise_beliefs(lab.facts, [*both, lab.fact("near(fred, fred_spot)")])
    dropped = reconcile_report(carried, "ginger", [said("robot_attribute(ginger, gripper, empty)")], lab.base)
    assert lab.fact("near(ginger, ginger_spot)") in dropped.apply(carried)


def test_a_sample_that_is_not_seen_where_it_should_lie_is_lost() -> None:
    change = reconcile_report(STORE.facts, "yard_1", [said("vacant(door_1)"), said(EMPTY)], STORE.base)
    facts = change.apply(STORE.facts)
    assert not [f for f in facts if f.predicate == "object_position" and f.args[0] == "sample_1"]
    assert Fact("vacant", ("door_1",)) in facts
    assert "sample_1 is lost: it is no longer in door_1" in change.notes


def test_a_place_that_holds_no_samples_is_not_vacant_either() -> None:
    facts = after(STORE.facts, "vacant(home_yard_1)", EMPTY)
    assert Fact("vacant", ("home_yard_1",)) not in facts


def test_what_it_holds_where_it_has_brought_it_can_be_put_down_after_all() -> None:
    for stands in ("near(yard_1, interchange_2)", "at(yard_1, interchange_2)"):
        facts = after(holding(), FULL, "in(sample_1, yard_1)", stands)
        assert [f.args[5] for f in facts if f.predicate == "transported"] == ["interchange_2"]
        assert Fact("robot_position", ("yard_1", "near", "interchange_2")) in facts
    emptied = after(holding(), EMPTY, "in(sample_1, interchange_2)", "near(yard_1, interchange_2)")
    assert not [f for f in emptied if f.predicate == "transported"]


def test_two_that_hold_one_object_between_them_stand_in_one_place_however_each_sees_the_beacons() -> None:
    lab = Laboratory()
    held = revise_beliefs(lab.facts, [lab.fact("in(rock_sample, fred)"), lab.fact("in(rock_sample, ginger)")])
    by_fred = [said("at(fred, lander)"), said("robot_attribute(fred, gripper, full)")]
    by_ginger = [said("near(ginger, lander)"), said("robot_attribute(ginger, gripper, full)")]
    one = reconcile_report(held, "fred", by_fred, lab.base).apply(held)
    both = reconcile_report(one, "ginger", by_ginger, lab.base).apply(one)
    assert {lab.fact("near(fred, fred_spot)"), lab.fact("near(ginger, fred_spot)")} <= both


def test_a_robot_that_stops_between_two_phases_is_no_longer_under_way() -> None:
    store = Store(base=timed_store())
    way = ("yard_1", "near", "home_yard_1", "near", "door_1", "yard")
    begun = Fact("under_way_navigate_1", way)
    others = Fact("under_way_navigate_1", ("yard_2", *way[1:]))
    stands = store.fact("near(yard_1, home_yard_1)")
    facts = revise_beliefs(store.facts, [begun, others], gone=[stands])
    assert begun in facts
    stopped = reconcile_report(facts, "yard_1", [said("near(yard_1, door_1)"), said(EMPTY)], store.base)
    assert begun in stopped.remove
    assert others in stopped.apply(facts)
    assert store.fact("near(yard_1, door_1)") in stopped.apply(facts)
