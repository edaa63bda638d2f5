"""Reads a knowledge base from YAML; errors name the file, the line, the action and the slot."""

import re
from collections.abc import Iterator, Sequence
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from planner.errors import KnowledgeBaseError
from planner.knowledge.base import KnowledgeBase
from planner.knowledge.extent import LOADER, check_extent
from planner.knowledge.schema import KnowledgeBaseFile

_PLACE = re.compile(r"^(?:Value error, )?((?:[a-z_]+)(?:\.[A-Za-z0-9_]+)+): ")

_WORDS = {
    "a valid tuple": "a list",
    "Tuple should": "The list should",
    "Extra inputs are not permitted": "there is no such slot",
}
"""Pydantic's terms as YAML's."""


def load_knowledge_base(path: str | Path | None = None) -> KnowledgeBase:
    """The knowledge base of a file, or the one that ships with Macta.

    :raises KnowledgeBaseError: if it is missing, not YAML, or does not fit the schema.
    """
    if path is None:
        shipped = resources.files("planner.knowledge") / "files" / "rovers.yaml"
        return read_knowledge_base(shipped.read_text(), "rovers.yaml")
    file = Path(path)
    if not file.is_file():
        raise KnowledgeBaseError(f"no knowledge base file {str(path)!r}")
    try:
        text = file.read_text(encoding="utf-8")
    except OSError as error:
        raise KnowledgeBaseError(f"{path} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise KnowledgeBaseError(f"{path} is no text: {error.reason} at byte {error.start}") from error
    return read_knowledge_base(text, str(path))


@lru_cache(maxsize=8)
def read_knowledge_base(text: str, origin: str) -> KnowledgeBase:
    """As `load_knowledge_base`, from the text itself; the same object for the same text."""
    try:
        root, data = _composed(text)
    except yaml.YAMLError as error:
        raise KnowledgeBaseError(f"{origin} is not YAML: {error}") from error
    except ValueError as error:  # too large or deep, or an impossible number or date
        raise KnowledgeBaseError(f"{origin} cannot be read: {error}") from error
    if not isinstance(data, dict) or root is None:
        raise KnowledgeBaseError(f"{origin} does not contain a mapping of types, predicates and actions")
    if doubles := list(_doubles(root)):
        raise KnowledgeBaseError("\n".join([f"{origin} is not a valid knowledge base:", *doubles]))
    try:
        return KnowledgeBase(KnowledgeBaseFile.model_validate(data))
    except ValidationError as error:
        lines = [_describe(root, [str(part) for part in e["loc"]], e["msg"]) for e in error.errors()]
        raise KnowledgeBaseError("\n".join([f"{origin} is not a valid knowledge base:", *lines])) from error


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


def _describe(root: yaml.Node, place: list[str], message: str) -> str:
    """`line 31, TRANSPORT, preconditions.2: …`"""
    if (match := _PLACE.match(message)) is not None:
        place = match[1].split(".")
        message = message[match.end() :]
    line = root.start_mark.line + 1
    action = ""
    node: yaml.Node | None = root
    for part in place:
        node = _child(node, part)
        if node is None:
            break
        line = node.start_mark.line + 1
        if isinstance(name := _child(node, "name"), yaml.ScalarNode) and not action:
            action = str(name.value)
    slot = ".".join(place[2:] if action else place) or "file"
    for theirs, ours in _WORDS.items():
        message = message.replace(theirs, ours)
    return f"  line {line}, {f'{action}, ' if action else ''}{slot}: {message.removeprefix('Value error, ')}"


def _child(node: yaml.Node | None, part: str) -> yaml.Node | None:
    if isinstance(node, yaml.MappingNode):
        return next((value for key, value in node.value if key.value == part), None)
    if isinstance(node, yaml.SequenceNode) and part.isdigit() and int(part) < len(node.value):
        child: yaml.Node = node.value[int(part)]
        return child
    return None
