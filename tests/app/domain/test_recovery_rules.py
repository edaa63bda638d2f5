"""The rules of recovery: what has befallen a mission, who is left out, what an operator decides on."""

from dataclasses import replace

import pytest

from app.domain.recovery_rules import (
    LeftOut,
    Measure,
    Policy,
    Trouble,
    category_of,
    has_failed_at,
    left_out,
    measure_of,
    needs_decision,
    policy_for,
)
from app.domain.tender_document import LegBody
from planner.repair import Course
from robots.wire import FailureCategory
from tests.app.sample_store import Store, said

STORE = Store()
ROBOT, WORLD, LOST = (
    FailureCategory.ROBOT,
    FailureCategory.WORLD_CHANGED,
    FailureCategory.UNREACHABLE,
)


def trouble(
    robot: str = "yard_1", category: FailureCategory = ROBOT, *, tag: str = "DOCK", fit: bool = True
) -> Trouble:
    return Trouble(robot=robot, category=category, detail="the gripper does not close", tag=tag, fit=fit)


@pytest.mark.parametrize(
    ("wish", "auto_approve", "policy"),
    [
        (None, True, Policy.AUTO),
        (None, False, Policy.ASK),
        ("ask", True, Policy.ASK),
        ("never", True, Policy.NEVER),
        ("auto", False, Policy.AUTO),
    ],
)
def test_who_wanted_to_see_the_plan_sees_its_repairs_unless_configured_otherwise(
    wish: str | None, auto_approve: bool, policy: Policy
) -> None:
    assert policy_for(wish, auto_approve=auto_approve) is policy


def test_what_a_robot_fails_at_is_tried_again_once_and_then_left_out() -> None:
    assert left_out([trouble("yard_1"), trouble("store_2"), trouble("yard_1", tag="NAVIGATE")]) == LeftOut()
    twice = left_out([trouble("yard_1"), trouble("store_2"), trouble("yard_1")])
    assert twice == LeftOut(packets=frozenset({("yard_1", "DOCK")}))
    assert twice.words == ("DOCK by yard_1",)


def test_a_door_that_does_not_open_and_then_does_not_stay_open_has_failed_twice() -> None:
    both = left_out(
        [trouble("gate_1", tag="OPEN"), trouble("gate_1", tag="CLOSE"), trouble("gate_2", tag="OPEN")]
    )
    assert both.packets == {("gate_1", "OPEN"), ("gate_1", "CLOSE")}


def test_a_robot_that_waits_in_vain_for_another_has_not_failed_itself() -> None:
    waited = replace(trouble("store_2"), waited=True)
    assert left_out([waited, waited, trouble("yard_1")]) == LeftOut()
    assert Trouble.from_json(waited.to_json()) == waited


def test_a_robot_of_which_nobody_knows_what_it_fails_at_is_left_out_altogether() -> None:
    assert left_out([trouble(tag=""), trouble(tag="")]) == LeftOut(robots=frozenset({"yard_1"}))


def test_a_robot_that_refuses_or_is_lost_is_left_out_at_once() -> None:
    assert left_out([trouble("yard_1", fit=False), trouble("store_2")]).robots == {"yard_1"}


def test_a_packet_that_is_left_out_cannot_be_planned_others_of_its_robot_can() -> None:
    facts = STORE.facts
    kept = LeftOut(packets=frozenset({("yard_1", "DOCK")})).remove_from(facts)
    assert facts - kept == {STORE.fact("can(yard_1, DOCK)")}


def test_only_what_a_plan_is_carried_out_with_concerns_it() -> None:
    net = STORE.store_sample_1()
    assert LeftOut(packets=frozenset({("yard_1", "DOCK")})).concerns(net)
    assert LeftOut(robots=frozenset({"store_2"})).concerns(net)
    assert not LeftOut(packets=frozenset({("yard_2", "DOCK")}), robots=frozenset({"store_1"})).concerns(net)


def test_silence_is_what_a_mission_failed_of_even_if_another_robot_failed_too() -> None:
    assert category_of([trouble(category=ROBOT), trouble("yard_2", LOST)]) is LOST
    assert category_of([trouble(category=WORLD), trouble("yard_2", ROBOT)]) is WORLD


def test_without_a_robots_trouble_it_is_the_world_that_has_changed() -> None:
    assert category_of([]) is WORLD


def test_the_rest_of_an_approved_plan_needs_no_new_decision_a_change_of_it_does() -> None:
    assert measure_of(Course.KEPT, without=False) is Measure.RETRY
    assert not needs_decision(Policy.ASK, Measure.RETRY)
    for course, without in ((Course.MENDED, False), (Course.REPLANNED, False), (Course.KEPT, True)):
        measure = measure_of(course, without=without)
        assert needs_decision(Policy.ASK, measure)
        assert not needs_decision(Policy.AUTO, measure)


def test_what_is_answered_speaks_against_a_robot_no_more() -> None:
    answered = replace(trouble(), answered=True)
    assert left_out([answered, trouble()]) == LeftOut()
    assert left_out([answered, trouble(), trouble()]).packets == {("yard_1", "DOCK")}
    lost = trouble(category=LOST, tag="", fit=False)
    assert left_out([replace(lost, answered=True)]) == LeftOut()


def test_a_correction_answers_troubles_of_what_it_names_but_finds_no_lost_robot() -> None:
    docking = replace(trouble(), about=("sample_1", "door_1"))
    assert docking.is_answered_by({"sample_1", "bay_3"})
    assert docking.is_answered_by({"yard_1"})
    assert not docking.is_answered_by({"sample_2", "yard_2"})
    assert not replace(trouble(category=LOST, tag="", fit=False), about=()).is_answered_by({"yard_1"})


def test_a_trouble_comes_back_from_the_record_as_it_was() -> None:
    one = replace(trouble(category=LOST, fit=False), script="script-1", about=("sample_1",), answered=True)
    assert Trouble.from_json(one.to_json()) == one


def test_a_robot_has_failed_at_the_leg_that_its_trouble_was_about() -> None:
    def leg(sample: str) -> LegBody:
        return LegBody(id=sample, goal=said(f"in({sample}, bay_7)"), parts=())

    dropped = replace(trouble(), about=("sample_1", "door_1"))
    assert has_failed_at([dropped], leg("sample_1"), "yard_1")
    assert not has_failed_at([dropped], leg("sample_2"), "yard_1")
    assert not has_failed_at([dropped], leg("sample_1"), "yard_2")
    assert has_failed_at([trouble()], leg("sample_2"), "yard_1"), "it is not known at what it failed"
    assert has_failed_at([replace(dropped, fit=False)], leg("sample_2"), "yard_1"), (
        "it cannot be used any longer"
    )
    assert not has_failed_at([replace(dropped, waited=True)], leg("sample_1"), "yard_1")
    assert not has_failed_at([replace(dropped, answered=True)], leg("sample_1"), "yard_1")
