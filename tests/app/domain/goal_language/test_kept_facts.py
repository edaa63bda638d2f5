"""Facts that are kept true: how they are said, what contradicts them, and what plans leave alone for their sake."""

from collections.abc import Sequence
from datetime import UTC, datetime

import pytest

from app.domain.goal_language.check import blocking, check_request
from app.domain.goal_language.completion import completions
from app.domain.goal_language.constraints import Constraints
from app.domain.goal_language.grammar import Clarification, Understood, understand
from app.domain.goal_language.hold_checks import goals_of_holds, held_issues, standing_conflicts
from app.domain.goal_language.kept_facts import HoldFact, achieves, contradicts, is_kept_true, kept_things
from app.domain.goal_language.stated_holds import HoldEnd, StandingHold, StatedHold
from robots.wire import SymbolicFact
from tests.app.berthed_store import berthed_store
from tests.app.sample_store import Store, said

STORE = Store()
BERTHED = Store(berthed_store())
NOW = datetime(2026, 3, 1, 14, 0, tzinfo=UTC)


def fact(text: str) -> HoldFact:
    return HoldFact.model_validate(said(text).model_dump())


def read(text: str, beside: Constraints | None = None) -> Understood:
    within = beside or Constraints()
    understood = understand(text, STORE.world, STORE.facts, now=NOW, beside=within)
    assert isinstance(understood, Understood), understood
    return understood


def asked(text: str) -> Clarification:
    question = understand(text, STORE.world, STORE.facts, now=NOW)
    assert isinstance(question, Clarification), question
    return question


def kept(text: str) -> list[tuple[list[str], str]]:
    """The facts that the holds of a sentence keep, with their ends."""
    return [([str(one) for one in hold.facts], hold.until.words) for hold in read(text).holds]


def standing(*facts: str, places: tuple[str, ...] = ()) -> StandingHold:
    words = " and ".join((*facts, *places))
    return StandingHold(id="h", places=frozenset(places), facts=tuple(map(fact, facts)), words=words)


def refused(text: str, *facts: str, places: tuple[str, ...] = ()) -> list[tuple[str, str]]:
    issues = held_issues([said(text)], [standing(*facts, places=places)], STORE.world, STORE.facts)
    return [(issue.code, issue.thing) for issue in issues]


HALF_PAST = "until 2026-03-01 14:30 UTC"
THREE = "until 2026-03-01 15:00 UTC"


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("keep sample_1 in bay_7 until 14:30", [(["in(sample_1, bay_7)"], HALF_PAST)]),
        ("until 14:30, keep the sample 1 in bay 7", [(["in(sample_1, bay_7)"], HALF_PAST)]),
        (
            "keep sample_1 in bay_7 and sample_2 in bay_3 until 14:30",
            [(["in(sample_1, bay_7)"], HALF_PAST), (["in(sample_2, bay_3)"], HALF_PAST)],
        ),
        (
            "keep sample_1 in bay_7 until 15:00 and yard_1 at door_1 until 14:30",
            [(["in(sample_1, bay_7)"], THREE), (["near(yard_1, door_1)"], HALF_PAST)],
        ),
        (
            "keep yard_1 and yard_2 at door_1 until 14:30",
            [(["near(yard_1, door_1)", "near(yard_2, door_1)"], HALF_PAST)],
        ),
        ("keep all samples of bay_2 in bay_2 until 14:30", [(["in(sample_2, bay_2)"], HALF_PAST)]),
        (
            "keep sample_1 in bay_7 until sample_2 is in door_2",
            [(["in(sample_1, bay_7)"], "until in(sample_2, door_2)")],
        ),
    ],
)
def test_a_hold_keeps_what_is_named_where_it_is_said(text: str, holds: list[tuple[list[str], str]]) -> None:
    assert kept(text) == holds


