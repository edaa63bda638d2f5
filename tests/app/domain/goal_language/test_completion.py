"""How a sentence could go on."""

import pytest

from app.domain.goal_language.check import GoalIssue
from app.domain.goal_language.completion import completions, replacements
from app.domain.goal_language.grammar import Clarification, parse_goal
from tests.app.sample_store import Store

STORE = Store()


def completed(text: str) -> tuple[str, ...]:
    parsed = parse_goal(text, STORE.world, STORE.facts)
    if not isinstance(parsed, Clarification):
        return ()
    return completions(text, parsed, STORE.world, STORE.facts)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "move sample_1"),
        ("m", "move"),
        ("move", "move sample_1"),
        ("move sam", "move sample_1"),
        ("move sample_1", "move sample_1 to bay_1"),
        ("move sample_1 t", "move sample_1 to bay_1"),
        ("move sample_1 into", "move sample_1 into bay_1"),
        ("move sample_1 to bay", "move sample_1 to bay_1"),
        ("Move Sample 1 into Bay", "Move Sample 1 into bay_1"),
        ("move sample_9 to bay_1", "move sample_4 to bay_1"),
        ("move sample_1 to bay_7, sample_2 to", "move sample_1 to bay_7, sample_2 to bay_1"),
        ("mvoe sample_1 to bay_4", "move sample_1 to bay_4"),
        ("sample_1 to bay_4", "move sample_1 to bay_4"),
    ],
)
def test_a_sentence_goes_on_where_something_is_missing(text: str, sentence: str) -> None:
    assert sentence in completed(text)


def test_what_begins_with_the_letters_typed_comes_in_natural_order() -> None:
    found = completed("move sample_1 to bay_1"), completed("move sample_1 to ba")
    assert found[0] == ()  # that is a goal already
    assert found[1][:2] == ("move sample_1 to bay_1", "move sample_1 to bay_2")
    assert found[1].index("move sample_1 to bay_9") < found[1].index("move sample_1 to bay_10")


def test_a_sentence_once_completed_lacks_nothing_or_something_else() -> None:
    """Whatever is chosen again and again ends in a goal."""
    for start in ("", "m", "store sam", "put the sample at door_1 in"):
        text = start
        for _ in range(4):
            if not isinstance(parsed := parse_goal(text, STORE.world, STORE.facts), Clarification):
                break
            text = completions(text, parsed, STORE.world, STORE.facts)[0]
        assert not isinstance(parse_goal(text, STORE.world, STORE.facts), Clarification), (start, text)


def test_what_no_choice_mends_is_not_completed() -> None:
    assert completed("move sample_1 to bay_1 to bay_2 to bay_3") == ()


def test_what_stands_in_a_goals_way_is_replaced_where_it_is_named() -> None:
    occupied = GoalIssue(
        code="place-occupied", kind="conflict", detail="", thing="bay_2", choices=("bay_1", "bay_4")
    )
    assert replacements("move sample_1 to Bay 2 please", occupied) == (
        "move sample_1 to bay_1 please",
        "move sample_1 to bay_4 please",
    )
