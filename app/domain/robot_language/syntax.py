"""Sentences to commands and questions by the grammar in `robot.lark`."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from math import radians
from typing import Any

from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.tokens import NUMERALS
from app.domain.goal_language.words import ARTICLES, joined, suggestions
from app.domain.robot_language.sentence import Amount, Command, Dimension, Phrase, Question, Said, Topic

NOT_UNDERSTOOD = "words-not-understood"
FILLERS = ARTICLES | {"please", "now", "your", "my", "over", "there", "kindly"}
"""Words that change nothing."""
SHOWN_CHOICES = 20
END = "$END"
JOINTS = (",", ";", "and", "then")
_TOKEN = re.compile(r"(?P<number>\d+(?:\.\d+)?)|(?P<word>[^\W\d][\w-]*)|(?P<sign>[,;°])")
_UNITS: Mapping[str, tuple[Dimension, float]] = {
    "c": (Dimension.LENGTH, 0.01),
    "m": (Dimension.LENGTH, 1.0),
    "min": (Dimension.TIME, 60.0),
    "s": (Dimension.TIME, 1.0),
    "d": (Dimension.ANGLE, radians(1)),
    "°": (Dimension.ANGLE, radians(1)),
    "r": (Dimension.ANGLE, 1.0),
}
"""By the first letters of a unit."""


@dataclass(frozen=True, slots=True)
class Token:
    """A word, number or sign and where it stands in the text."""

    text: str
    start: int
    end: int
    is_number: bool = False


@dataclass(frozen=True)
class _Grammar:
    """The grammar's parser, and its keywords by terminal."""

    parser: Any
    keywords: Mapping[str, frozenset[str]]


@cache
def _grammar() -> _Grammar:
    # NOTE: imported here: what reads no sentence does not load the parser's library.
    from lark import Lark

    text = (resources.files("app.domain.robot_language") / "robot.lark").read_text(encoding="utf-8")
    parser = Lark(text, start="sentence", parser="lalr")
    keywords = {
        one.name: frozenset(re.sub(r"^\(\?:|\)$", "", one.pattern.value).split("|"))
        for one in parser.terminals
    }
    return _Grammar(parser, keywords)


def tokens_of(text: str) -> tuple[Token, ...]:
    """The words of a text in lower case, without articles and fillers; a comma, semicolon or degree sign is a word."""
    found = (
        Token(one.group().lower(), one.start(), one.end(), one.lastgroup == "number")
        for one in _TOKEN.finditer(text)
    )
    return tuple(one for one in found if one.text not in FILLERS)


def parse(text: str, verbs: Collection[str], robots: Iterable[str]) -> tuple[str, Said] | Clarification:
    """The robot that a sentence addresses, empty if it names none, and what it says; or the first word that cannot
    stand where it does.

    :param verbs: of one or several words. :param robots: the names of the world's robots.
    """
    from lark import Token as LarkToken

    known = _grammar()
    state = known.parser.parse_interactive()
    tokens = _with_verbs(_addressed(tokens_of(text), robots), verbs)
    if not tokens:
        return _unfinished((len(text), len(text)), state.accepts(), known, verbs)
    for kinds, token in tokens:
        possible = state.accepts()
        kind = next((kind for kind in (*kinds, *_keyword(token, known), "WORD") if kind in possible), None)
        if kind is None or (kind == "WORD" and not _is_name(token)):
            return _misplaced(token, possible - {END}, known, verbs)
        state.feed_token(LarkToken(kind, token.text, start_pos=token.start, end_pos=token.end))
    last = tokens[-1][1]
    if END not in state.accepts():
        return _unfinished((last.end, last.end), state.accepts(), known, verbs)
    tree = state.feed_eof(LarkToken(END, "", start_pos=len(text), end_pos=len(text)))
    first = tree.children[0]
    return (str(first) if _is_token(first) and first.type == "ROBOT" else ""), _said(tree.children[-1])


def _addressed(tokens: Sequence[Token], robots: Iterable[str]) -> list[tuple[tuple[str, ...], Token]]:
    """The tokens, with the robot's name that the first ones spell as one."""
    names = {name.replace("_", ""): name for name in robots}
    for count in (3, 2, 1):
        spelt = "".join(one.text for one in tokens[:count]).replace("_", "").replace("-", "")
        if len(tokens) >= count and spelt in names:
            address = Token(names[spelt], tokens[0].start, tokens[count - 1].end)
            return [(("ROBOT",), address), *_with_kinds(tokens[count:])]
    return _with_kinds(tokens)


