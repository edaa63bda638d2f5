"""Structured goals against a world and its facts."""

import pytest

from app.domain.goal_language.check import GoalIssue, blocking, check_goals
from app.domain.world_model import Facts, revise_beliefs
from robots.world import RobotSpec, WorldFile
from robots.world.parts import STORE_TAGS
from tests.app.laboratory import Laboratory, lab_with
from tests.app.sample_store import Store, said

STORE = Store()


def issues(*goals: str, facts: Facts | None = None, store: Store = STORE) -> tuple[GoalIssue, ...]:
    known = store.facts if facts is None else facts
    return check_goals([said(goal) for goal in goals], store.world, known, store.base)


def only(*goals: str, facts: Facts | None = None, store: Store = STORE) -> GoalIssue:
    found = issues(*goals, facts=facts, store=store)
    assert len(found) == 1, found
    return found[0]


def without(predicate: str, *start: str) -> Facts:
    return frozenset(
        f for f in STORE.facts if not (f.predicate == predicate and f.args[: len(start)] == start)
    )


@pytest.mark.parametrize(
    "goals",
    [
        ["in(sample_1, bay_7)"],
        ["in(sample_2, door_2)"],
        ["in(sample_1, bay_7)", "in(sample_4, door_2)"],
        ["in(sample_1, yard_1)"],
        ["near(yard_1, door_1)"],
        ["tracked(yard_1, yard_2)"],
    ],
)
def test_nothing_stands_against_goals_that_can_be_achieved(goals: list[str]) -> None:
    assert issues(*goals) == ()


def test_a_sample_is_offered_places_that_hold_one_and_a_robot_all() -> None:
    assert "home_yard_1" not in only("in(sample_1, home_77)").choices
    assert "home_yard_1" in only("near(yard_1, home_77)").choices


def test_the_samples_and_places_of_a_good_goal_may_be_swapped() -> None:
    assert issues("in(sample_1, bay_2)", "in(sample_2, door_1)") == ()


@pytest.mark.parametrize(
    ("goal", "code", "thing", "first_choice"),
    [
        ("in(sample_9, bay_7)", "unknown-sample", "sample_9", "sample_4"),
        ("in(sample_1, bay_70)", "unknown-place", "bay_70", "bay_7"),
        ("near(yard_9, door_1)", "unknown-robot", "yard_9", "yard_2"),
        ("near(yard_1, door_9)", "unknown-place", "door_9", "door_2"),
        ("inn(sample_1, bay_7)", "unknown-predicate", "inn", "in"),
    ],
)
def test_unknown_names_are_named_with_the_choices(
    goal: str, code: str, thing: str, first_choice: str
) -> None:
    issue = only(goal)
    assert (issue.code, issue.kind, issue.thing) == (code, "invalid", thing)
    assert thing in issue.detail
    assert issue.choices[0] == first_choice


@pytest.mark.parametrize("goal", ["in(sample_1)", "in(sample_1, bay_7, bay_8)", "tracked(yard_1, bay_1)"])
def test_goals_of_the_wrong_shape_are_malformed(goal: str) -> None:
    issue = only(goal)
    assert (issue.code, issue.kind) == ("malformed-goal", "invalid")


@pytest.mark.parametrize("goal", ["vacant(bay_7)", "clear(bay_7, aisle_2)", "reaches(yard_1, bay_7)"])
def test_what_no_action_intends_is_no_goal(goal: str) -> None:
    issue = only(goal)
    assert (issue.code, issue.kind) == ("goal-not-intended", "invalid")
    assert "object_position" in issue.choices


def test_a_home_holds_no_samples() -> None:
    issue = only("in(sample_1, home_yard_1)")
    assert (issue.code, issue.kind) == ("place-holds-no-samples", "invalid")
    assert "bay_7" in issue.choices


def test_an_occupied_place_is_named_with_what_lies_there_and_the_free_ones() -> None:
    issue = only("in(sample_1, bay_5)")
    assert (issue.code, issue.kind, issue.thing) == ("place-occupied", "conflict", "bay_5")
    assert "sample_3" in issue.detail
    assert "bay_4" in issue.choices
    assert not {"bay_5", "bay_2", "home_yard_1"} & set(issue.choices)


def test_a_place_stays_occupied_by_a_sample_that_is_to_stay_there() -> None:
    codes = {issue.code for issue in issues("in(sample_1, bay_5)", "in(sample_3, bay_5)")}
    assert "place-occupied" in codes


