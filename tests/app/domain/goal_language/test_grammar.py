"""Sentences that state goals."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.domain.goal_language.grammar import Clarification, Understood, parse_goal, understand
from app.domain.goal_language.verbs import shipped_verbs
from app.domain.goal_language.words import name_in, natural_key, words_of
from app.domain.world_model import revise_beliefs
from tests.app.sample_store import Store, said

STORE = Store()
VERBS = {word for word, verb in shipped_verbs().by_word.items() if verb.goals == ("in(?sample, ?place)",)}


def goals(text: str) -> list[str]:
    parsed = parse_goal(text, STORE.world, STORE.facts)
    assert not isinstance(parsed, Clarification), parsed
    return [str(goal) for goal in parsed]


def asked(text: str) -> Clarification:
    parsed = parse_goal(text, STORE.world, STORE.facts)
    assert isinstance(parsed, Clarification), parsed
    return parsed


@pytest.mark.parametrize("verb", sorted(VERBS))
@pytest.mark.parametrize("preposition", ["to", "in", "into", "at"])
def test_every_verb_and_preposition_means_the_sample_is_to_lie_there(verb: str, preposition: str) -> None:
    assert goals(f"{verb} sample_1 {preposition} bay_7") == ["in(sample_1, bay_7)"]


@pytest.mark.parametrize(
    "text",
    [
        "Move Sample_1 to Bay_7.",
        "move the sample 1 to the bay 7",
        "MOVE SAMPLE-1 TO BAY-7!",
        "please bring sample1 into bay7 now",
        "take sample_1 from door_1 to bay_7",
        "take sample_1 to bay_7 from door_1",
        "store the sample at door_1 in bay_7",
        "store the sample from door_1 in bay_7",
    ],
)
def test_case_articles_and_spelling_of_names_do_not_matter(text: str) -> None:
    assert goals(text) == ["in(sample_1, bay_7)"]


@pytest.mark.parametrize(
    "text",
    [
        "move sample_1 to bay_7 and move sample_2 to door_2",
        "move sample_1 to bay_7, sample_2 to door_2",
        "move sample_1 to bay_7, and then sample_2 to door_2",
        "store sample_1 in bay_7; retrieve sample_2 to door_2",
    ],
)
def test_goals_are_joined(text: str) -> None:
    assert goals(text) == ["in(sample_1, bay_7)", "in(sample_2, door_2)"]


def test_a_sentence_is_understood_without_knowing_where_things_are() -> None:
    parsed = parse_goal("take sample_1 from door_1 to bay_7", STORE.world)
    assert parsed == (said("in(sample_1, bay_7)"),)


def test_a_missing_place_is_asked_for_with_the_free_ones_likely_ones_first() -> None:
    store, retrieve = asked("store sample_1"), asked("retrieve sample_1")
    assert store.code == retrieve.code == "place-needed"
    assert (store.choices[0], retrieve.choices[0]) == ("bay_1", "door_2")
    assert not {"bay_2", "bay_5", "door_1", "home_yard_1"} & set(store.choices)
    assert "where to?" in store.detail


@pytest.mark.parametrize("text", ["move to bay_7", "move the sample to bay_7", "move it to bay_7"])
def test_a_missing_sample_is_asked_for(text: str) -> None:
    question = asked(text)
    assert question.code == "sample-needed"
    assert question.choices == ("sample_1", "sample_2", "sample_3", "sample_4")


def test_a_place_without_a_sample_names_none() -> None:
    assert "no sample lies in bay_1" in asked("move the sample at bay_1 to bay_7").detail


@pytest.mark.parametrize(
    ("text", "code", "thing", "suggestion"),
    [
        ("move smaple_1 to bay_7", "unknown-sample", "smaple_1", "sample_1"),
        ("move sample_1 to bay_77", "unknown-place", "bay_77", "bay_7"),
        ("move sample_1 from dor_1 to bay_7", "unknown-place", "dor_1", "door_1"),
        ("mvoe sample_1 to bay_7", "unknown-verb", "mvoe", "move"),
    ],
)
def test_near_misses_are_named_and_the_likely_name_offered_first(
    text: str, code: str, thing: str, suggestion: str
) -> None:
    question = asked(text)
    assert (question.code, question.thing, question.choices[0]) == (code, thing, suggestion)
    assert thing in question.detail
    assert suggestion in question.detail


def test_an_unknown_verb_is_answered_with_those_there_are() -> None:
    assert set(asked("fly sample_1 to bay_7").choices) == set(shipped_verbs().words)


def test_a_robot_is_no_sample() -> None:
    question = asked("move yard_1 to door_1")
    assert question.code == "unknown-sample"
    assert "yard_1 is a robot" in question.detail


def test_a_sample_that_lies_elsewhere_is_said_to() -> None:
    question = asked("move sample_1 from bay_2 to bay_7")
    assert (question.code, question.choices) == ("sample-elsewhere", ("door_1",))
    assert "sample_1 is in door_1, not in bay_2" in question.detail


def test_a_lost_sample_is_not_where_it_is_said_to_be() -> None:
    facts = revise_beliefs(STORE.facts, [], gone=[STORE.fact("in(sample_1, door_1)")])
    question = parse_goal("move sample_1 from door_1 to bay_7", STORE.world, facts)
    assert isinstance(question, Clarification)
    assert "in an unknown place" in question.detail


@pytest.mark.parametrize("text", ["", "   ", "and", "please", "the"])
def test_nothing_said_is_answered_with_an_example(text: str) -> None:
    question = asked(text)
    assert question.code == "goal-not-understood"
    assert "move sample_1 to bay_7" in question.detail


def test_too_many_places_are_refused() -> None:
    assert asked("move sample_1 to bay_1 to bay_3 to bay_4").code == "goal-not-understood"


WORDS = [
    *sorted(VERBS),
    "sample_1",
    "sample",
    "2",
    "to",
    "in",
    "from",
    "bay_7",
    "door_1",
    "and",
    ",",
    "the",
    "yard_1",
    "?",
    "keep",
    "empty",
    "until",
    "for",
    "is",
    "14:30",
    "minutes",
]


@given(st.lists(st.sampled_from(WORDS), max_size=12).map(" ".join) | st.text(max_size=60))
def test_any_text_gives_goals_of_this_world_or_a_question(text: str) -> None:
    parsed = parse_goal(text, STORE.world, STORE.facts)
    if isinstance(parsed, Clarification):
        assert parsed.detail
    else:
        understood = understand(text, STORE.world, STORE.facts)
        assert isinstance(understood, Understood)
        assert parsed or understood.holds
        assert {goal.args[0] for goal in parsed} <= {sample.name for sample in STORE.world.samples}
        assert {goal.args[1] for goal in parsed} <= {place.name for place in STORE.world.locations}


def test_numbers_in_names_are_ordered_as_numbers() -> None:
    assert sorted(["bay_10", "bay_2", "bay_1"], key=natural_key) == ["bay_1", "bay_2", "bay_10"]


def test_words_are_lower_case_without_articles_or_punctuation() -> None:
    assert words_of("Move THE Sample-1, to: bay 7!") == ("move", "sample_1", "to", "bay", "7")


@pytest.mark.parametrize("name", ["sample_1０", "sample_1²", "sample_1\u20e3", "sаmple_1"])
def test_no_character_of_a_name_is_passed_over(name: str) -> None:
    """A full-width digit, a superscript, an enclosing mark, a Cyrillic letter: none of them is sample_1."""
    question = asked(f"move {name} to bay_7")
    assert (question.code, question.thing) == ("unknown-sample", name)
    assert "sample_1" in question.choices


def test_two_numbers_are_not_run_together_to_a_third() -> None:
    names = ("sample_1", "sample_10", "bay_7_2")
    assert name_in(("sample", "1", "0"), names) not in names
    assert name_in(("sample", "10"), names) == "sample_10"
    assert name_in(("bay7_2",), names) == "bay_7_2"


def test_names_in_other_digits_are_put_in_order_too() -> None:
    assert sorted(["²", "b" + "9" * 5000, "b10", "b2"], key=natural_key) == [
        "b2",
        "b10",
        "b" + "9" * 5000,
        "²",
    ]
