"""The text of a rule file as statements, by the grammar in `rules.lark`."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

from robots.deliberative.program import Fault, Place
from robots.errors import RuleError

if TYPE_CHECKING:
    from lark import Tree

GRAMMAR = "rules.lark"
MAX_CHARACTERS = 64 * 1024
MAX_DEPTH = 20
"""How deep calls may be nested (our choice)."""
SIGNS = {
    "LPAR": "(",
    "RPAR": ")",
    "LSQB": "[",
    "RSQB": "]",
    "LBRACE": "{",
    "RBRACE": "}",
    "COMMA": ",",
    "SEMICOLON": ";",
    "COLON": ":",
    "PLUS": "+",
    "STAR": "*",
    "MINUS": "-",
    "AMPERSAND": "&",
    "BANG": "!",
    "NAME": "a name",
    "NUMBER": "a number",
    "STRING": "a string",
    "VARIABLE": "a ?variable",
    "COMPARISON": "a comparison",
}
"""How the grammar's terminals are written; keywords are written as they are named."""


@dataclass(frozen=True, slots=True)
class Node:
    """A part of the text: the grammar's name of it, its word if it is one, and its parts."""

    kind: str
    word: str
    parts: "tuple[Node, ...]"
    place: Place


@cache
def _parser() -> Any:
    try:
        from lark import Lark  # here: a robot without rules does without
    except ImportError as error:
        raise RuleError("rules need the parser library: install macta-robots[deliberative]") from error
    text = (resources.files("robots.deliberative") / GRAMMAR).read_text(encoding="utf-8")
    return Lark(text, parser="lalr", propagate_positions=True, maybe_placeholders=False)


def parse(text: str, origin: str) -> Node:
    """:raises RuleError: naming the file, line and column, and what may stand there."""
    if len(text) > MAX_CHARACTERS:
        raise RuleError(f"{origin}: {len(text)} characters; a rule file has at most {MAX_CHARACTERS}")
    parser = _parser()
    from lark.exceptions import UnexpectedCharacters, UnexpectedEOF, UnexpectedToken

    try:
        tree = parser.parse(text)
    except UnexpectedCharacters as error:
        words = (
            f"{text[error.pos_in_stream or 0]!r} cannot stand here; expected {_choices(error.allowed or ())}"
        )
        raise refusal(origin, [Fault(Place(error.line, error.column), words)]) from None
    except UnexpectedToken as error:
        found = "the end of the file" if error.token.type == "$END" else repr(str(error.token))
        place = _end_of(text) if error.token.type == "$END" else Place(error.line, error.column)
        words = f"{found} cannot stand here; expected {_choices(error.accepts or error.expected)}"
        raise refusal(origin, [Fault(place, words)]) from None
    except UnexpectedEOF as error:
        words = f"the file ends too early; expected {_choices(error.expected)}"
        raise refusal(origin, [Fault(_end_of(text), words)]) from None
    try:
        return _node(tree, 0)
    except _TooDeep as error:
        raise refusal(origin, [Fault(error.place, f"nested more than {MAX_DEPTH} deep")]) from None


def refusal(origin: str, faults: "list[Fault]") -> RuleError:
    """The error that lists the faults in the order of the text."""
    ordered = sorted(faults, key=lambda one: (one.place.line, one.place.column))
    return RuleError(
        "\n".join(f"{origin}:{one.place.line}:{one.place.column}: {one.words}" for one in ordered)
    )


class _TooDeep(Exception):
    """Raised when calls are nested too deep."""

    def __init__(self, place: Place) -> None:
        super().__init__()
        self.place = place


def _node(tree: "Tree[Any]", depth: int) -> Node:
    place = _place_of(tree)
    if depth > MAX_DEPTH:
        raise _TooDeep(place)
    return Node(str(tree.data), "", tuple(_parts(tree, depth)), place)


def _parts(tree: "Tree[Any]", depth: int) -> Iterator[Node]:
    from lark import Token

    for child in tree.children:
        if isinstance(child, Token):
            yield Node(child.type, str(child), (), Place(child.line or 1, child.column or 1))
        else:
            yield _node(child, depth + 1)


def _place_of(tree: "Tree[Any]") -> Place:
    return Place(1, 1) if tree.meta.empty else Place(tree.meta.line, tree.meta.column)


def _end_of(text: str) -> Place:
    lines = text.splitlines() or [""]
    return Place(len(lines), len(lines[-1]) + 1)


def _choices(terminals: Any) -> str:
    named = {SIGNS.get(one, "=>" if one == "__ANON_0" else one) for one in terminals if one != "$END"}
    return ", ".join(sorted(named)) or "nothing more"