def test_a_place_that_no_robot_can_carry_to_is_unreachable() -> None:
    issue = only("in(sample_1, bay_7)", facts=without("can", "store_2", "DOCK"))
    assert (issue.code, issue.kind, issue.thing) == ("place-unreachable", "conflict", "bay_7")


def test_a_broken_chain_of_robots_is_distinguished_from_an_unreachable_place() -> None:
    facts = without("reaches", "yard_1", "interchange_2") & without("reaches", "yard_2", "interchange_2")
    issue = only("in(sample_1, bay_7)", facts=facts)
    assert (issue.code, issue.kind) == ("no-chain-of-robots", "conflict")
    assert "bay_1" in issue.choices
    assert "bay_8" not in issue.choices
    assert issues("in(sample_1, bay_1)", facts=facts) == ()


def test_robots_do_not_hand_on_at_places_that_hold_no_samples() -> None:
    layout = STORE.world.model_dump()
    locations = [
        {**place, "capacity": 0} if place["kind"] == "interchange" else place for place in layout["locations"]
    ]
    store = Store(WorldFile.model_validate({**layout, "locations": locations}))
    assert only("in(sample_1, bay_7)", store=store).code == "no-chain-of-robots"


def test_a_sample_in_a_gripper_starts_from_what_its_holder_reaches() -> None:
    held = revise_beliefs(STORE.facts, [STORE.fact("in(sample_1, store_1)")])
    assert issues("in(sample_1, bay_1)", facts=held) == ()


def test_a_lost_sample_cannot_be_carried() -> None:
    facts = revise_beliefs(STORE.facts, [], gone=[STORE.fact("in(sample_1, door_1)")])
    issue = only("in(sample_1, bay_7)", facts=facts)
    assert (issue.code, issue.kind, issue.thing) == ("sample-lost", "conflict", "sample_1")


def test_a_robot_is_sent_only_where_it_reaches() -> None:
    issue = only("near(yard_1, bay_7)")
    assert (issue.code, issue.kind) == ("place-unreachable", "invalid")
    assert "door_1" in issue.choices


def test_two_samples_do_not_go_to_one_place() -> None:
    issue = only("in(sample_1, bay_7)", "in(sample_2, bay_7)")
    assert (issue.code, issue.kind, issue.thing) == ("two-goals-for-one-place", "invalid", "bay_7")
    assert "sample_1 and sample_2" in issue.detail


def test_one_sample_does_not_go_to_two_places() -> None:
    issue = only("in(sample_1, bay_7)", "in(sample_1, bay_8)")
    assert (issue.code, issue.kind, issue.thing) == ("one-thing-in-two-places", "invalid", "sample_1")


def test_a_goal_that_is_true_already_is_only_noted() -> None:
    issue = only("in(sample_2, bay_2)")
    assert (issue.code, issue.kind) == ("already-true", "note")
    assert blocking([issue]) == ()


def test_every_goals_issues_are_reported_at_once() -> None:
    codes = [issue.code for issue in issues("in(sample_9, bay_7)", "in(sample_1, bay_5)")]
    assert codes == ["unknown-sample", "place-occupied"]


def test_no_goal_at_all_is_invalid() -> None:
    assert [(issue.code, issue.kind) for issue in issues()] == [("goal-needed", "invalid")]


def lab_issue(*robots: RobotSpec) -> GoalIssue:
    """What stands against relocating the rock sample with these robots."""
    return only("in(rock_sample, lander)", store=Laboratory(lab_with(robots=robots)))


def test_two_robots_that_carry_together_can_relocate_a_long_sample() -> None:
    assert issues("in(rock_sample, lander)", store=Laboratory()) == ()


def test_a_long_sample_takes_two_robots_and_the_lack_is_named() -> None:
    fred, ginger = Laboratory().world.robots
    issue = lab_issue(fred)
    assert (issue.code, issue.kind, issue.thing) == ("too-few-robots", "conflict", "rock_sample")
    assert issue.detail == "rock_sample takes two robots that can TRANSPORT, in lab there is only fred"
    weak = ginger.model_copy(update={"repertoire": ("NAVIGATE", "TRACK")})
    assert lab_issue(fred, weak).detail == issue.detail


def test_two_robots_that_cannot_grip_it_one_after_the_other_are_reported_with_what_they_lack() -> None:
    plain = tuple(tag for tag in STORE_TAGS if tag not in ("DOCK2", "RELEASE1"))
    robots = [robot.model_copy(update={"repertoire": plain}) for robot in Laboratory().world.robots]
    assert lab_issue(*robots).detail == (
        "rock_sample takes two robots, and none of fred and ginger can DOCK2 or RELEASE1"
    )
