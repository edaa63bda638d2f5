"""How news revises beliefs."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.domain.world_model import Facts, apply_action, belief_change, revise_beliefs
from planner import Fact
from tests.app.sample_store import Store

STORE = Store()
FACTS = STORE.facts
ROBOTS = ("yard_1", "store_1", "store_2")
SAMPLES = ("sample_1", "sample_2", "sample_9")
PLACES = ("door_1", "bay_2", "bay_7", "interchange_1")

news = st.one_of(
    st.builds(
        lambda o, r: Fact("object_position", (o, "in", r)), st.sampled_from(SAMPLES), st.sampled_from(PLACES)
    ),
    st.builds(
        lambda o, r: Fact("object_position", (o, "in", r)), st.sampled_from(SAMPLES), st.sampled_from(ROBOTS)
    ),
    st.builds(
        lambda r, v: Fact("robot_attribute", (r, "gripper", v)),
        st.sampled_from(ROBOTS),
        st.sampled_from(("empty", "full")),
    ),
    st.builds(
        lambda r, rel, p: Fact("robot_position", (r, rel, p)),
        st.sampled_from(ROBOTS),
        st.sampled_from(("near", "at")),
        st.sampled_from(PLACES),
    ),
    st.builds(lambda p: Fact("vacant", (p,)), st.sampled_from(PLACES)),
)


def only(facts: Facts, predicate: str, *start: str) -> list[Fact]:
    return [f for f in facts if f.predicate == predicate and f.args[: len(start)] == start]


@given(st.lists(news, max_size=8))
def test_revised_beliefs_are_consistent_whatever_is_reported(told: list[Fact]) -> None:
    facts = revise_beliefs(FACTS, told)
    in_places = [f for f in only(facts, "object_position") if f.args[2] not in ROBOTS]
    held = {f.args[2]: f.args[0] for f in only(facts, "object_position") if f.args[2] in ROBOTS}
    for robot in ROBOTS:
        assert len(only(facts, "robot_position", robot)) == 1
        assert len(only(facts, "robot_attribute", robot, "gripper")) == 1
        if robot in held:
            assert Fact("robot_attribute", (robot, "gripper", "full")) in facts
    assert len({f.args[0] for f in in_places}) == len({f.args[2] for f in in_places}) == len(in_places)
    assert not {f.args[0] for f in in_places} & set(held.values())
    for place in PLACES:
        filled = any(f.args[2] == place for f in in_places)
        assert (Fact("vacant", (place,)) in facts) == (not filled)


@given(st.lists(news, max_size=8))
def test_the_latest_report_holds(told: list[Fact]) -> None:
    assert all(fact in revise_beliefs(FACTS, told) for fact in told[-1:])


@given(st.lists(news, max_size=8))
def test_a_revision_is_what_leads_to_the_revised_beliefs(told: list[Fact]) -> None:
    assert belief_change(FACTS, told).apply(FACTS) == revise_beliefs(FACTS, told)


def test_beliefs_without_a_report_stay_as_they_are() -> None:
    assert revise_beliefs(FACTS, []) == FACTS


def test_a_sample_taken_elsewhere_leaves_its_place_vacant_and_its_holders_gripper_empty() -> None:
    held = revise_beliefs(FACTS, [STORE.fact("in(sample_1, yard_1)")])
    assert {Fact("vacant", ("door_1",)), Fact("robot_attribute", ("yard_1", "gripper", "full"))} <= held
    put = revise_beliefs(held, [STORE.fact("in(sample_1, door_2)")])
    assert Fact("robot_attribute", ("yard_1", "gripper", "empty")) in put
    assert Fact("vacant", ("door_2",)) not in put


def test_two_robots_may_hold_one_object_between_them() -> None:
    facts = revise_beliefs(FACTS, [STORE.fact("in(sample_1, yard_1)"), STORE.fact("in(sample_1, yard_2)")])
    assert len(only(facts, "object_position", "sample_1")) == 2


def test_a_gripper_said_to_be_full_of_something_unknown_stays_full() -> None:
    full = Fact("robot_attribute", ("yard_1", "gripper", "full"))
    assert full in revise_beliefs(revise_beliefs(FACTS, [full]), [STORE.fact("in(sample_2, bay_1)")])


def test_a_place_is_clear_once_its_robot_has_gone() -> None:
    gone = revise_beliefs(FACTS, [STORE.fact("near(yard_1, door_1)")])
    assert Fact("clear", ("home_yard_1", "yard")) in gone
    assert Fact("clear", ("door_1", "yard")) not in gone


def test_actions_applied_in_their_order_make_the_goal_true() -> None:
    net = STORE.store_sample_1()
    facts = FACTS
    for action in sorted(net.actions, key=lambda action: action.earliest_start_s):
        assert set(action.preconditions) <= facts, action.id
        facts = apply_action(facts, action)
        assert not set(action.deletes) & facts
    assert set(net.goals) <= facts


def test_an_action_applied_overrules_what_a_correction_left_behind() -> None:
    net = STORE.store_sample_1()
    release = next(
        action for action in net.actions if action.tag == "RELEASE2" and "store_2" in action.agents
    )
    wrong = revise_beliefs(FACTS, [STORE.fact("in(sample_1, bay_8)")])
    assert [f.args[2] for f in only(apply_action(wrong, release), "object_position", "sample_1")] == ["bay_7"]


@pytest.mark.parametrize("wrong", ["in(sample_1, bay_8)", "near(yard_1, door_2)"])
def test_what_is_gone_is_no_longer_believed(wrong: str) -> None:
    fact = STORE.fact(wrong)
    believed = revise_beliefs(FACTS, [fact])
    assert fact not in revise_beliefs(believed, [], gone=[fact])