def _with_kinds(tokens: Sequence[Token]) -> list[tuple[tuple[str, ...], Token]]:
    following = (*tokens[1:], None)
    return [(_kinds(one, after), one) for one, after in zip(tokens, following, strict=False)]


def _kinds(token: Token, after: Token | None) -> tuple[str, ...]:
    """A numeral in letters is a number before a unit alone: "the one at door_1" names a thing."""
    is_numeral = token.text in NUMERALS and after is not None and after.text in _grammar().keywords["UNIT"]
    return ("NUMBER",) if token.is_number or is_numeral else ()


def _with_verbs(
    tokens: Sequence[tuple[tuple[str, ...], Token]], verbs: Collection[str]
) -> list[tuple[tuple[str, ...], Token]]:
    """The tokens, with the words of a verb as one, the longest first; a verb begins a command."""
    longest = max((verb.count(" ") + 1 for verb in verbs), default=0)
    found: list[tuple[tuple[str, ...], Token]] = []
    at = 0
    may_begin = True
    while at < len(tokens):
        kinds, token = tokens[at]
        for count in range(longest if may_begin else 0, 0, -1):
            words = [one for _, one in tokens[at : at + count]]
            if " ".join(one.text for one in words) in verbs:
                found.append((("VERB",), Token(" ".join(o.text for o in words), token.start, words[-1].end)))
                at += count
                may_begin = False
                break
        else:
            found.append((kinds, token))
            may_begin = kinds == ("ROBOT",) or token.text in JOINTS
            at += 1
    return found


def _keyword(token: Token, known: _Grammar) -> Iterable[str]:
    return (name for name, words in known.keywords.items() if token.text in words)


def _is_name(token: Token) -> bool:
    return not token.is_number and token.text not in (",", ";", "°")


def _words_for(possible: Collection[str], known: _Grammar, verbs: Iterable[str]) -> tuple[str, ...]:
    listed = sorted(word for kind in possible for word in known.keywords.get(kind, ()) if len(word) > 1)
    return (*(sorted(verbs) if "VERB" in possible else ()), *(one for one in listed if one not in JOINTS))


def _misplaced(
    token: Token, possible: Collection[str], known: _Grammar, verbs: Iterable[str]
) -> Clarification:
    words = _words_for(possible, known, verbs)
    near = suggestions(token.text, words)
    hint = f"; did you mean {joined(near)}?" if near else f"; it could be {joined(words[:SHOWN_CHOICES])}"
    return Clarification(
        code=NOT_UNDERSTOOD,
        detail=f"{token.text!r} cannot stand here{hint if words else ''}",
        thing=token.text,
        choices=tuple(dict.fromkeys((*near, *words)))[:SHOWN_CHOICES],
        span=(token.start, token.end),
    )


def _unfinished(
    span: tuple[int, int], possible: Collection[str], known: _Grammar, verbs: Iterable[str]
) -> Clarification:
    words = _words_for(possible, known, verbs)[:SHOWN_CHOICES]
    return Clarification(
        code=NOT_UNDERSTOOD,
        detail="something is missing" + (f": {joined(words)}" if words else ""),
        choices=words,
        span=span,
    )


def _said(tree: Any) -> Said:
    if tree.data == "commands":
        return tuple(_command(child) for child in tree.children if not _is_token(child))
    about = next((_phrase(child) for child in tree.children if not _is_token(child)), None)
    return Question(topic=Topic(tree.data), about=about)


def _command(tree: Any) -> Command:
    verb, *parts = tree.children
    phrases = {one.data: _phrase(one.children[-1]) for one in parts if one.data != "amount"}
    leaves = list(tree.scan_values(_is_token))
    return Command(
        verb=str(verb),
        span=(verb.start_pos, verb.end_pos),
        end=leaves[-1].end_pos,
        object=phrases.get("object"),
        target=phrases.get("target"),
        amounts=tuple(_amount(one) for one in parts if one.data == "amount"),
    )


def _phrase(tree: Any) -> Phrase:
    leaves = list(tree.scan_values(_is_token))
    return Phrase(words=tuple(map(str, leaves)), span=(leaves[0].start_pos, leaves[-1].end_pos))


def _amount(tree: Any) -> Amount:
    *_, number, unit = tree.children
    dimension, factor = next(
        _UNITS[letters] for letters in (str(unit)[:3], str(unit)[:1]) if letters in _UNITS
    )
    value = NUMERALS.get(str(number))
    return Amount(
        value=(float(number) if value is None else value) * factor,
        dimension=dimension,
        span=(number.start_pos, unit.end_pos),
    )


def _is_token(node: Any) -> bool:
    return hasattr(node, "type")
