"""A sentence as tokens: normalised words with their places in the text, and clock times."""

import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass

from app.domain.goal_language.words import ARTICLES

FILLERS = frozenset({"please", "back", "now", "over", "only"})
"""Words that change nothing."""
_ONE_TO_TWELVE = (
    "one",
    "two",
    "three",
    "four",
    "five",
    "six",
    "seven",
    "eight",
    "nine",
    "ten",
    "eleven",
    "twelve",
)
NUMERALS = {word: float(value) for value, word in enumerate(_ONE_TO_TWELVE, start=1)} | {
    "fifteen": 15.0,
    "twenty": 20.0,
    "thirty": 30.0,
    "half": 0.5,
}
_NUMBER = re.compile(r"[0-9]{1,6}")
_CLOCK = re.compile(r"(?<![\w-])[0-9]{1,2}:[0-9]{2}(?![\w-])")
_SEPARATE = ",;"


@dataclass(frozen=True, slots=True)
class Token:
    """A word and where it stands in the text."""

    word: str
    start: int
    end: int


def tokens_of(text: str) -> tuple[Token, ...]:
    """The words of the text without articles and fillers; a comma or semicolon is a word."""
    return tuple(
        token
        for token in _runs(text)
        if token.word and token.word not in ARTICLES and token.word not in FILLERS
    )


def number_of(word: str) -> float | None:
    """The value of a numeral; None if the word is none."""
    return float(word) if _NUMBER.fullmatch(word) else NUMERALS.get(word)


def _runs(text: str) -> Iterator[Token]:
    clocks = {match.start(): match.end() for match in _CLOCK.finditer(text)}
    at = 0
    while at < len(text):
        if at in clocks:
            yield Token(text[at : clocks[at]], at, clocks[at])
            at = clocks[at]
        elif text[at] in _SEPARATE:
            yield Token(text[at], at, at + 1)
            at += 1
        elif _separates(text[at]):
            at += 1
        else:
            end = at
            while end < len(text) and end not in clocks and not _separates(text[end]):
                end += 1
            yield _word(text, at, end)
            at = end


def _word(text: str, start: int, end: int) -> Token:
    return Token(text[start:end].lower().strip("-").replace("-", "_"), start, end)


def _separates(character: str) -> bool:
    """True for white space and punctuation except hyphens and underscores."""
    return character.isspace() or (character not in "-_" and unicodedata.category(character).startswith("P"))
