"""A knowledge base file as YAML: its text, its data, and the line of each slot."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import yaml
from pydantic import ValidationError

from planner.errors import KnowledgeBaseError
from planner.knowledge.extent import LOADER, check_extent

_PLACE = re.compile(r"^(?:Value error, )?((?:[a-z_]+)(?:\.[A-Za-z0-9_]+)+): ")

_WORDS = {
    "a valid tuple": "a list",
    "Tuple should": "The list should",
    "Extra inputs are not permitted": "there is no such slot",
}
"""Pydantic's terms as YAML's."""


def read_text(path: str | Path) -> str:
    """:raises KnowledgeBaseError: if the file is missing or no text."""
    file = Path(path)
    if not file.is_file():
        raise KnowledgeBaseError(f"no knowledge base file {str(path)!r}")
    try:
        return file.read_text(encoding="utf-8")
    except OSError as error:
        raise KnowledgeBaseError(f"{path} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise KnowledgeBaseError(f"{path} is no text: {error.reason} at byte {error.start}") from error


def place_of(message: str) -> tuple[tuple[str, ...], str]:
    """The slot that a message of the schema begins with, and the rest of the message."""
    match = _PLACE.match(message)
    return (tuple(match[1].split(".")), message[match.end() :]) if match else ((), message)


@dataclass(frozen=True, slots=True, kw_only=True)
class Document:
    """A YAML mapping; `origin` is its file's name, for messages."""

    origin: str
    root: yaml.Node
    data: dict[Any, Any]

    @classmethod
    def parse(cls, text: str, origin: str) -> Self:
        """:raises KnowledgeBaseError: if it is not YAML, no mapping, or has a key twice."""
        try:
            root, data = _composed(text)
        except yaml.YAMLError as error:
            raise KnowledgeBaseError(f"{origin} is not YAML: {error}") from error
        except ValueError as error:  # too large or deep, or an impossible number or date
            raise KnowledgeBaseError(f"{origin} cannot be read: {error}") from error
        if not isinstance(data, dict) or root is None:
            raise KnowledgeBaseError(f"{origin} does not contain a mapping of types, predicates and actions")
        document = cls(origin=origin, root=root, data=data)
        if doubles := list(_doubles(root)):
            raise document.invalid(doubles)
        return document

    def invalid(self, lines: Sequence[str]) -> KnowledgeBaseError:
        return KnowledgeBaseError("\n".join([f"{self.origin} is not a valid knowledge base:", *lines]))

    def refused(self, error: ValidationError) -> KnowledgeBaseError:
        """The schema's complaints, each with its line, action and slot."""
        return self.invalid(
            [self.describe([str(part) for part in e["loc"]], e["msg"]) for e in error.errors()]
        )

    def line(self, place: Sequence[str]) -> int:
        """The line of the deepest part of the place that is there."""
        line = self.root.start_mark.line + 1
        node: yaml.Node | None = self.root
        for part in place:
            node = _child(node, part)
            if node is None:
                break
            line = node.start_mark.line + 1
        return line

    def describe(self, place: Sequence[str], message: str) -> str:
        """`line 31, TRANSPORT, preconditions.2: …`; a place that the message begins with counts instead."""
        named, message = place_of(message)
        place = named or place
        action = self._action(place)
        slot = ".".join(place[2:] if action else place) or ("name" if action else "file")
        for theirs, ours in _WORDS.items():
            message = message.replace(theirs, ours)
        where = f"line {self.line(place)}, {f'{action}, ' if action else ''}{slot}"
        return f"  {where}: {message.removeprefix('Value error, ')}"

    def _action(self, place: Sequence[str]) -> str:
        node: yaml.Node | None = self.root
        for part in place:
            node = _child(node, part)
            if isinstance(name := _child(node, "name"), yaml.ScalarNode):
                return str(name.value)
        return ""


def _composed(text: str) -> tuple[yaml.Node | None, Any]:
    """The YAML nodes, which have lines, and the data."""
    try:
        check_extent(text)
        return yaml.compose(text, Loader=LOADER), yaml.load(text, Loader=LOADER)
    except yaml.YAMLError:  # the message of yaml's own reader shows the line
        return yaml.compose(text, Loader=yaml.SafeLoader), yaml.safe_load(text)


def _doubles(node: yaml.Node) -> Iterator[str]:
    """Duplicate keys of a mapping, of which YAML silently takes the last."""
    children: Sequence[yaml.Node] = node.value if isinstance(node, yaml.SequenceNode) else ()
    if isinstance(node, yaml.MappingNode):
        first: dict[str, int] = {}
        for key, _ in node.value:
            line = key.start_mark.line + 1
            if key.value in first:
                yield f"  line {line}, {key.value}: stands here for the second time, first in line {first[key.value]}"
            first.setdefault(key.value, line)
        children = [value for _, value in node.value]
    for child in children:
        yield from _doubles(child)


def _child(node: yaml.Node | None, part: str) -> yaml.Node | None:
    if isinstance(node, yaml.MappingNode):
        return next((value for key, value in node.value if key.value == part), None)
    if isinstance(node, yaml.SequenceNode) and part.isdigit() and int(part) < len(node.value):
        child: yaml.Node = node.value[int(part)]
        return child
    return None