@pytest.mark.parametrize(
    ("text", "code", "at"),
    [
        ("keep sample_1", "place-needed", ""),
        ("keep yard_1 until 14:30", "place-needed", ""),
        ("keep sample_1 in", "place-needed", ""),
        ("keep sample_1 in bay_7", "goal-not-understood", ""),
        ("keep sample_9 in bay_7 for an hour", "unknown-sample", "sample_9"),
        ("keep sample_1 in bay_77 for an hour", "unknown-place", "bay_77"),
        ("keep sample_1 in any bay for an hour", "unknown-place", "any bay"),
        ("preferably keep sample_1 in bay_7 and move sample_2 to bay_3", "goal-not-understood", "preferably"),
        (
            "keep sample_1 in bay_7 to bay_3 for an hour",
            "goal-not-understood",
            "keep sample_1 in bay_7 to bay_3 for an hour",
        ),
        ("move sample_1 to bay_7, sample_2 to bay_3 until 14:30", "goal-not-understood", "until 14:30"),
    ],
)
def test_what_is_missing_or_wrong_is_asked(text: str, code: str, at: str) -> None:
    question = asked(text)
    assert question.span is not None
    assert (question.code, text[slice(*question.span)]) == (code, at)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("keep sample_1", "keep sample_1 in bay_7"),
        ("keep yard_1", "keep yard_1 at door_1"),
        ("keep sample_1 in", "keep sample_1 in bay_7"),
        ("keep sample_1 in bay_7", "keep sample_1 in bay_7 until"),
        ("keep sample_1 in bay_7 f", "keep sample_1 in bay_7 for"),
        ("keep yard_1 at door_1 for ten", "keep yard_1 at door_1 for ten minutes"),
    ],
)
def test_what_is_kept_is_completed(text: str, sentence: str) -> None:
    assert sentence in completions(text, asked(text), STORE.world, STORE.facts)


def test_a_sample_is_offered_places_that_hold_one_and_a_robot_all() -> None:
    assert "home_yard_1" not in asked("keep sample_1 in bay_77 for an hour").choices
    assert "home_yard_1" in asked("keep yard_1 at home_77 for an hour").choices


def test_without_an_end_it_is_a_constraint_of_the_goal() -> None:
    understood = read("keep sample_2 in bay_2 and move sample_1 to bay_7")
    assert understood.holds == ()
    assert understood.constraints.keep == (fact("in(sample_2, bay_2)"),)
    assert understood.constraints.words == ("keeping sample_2 in bay_2",)
    applied = understood.constraints.in_world(STORE.world)
    left = applied.applied_to(STORE.facts)
    assert STORE.facts - left == {STORE.fact("in(sample_2, bay_2)")}


def issues(text: str) -> list[tuple[str, str, str]]:
    understood = read(text)
    found = check_request(understood.goals, understood.constraints, STORE.world, STORE.facts, STORE.base)
    return [(issue.code, issue.kind, issue.thing) for issue in blocking(found)]


@pytest.mark.parametrize(
    ("text", "code", "kind", "thing"),
    [
        ("keep sample_2 in bay_3 and move sample_1 to bay_7", "fact-not-true", "conflict", "sample_2"),
        ("keep yard_1 at door_1 and move sample_1 to bay_7", "fact-not-true", "conflict", "yard_1"),
        (
            "keep sample_2 in bay_2 and move sample_2 to bay_7",
            "constraint-contradicts-goal",
            "invalid",
            "sample_2",
        ),
        (
            "keep sample_1 in bay_7 and move sample_2 to bay_7",
            "constraint-contradicts-goal",
            "invalid",
            "sample_1",
        ),
        (
            "keep yard_1 at home_yard_1 and send yard_1 to door_1",
            "constraint-contradicts-goal",
            "invalid",
            "yard_1",
        ),
        (
            "keep sample_2 in bay_2 and sample_2 in bay_3 and move sample_1 to bay_7",
            "constraint-contradicts-goal",
            "invalid",
            "sample_2",
        ),
    ],
)
def test_a_constraint_that_cannot_be_kept_is_refused(text: str, code: str, kind: str, thing: str) -> None:
    assert (code, kind, thing) in issues(text)


def test_a_goal_that_brings_the_fact_about_is_none_against_it() -> None:
    assert issues("move sample_1 to bay_7 and keep sample_1 in bay_7") == []
    assert issues("send yard_1 to door_1 and keep yard_1 at door_1 and move sample_1 to bay_7") == []


def test_choices_leave_alone_what_is_kept_and_the_place_that_is_kept_for_it() -> None:
    beside = Constraints(keep=(fact("in(sample_2, bay_2)"), fact("in(sample_4, bay_1)")))
    assert [str(goal) for goal in read("move any sample of aisle_1 to bay_7", beside).goals] == [
        "in(sample_3, bay_7)"
    ]
    assert [str(goal) for goal in read("move sample_1 to any bay", beside).goals] == ["in(sample_1, bay_3)"]
    staying = Constraints(keep=(fact("near(yard_1, home_yard_1)"),))
    assert [str(goal) for goal in read("park any robot of the yard", staying).goals] == [
        "near(yard_2, home_yard_2)"
    ]


