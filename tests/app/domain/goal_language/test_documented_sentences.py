"""The sentences of docs/goals.md mean what the page says."""

import re
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest

from app.domain.goal_language.grammar import Clarification, Understood, understand
from app.domain.goal_language.words import joined
from tests.app.sample_store import Store

PAGE = Path(__file__).parents[4] / "docs" / "goals.md"
STORE = Store()
NOW = datetime(2026, 3, 1, 14, 0, tzinfo=UTC)


def rows(heading: str) -> Iterator[list[str]]:
    """The rows of the table with this heading."""
    _, _, after = PAGE.read_text().partition(heading)
    for line in after.splitlines()[2:]:
        if not line.startswith("|"):
            return
        yield [cell.strip() for cell in line.strip("|").split("|")]


SENTENCES = list(rows("| Sentence | Goals | Terms |"))
QUESTIONS = list(rows("| Sentence | Code | Word | A choice |"))


def test_the_page_has_sentences() -> None:
    assert len(SENTENCES) > 15
    assert len(QUESTIONS) > 5


@pytest.mark.parametrize(("sentence", "goals", "terms"), SENTENCES, ids=[row[0] for row in SENTENCES])
def test_a_documented_sentence_means_what_the_page_says(sentence: str, goals: str, terms: str) -> None:
    understood = understand(sentence.strip("`"), STORE.world, STORE.facts, now=NOW)
    assert isinstance(understood, Understood), understood
    assert [str(goal) for goal in understood.goals] == re.findall(r"`([^`]+)`", goals)
    told = [*understood.constraints.words, *understood.constraints.preference_words]
    told.extend(f"holds {hold.words}" for hold in understood.holds)
    if understood.due is not None:
        told.append(f"due in {understood.due.in_s:.0f} s")
    if stages := understood.constraints.stages:
        told.append(f"in stages {joined(tuple(map(str, stages)), last='and')}")
    assert "; ".join(told) == terms


@pytest.mark.parametrize(("sentence", "code", "word", "choice"), QUESTIONS, ids=[row[0] for row in QUESTIONS])
def test_a_documented_question_is_asked(sentence: str, code: str, word: str, choice: str) -> None:
    text = sentence.strip("`")
    question = understand(text, STORE.world, STORE.facts, now=NOW)
    assert isinstance(question, Clarification), question
    assert question.span is not None
    assert (question.code, text[slice(*question.span)]) == (code.strip("`"), word.strip("`"))
    assert not choice or choice.strip("`") in question.choices
