"""Preferences in sentences: constraints after "preferably", each with what breaking it costs."""

import pytest

from app.domain.goal_language.check import preference_conflicts
from app.domain.goal_language.completion import completions
from app.domain.goal_language.constraints import DEFAULT_COST_S, Constraints, StatedPreference
from app.domain.goal_language.grammar import Clarification, Understood, understand
from planner import Fact
from robots.wire import SymbolicFact
from tests.app.sample_store import Store

STORE = Store()
MOVE = "move sample_1 to bay_7"


def understood(text: str) -> Understood:
    found = understand(text, STORE.world, STORE.facts)
    assert isinstance(found, Understood), found
    return found


def asked(text: str) -> Clarification:
    found = understand(text, STORE.world, STORE.facts)
    assert isinstance(found, Clarification), found
    return found


def preferences(text: str) -> list[tuple[str, float]]:
    return [(one.words, one.cost_s) for one in understood(text).constraints.preferences]


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        ("preferably without yard_1", [("without yard_1", DEFAULT_COST_S)]),
        ("ideally not with yard_1 (cost 5 s)", [("without yard_1", 5.0)]),
        ("preferably without yard_1 and yard_2, cost 5", [("without yard_1 and yard_2", 5.0)]),
        (
            "preferably without yard_1 (cost 5) and preferably with store_2 and yard_2 (cost half minute)",
            [("without yard_1", 5.0), ("only with store_2 and yard_2", 30.0)],
        ),
        (
            "preferably avoiding bay_1 preferably avoiding bay_1 (cost 5)",
            [("avoiding bay_1", 60.0), ("avoiding bay_1", 5.0)],
        ),
        ("preferably without any robot of the yard (cost 5)", [("without yard_1 and yard_2", 5.0)]),
    ],
)
def test_what_is_preferred_and_what_it_costs(said: str, expected: list[tuple[str, float]]) -> None:
    found = preferences(f"{MOVE} {said}")
    assert found == [(f"preferably {words}", cost_s) for words, cost_s in expected]
    first = preferences(f"{said}, {MOVE}")
    assert first == found, "wherever it stands"


def test_a_preference_beside_a_constraint_leaves_it_required() -> None:
    constraints = understood(f"{MOVE} without store_1 preferably without yard_1, avoiding bay_1").constraints
    assert (constraints.without, constraints.avoid) == (("store_1",), ("bay_1",))
    assert [one.without for one in constraints.preferences] == [("yard_1",)]
    assert constraints.words == ("without store_1", "avoiding bay_1"), (
        "a preference is no reason for having no plan"
    )


def test_a_way_that_is_preferred_avoids_the_others_at_a_cost() -> None:
    assert preferences(f"{MOVE} preferably via interchange_2 (cost 9)") == [
        ("preferably avoiding interchange_1", 9.0)
    ]
    assert preferences(f"{MOVE} preferably via interchange_1 and interchange_2") == [], (
        "there is no other way"
    )


def test_robots_of_a_verb_with_a_partner_may_be_preferred() -> None:
    swapped = understood("swap sample_1 and sample_2 preferably with yard_1")
    assert len(swapped.goals) == 2
    assert [one.robots for one in swapped.constraints.preferences] == [("yard_1",)]


def test_any_bay_is_chosen_within_preferences_if_there_is_one() -> None:
    assert (
        str(understood("move sample_1 to any bay preferably avoiding bay_1").goals[0])
        == "in(sample_1, bay_3)"
    )
    free = [
        fact.args[0] for fact in STORE.facts if fact.predicate == "vacant" and fact.args[0].startswith("bay")
    ]
    everywhere = " and ".join(free)
    assert (
        str(understood(f"move sample_1 to any bay preferably avoiding {everywhere}").goals[0])
        == "in(sample_1, bay_1)"
    )


@pytest.mark.parametrize(
    ("said", "code", "choice"),
    [
        ("(cost 5)", "goal-not-understood", "preferably"),
        ("avoiding bay_1 (cost 5)", "goal-not-understood", "preferably"),
        ("preferably without yard_1 (cost 0)", "cost-needed", "cost 60"),
        ("preferably without yard_1 (cost 5) (cost 6)", "goal-not-understood", "preferably"),
        ("preferably by 14:30", "goal-not-understood", "without"),
        ("preferably without bay_1", "unknown-robot", "yard_1"),
        ("preferably via door_1", "no-interchange", "interchange_1"),
        ("and preferably keep bay_3 empty for ten minutes", "goal-not-understood", ""),
    ],
)
def test_what_is_not_understood_of_a_preference_is_asked(said: str, code: str, choice: str) -> None:
    question = asked(f"{MOVE} {said}")
    assert question.code == code
    assert question.span is not None
    assert not choice or choice in question.choices


def test_preferably_and_what_may_follow_it_are_completed() -> None:
    def completed(text: str) -> tuple[str, ...]:
        return completions(text, asked(text), STORE.world, STORE.facts)

    assert completed(f"{MOVE} pref") == (f"{MOVE} preferably",)
    assert f"{MOVE} preferably without" in completed(f"{MOVE} preferably")
    assert f"{MOVE} preferably without yard_2" in completed(f"{MOVE} preferably without")


def test_preferences_that_no_plan_can_keep_are_told_one_by_one() -> None:
    constraints = understood(
        "send yard_2 to door_2 preferably without yard_2 preferably without yard_1 preferably avoiding door_2"
    ).constraints
    goals = (SymbolicFact(predicate="near", args=("yard_2", "door_2")),)
    first, second, third = preference_conflicts(goals, constraints, STORE.world, STORE.facts, STORE.base)
    assert first == "near(yard_2, door_2) needs yard_2, which is not to act"
    assert second == ""
    assert third == "near(yard_2, door_2) is at door_2, which is to be avoided"


def test_both_goals_preferences_are_kept_once() -> None:
    one = Constraints(preferences=(StatedPreference(without=("yard_1",)),))
    other = Constraints(
        preferences=(StatedPreference(without=("yard_1",)), StatedPreference(avoid=("bay_1",)))
    )
    assert one.and_also(other).preferences == other.preferences
    assert [
        rest.preferences for rest in Constraints(avoid=("bay_2",)).and_also(other).without_each().values()
    ] == [other.preferences]


def test_the_planner_is_told_which_facts_a_preference_withholds() -> None:
    stated = Constraints(
        preferences=(
            StatedPreference(without=("yard_1",)),
            StatedPreference(keep_empty=("bay_2",), cost_s=7.0),
        )
    )
    robot, place = stated.preferences_in(STORE.world, STORE.facts)
    assert {fact.predicate for fact in robot.withheld} >= {"can", "in_area"}
    assert all(fact.args[0] == "yard_1" for fact in robot.withheld)
    assert (place.cost_s, place.withheld) == (7.0, frozenset({Fact("vacant", ("bay_2",))}))
    assert Fact("vacant", ("bay_2",)) not in STORE.facts, (
        "it is withheld once the plan has emptied the place, too"
    )