@pytest.mark.parametrize(
    ("goal", "facts", "issue"),
    [
        ("in(sample_2, bay_3)", ("in(sample_2, bay_2)",), [("fact-held", "sample_2")]),
        ("in(sample_1, bay_7)", ("in(sample_2, bay_7)",), [("fact-held", "sample_1")]),
        ("near(yard_1, door_2)", ("near(yard_1, door_1)",), [("fact-held", "yard_1")]),
        ("in(sample_2, bay_2)", ("in(sample_2, bay_2)",), []),
        ("in(sample_1, bay_7)", ("in(sample_2, bay_2)", "near(yard_1, door_1)"), []),
        ("near(yard_2, door_1)", ("near(yard_1, door_1)",), []),
    ],
)
def test_a_goal_that_ends_a_kept_fact_is_refused(
    goal: str, facts: tuple[str, ...], issue: list[tuple[str, str]]
) -> None:
    assert refused(goal, *facts) == issue


def test_one_hold_may_keep_places_and_facts() -> None:
    assert refused("in(sample_1, bay_7)", "in(sample_2, bay_2)", places=("bay_7",)) == [
        ("place-held", "bay_7")
    ]
    assert StatedHold(places=("bay_3",), facts=(fact("in(sample_1, bay_7)"),)).words == (
        "bay_3 empty and sample_1 in bay_7 until an operator ends it"
    )
    with pytest.raises(ValueError, match="give places, facts or both"):
        StatedHold()


@pytest.mark.parametrize(
    ("stated", "hold", "code"),
    [
        (StatedHold(facts=(fact("in(sample_2, bay_2)"),)), standing(places=("bay_2",)), "place-held"),
        (StatedHold(places=("bay_2",)), standing("in(sample_2, bay_2)"), "fact-held"),
        (StatedHold(facts=(fact("in(sample_2, bay_2)"),)), standing("in(sample_2, bay_3)"), "fact-held"),
    ],
)
def test_a_hold_that_contradicts_one_that_stands_is_refused(
    stated: StatedHold, hold: StandingHold, code: str
) -> None:
    assert [issue.code for issue in standing_conflicts([stated], [hold], STORE.world)] == [code]
    assert standing_conflicts([stated], [standing("in(sample_4, bay_11)")], STORE.world) == ()


def test_the_goal_brings_about_what_is_not_true_yet_and_nothing_that_is() -> None:
    hold = StatedHold(
        places=("bay_5",),
        facts=(fact("in(sample_1, bay_7)"), fact("in(sample_2, bay_2)"), fact("near(yard_1, door_1)")),
        until=HoldEnd(),
    )

    def goals(*stated: str, aims: Sequence[SymbolicFact] = ()) -> list[str]:
        wanted = [said(one) for one in stated]
        found = goals_of_holds([hold], wanted, STORE.world, STORE.facts, Constraints(), lambda: aims)
        assert not isinstance(found, Clarification)
        return [str(goal) for goal in found[0]]

    assert goals() == ["in(sample_1, bay_7)", "near(yard_1, door_1)", "in(sample_3, bay_1)"]
    assert goals("in(sample_1, bay_7)") == ["near(yard_1, door_1)", "in(sample_3, bay_1)"]
    aimed_at = said("in(sample_4, bay_1)")
    assert goals("in(sample_1, bay_7)", aims=[aimed_at]) == ["near(yard_1, door_1)", "in(sample_3, bay_3)"]


def test_what_a_location_with_several_berths_has_room_for_is_not_withheld() -> None:
    world, facts = BERTHED.world, BERTHED.facts
    in_bay, in_berth = fact("in(sample_2, bay_2)"), fact("in(sample_2, bay_2_1)")
    assert is_kept_true(in_bay, world, facts)
    assert kept_things([in_bay], world).places == frozenset()
    assert achieves(in_berth, in_bay, world)
    assert not achieves(in_bay, in_berth, world)
    assert not contradicts(in_berth, in_bay, world)
    assert not contradicts(said("in(sample_1, bay_2)"), in_bay, world)
    assert contradicts(said("in(sample_2, bay_7)"), in_bay, world)
