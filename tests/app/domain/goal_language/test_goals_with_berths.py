"""A location with several berths as a goal: any berth will do, and which one is settled before anything is planned."""

from collections.abc import Collection

import pytest

from app.domain.goal_language.berth_choice import assign_berths
from app.domain.goal_language.check import GoalIssue, blocking, check_goals
from app.domain.goal_language.grammar import Clarification, parse_goal
from app.domain.world_model import Facts, revise_beliefs
from tests.app.berthed_store import berthed_store
from tests.app.sample_store import Store, said

STORE = Store(berthed_store())


def laid(*facts: str) -> Facts:
    """The initial facts with samples laid elsewhere."""
    return revise_beliefs(STORE.facts, [STORE.fact(fact) for fact in facts])


def chosen(
    *goals: str, facts: Facts = STORE.facts, preferred: Collection[str] = (), avoid: Collection[str] = ()
) -> list[str]:
    wanted = [said(goal) for goal in goals]
    return [str(goal) for goal in assign_berths(wanted, STORE.world, facts, preferred=preferred, avoid=avoid)]


def issues(*goals: str, facts: Facts = STORE.facts) -> tuple[GoalIssue, ...]:
    return check_goals([said(goal) for goal in goals], STORE.world, facts, STORE.base)


def test_a_free_berth_is_chosen() -> None:
    assert chosen("in(sample_1, bay_7)") == ["in(sample_1, bay_7_1)"]
    occupied = laid("in(sample_3, bay_7_1)")
    assert chosen("in(sample_1, bay_7)", facts=occupied) == ["in(sample_1, bay_7_2)"]


def test_goals_of_one_request_get_a_berth_each() -> None:
    goals = ("in(sample_1, bay_7)", "in(sample_2, bay_7)", "in(sample_3, bay_7_1)")
    assert chosen(*goals) == ["in(sample_1, bay_7_2)", "in(sample_2, bay_7_3)", "in(sample_3, bay_7_1)"]
    assert issues(*goals) == ()


def test_the_same_goal_twice_means_one_berth() -> None:
    assert len(set(chosen("in(sample_1, bay_7)", "in(sample_1, bay_7)"))) == 1
    assert set(chosen("in(sample_1, bay_7)", "in(sample_1, bay_7_3)")) == {"in(sample_1, bay_7_3)"}


def test_a_sample_that_lies_in_a_berth_stays_where_it_is() -> None:
    facts = laid("in(sample_3, bay_7_2)")
    assert chosen("in(sample_1, bay_7)", "in(sample_3, bay_7)", facts=facts)[1] == "in(sample_3, bay_7_2)"
    assert [issue.code for issue in issues("in(sample_3, bay_7)", facts=facts)] == ["already-true"]


def test_berths_of_the_last_plan_are_kept_and_those_that_others_aim_at_left_alone() -> None:
    assert chosen("in(sample_1, bay_7)", preferred=["bay_7_3"]) == ["in(sample_1, bay_7_3)"]
    assert chosen("in(sample_1, bay_7)", avoid=["bay_7_1"]) == ["in(sample_1, bay_7_2)"]
    every = ["bay_7_1", "bay_7_2", "bay_7_3"]
    assert chosen("in(sample_1, bay_7)", avoid=every) == ["in(sample_1, bay_7_1)"]


def test_robots_stand_near_a_berth_each_and_stay_where_they_stand() -> None:
    assert chosen("near(yard_1, bay_7)", "near(yard_2, bay_7)") == [
        "near(yard_1, bay_7_1)",
        "near(yard_2, bay_7_2)",
    ]
    there = laid("near(store_2, bay_7_3)")
    assert chosen("near(store_2, bay_7)", facts=there) == ["near(store_2, bay_7_3)"]


FULL = laid("in(sample_2, bay_7_1)", "in(sample_3, bay_7_2)", "in(sample_4, bay_7_3)")


def test_a_location_without_room_is_refused_with_who_lies_there() -> None:
    (issue,) = issues("in(sample_1, bay_7)", facts=FULL)
    assert (issue.code, issue.kind, issue.thing) == ("place-occupied", "conflict", "bay_7")
    assert issue.detail == (
        "bay_7 has no room for sample_1: its 3 berths are occupied by sample_2, sample_3 and sample_4"
    )
    assert "bay_2" in issue.choices
    assert "bay_7" not in issue.choices


def test_without_room_a_berth_is_named_that_no_other_goal_aims_at() -> None:
    facts = laid("in(sample_3, bay_2_2)", "in(sample_2, door_2)")
    assert chosen("in(sample_1, bay_2)", "in(sample_4, bay_2)", facts=facts) == [
        "in(sample_1, bay_2_1)",
        "in(sample_4, bay_2_2)",
    ]


def test_a_berth_that_another_goal_empties_has_room() -> None:
    goals = ("in(sample_1, bay_7)", "in(sample_3, door_2)")
    assert issues(*goals, facts=FULL) == ()
    assert chosen(*goals, facts=FULL)[0] == "in(sample_1, bay_7_2)"


def test_more_samples_than_berths_are_never_possible() -> None:
    found = blocking(issues("in(sample_1, bay_2)", "in(sample_2, bay_2)", "in(sample_3, bay_2)"))
    assert [(issue.code, issue.kind) for issue in found] == [("place-occupied", "invalid")]
    assert "its 2 berths are occupied by sample_2 and are wanted for sample_1" in found[0].detail


def test_of_a_location_without_room_unknown_samples_are_reported_first() -> None:
    assert [issue.code for issue in issues("in(sample_9, bay_7)", facts=FULL)] == ["unknown-sample"]


@pytest.mark.parametrize(
    ("text", "goal"),
    [
        ("move sample 1 to bay 7", "in(sample_1, bay_7)"),
        ("move sample_1 to bay_7_2", "in(sample_1, bay_7_2)"),
        ("move sample_1 to bay 1 2", "in(sample_1, bay_1_2)"),
        ("take sample_2 from bay_2 to door_2", "in(sample_2, door_2)"),
        ("take the sample in bay 2 to door 2", "in(sample_2, door_2)"),
        ("move sample_1 to bay12", "in(sample_1, bay_12)"),
    ],
)
def test_sentences_may_name_the_location_or_the_berth(text: str, goal: str) -> None:
    parsed = parse_goal(text, STORE.world, STORE.facts)
    assert parsed == (said(goal),)


def test_of_several_samples_in_a_location_the_operator_is_asked_which() -> None:
    facts = laid("in(sample_3, bay_2_2)")
    asked = parse_goal("take the sample in bay_2 to door_2", STORE.world, facts)
    assert isinstance(asked, Clarification)
    assert (asked.code, asked.choices) == ("sample-needed", ("sample_2", "sample_3"))


def test_places_are_offered_by_the_names_that_people_use() -> None:
    asked = parse_goal("store sample_1", STORE.world, STORE.facts)
    assert isinstance(asked, Clarification)
    assert {"bay_2", "bay_7"} <= set(asked.choices)
    assert not {"bay_7_1", "bay_5"} & set(asked.choices)
