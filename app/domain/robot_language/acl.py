"""Lines of FIPA ACL by the grammar in `acl.lark`."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.words import joined
from app.domain.robot_language.sentence import Phrase
from app.domain.robot_language.syntax import NOT_UNDERSTOOD
from robots.wire import Performative

KEYS = ("target", "action", "object", "to", "property", "content")
"""Fields of every line; a request for a packet also has those of its arguments."""
_ESCAPED = re.compile(r'\\(["\\])')
"""A quote or a backslash in a quoted value."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AclLine:
    """A performative with its fields. `span`: of the performative."""

    performative: Performative
    span: tuple[int, int]
    fields: Mapping[str, Phrase]
    properties: tuple[str, ...] = ()

    def text(self, key: str) -> str:
        """The value of a field; empty without it."""
        return self.fields[key].said if key in self.fields else ""


def is_acl(text: str) -> bool:
    """True for a text that begins with a performative in capitals, or with one and has fields."""
    first, _, rest = text.strip().partition(" ")
    if first.lower() not in {one.value for one in Performative}:
        return False
    return first.isupper() or ":" in rest


def parse_acl(text: str) -> AclLine | Clarification:
    """:return: the line, or what cannot stand where it does."""
    from lark.exceptions import UnexpectedInput

    try:
        tree = _parser().parse(text)
    except UnexpectedInput as error:
        at = error.pos_in_stream
        at = len(text) if at is None or at < 0 else at
        return Clarification(
            code=NOT_UNDERSTOOD,
            detail=f"column {at + 1}: a line is PERFORMATIVE key:value ..., with the keys {joined(KEYS)}",
            thing=text[at:].split(" ", 1)[0],
            choices=tuple(f"{key}:" for key in KEYS),
            span=(at, len(text)),
        )
    verb, *fields = tree.children
    read = {str(one.children[0]): one.children[1] for one in fields if len(one.children) > 1}
    phrases = {key: _phrase(value) for key, value in read.items()}
    listed = phrases.get("property", Phrase(words=(), span=(0, 0))).said
    return AclLine(
        performative=Performative(str(verb).lower()),
        span=(verb.start_pos, verb.end_pos),
        fields=phrases,
        properties=tuple(one.strip() for one in listed.split(",") if one.strip()),
    )


def _phrase(value: Any) -> Phrase:
    text = str(value)
    if value.type == "QUOTED":
        text = _ESCAPED.sub(r"\1", text[1:-1])
    elif value.type == "LIST":
        text = text[1:-1]
    return Phrase(words=tuple(text.split()), span=(value.start_pos, value.end_pos))


@cache
def _parser() -> Any:
    from lark import Lark

    text = (resources.files("app.domain.robot_language") / "acl.lark").read_text(encoding="utf-8")
    return Lark(text, start="line", parser="lalr")
