"""The contents of speech acts: ground terms, written `name(argument, ...)`.

An argument is a term, a number or text. A name that is no plain word is written in double quotes, as in JSON.
"""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite

from robots.errors import RobotError

MAX_DEPTH = 16
WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_.\-]*")
_TOKEN = re.compile(
    r"""\s*(?:(?P<word>[A-Za-z_][A-Za-z0-9_.\-]*)
    |(?P<number>-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)
    |(?P<text>"(?:[^"\\]|\\.)*")
    |(?P<sign>[(),])
    |(?P<end>$))""",
    re.VERBOSE,
)
_UNRECORDED = re.compile("[\0\ud800-\udfff]")
"""Escaped in JSON they may be said, but databases do not record them."""


class ContentError(RobotError):
    """Raised when the content of a speech act is no term; says where and what was expected."""


@dataclass(frozen=True, slots=True)
class Term:
    """A name with its arguments."""

    name: str
    args: tuple["Argument", ...] = ()

    def __str__(self) -> str:
        name = _written(self.name)
        return f"{name}({', '.join(_written(one) for one in self.args)})" if self.args else name

    @property
    def words(self) -> tuple[str, ...]:
        """The arguments as text: the names of terms without arguments, the rest as it is written."""
        return tuple(
            one.name if isinstance(one, Term) and not one.args else one if isinstance(one, str) else str(one)
            for one in self.args
        )


Argument = Term | float | str
"""`str` is taken when a term is made; parsing gives `Term` and `float`."""


def parse_term(text: str) -> Term:
    """:raises ContentError: if the text is not one term."""
    tokens = _Tokens(text)
    term = _term(tokens, depth=0)
    tokens.expect("end", "the end")
    return term


class _Tokens:
    def __init__(self, text: str) -> None:
        self._found = _scan(text)
        self.kind, self.text, self.at = next(self._found)

    def expect(self, kind: str, what: str) -> str:
        if self.kind != kind:
            raise ContentError(f"column {self.at + 1}: expected {what}, found {self.text or 'the end'}")
        return self.take()

    def take(self) -> str:
        text = self.text
        if self.kind != "end":
            self.kind, self.text, self.at = next(self._found)
        return text


def _scan(text: str) -> Iterator[tuple[str, str, int]]:
    at = 0
    while True:
        found = _TOKEN.match(text, at)
        if found is None or found.lastgroup is None:
            raise ContentError(f"column {at + 1}: {text[at : at + 10]!r} is no part of a term")
        kind = found.lastgroup
        yield kind, found.group(kind), found.start(kind)
        at = found.end()
        if kind == "end":
            return


def _term(tokens: _Tokens, depth: int) -> Term:
    if depth > MAX_DEPTH:
        raise ContentError(f"column {tokens.at + 1}: nested deeper than {MAX_DEPTH}")
    name = _name(tokens)
    if tokens.text != "(" or tokens.kind != "sign":
        return Term(name)
    tokens.take()
    args = [_argument(tokens, depth)]
    while tokens.kind == "sign" and tokens.text == ",":
        tokens.take()
        args.append(_argument(tokens, depth))
    if tokens.text != ")":
        raise ContentError(f"column {tokens.at + 1}: expected , or ), found {tokens.text or 'the end'}")
    tokens.take()
    return Term(name, tuple(args))


def _argument(tokens: _Tokens, depth: int) -> Argument:
    if tokens.kind != "number":
        return _term(tokens, depth + 1)
    if not isfinite(number := float(tokens.text)):
        raise ContentError(f"column {tokens.at + 1}: {tokens.text} is too large for a number")
    tokens.take()
    return number


def _name(tokens: _Tokens) -> str:
    if tokens.kind != "text":
        return tokens.expect("word", "a name")
    try:
        name = str(json.loads(tokens.text))
        if _UNRECORDED.search(name):
            raise ContentError(f"column {tokens.at + 1}: text with a NUL or a lone surrogate")
        return name
    except json.JSONDecodeError as error:
        raise ContentError(f"column {tokens.at + 1}: {error.msg}") from error
    finally:
        tokens.take()


def _written(part: Argument) -> str:
    if isinstance(part, Term):
        return str(part)
    if isinstance(part, float):
        return f"{part:g}" if float(f"{part:g}") == part else repr(part)
    return part if WORD.fullmatch(part) else json.dumps(part)
