"""Merges knowledge base files into one knowledge base; errors name each file, the line, the action and the slot.

A file may rest on what another defines, so only the whole is checked against itself. Types, functions, predicates
and quantities may stand in several files if they are the same in each; a type's `values` are then taken together.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

from pydantic import Field, ValidationError

from planner.errors import KnowledgeBaseError
from planner.knowledge.action import ActionSpec, Slot, Word
from planner.knowledge.base import KnowledgeBase
from planner.knowledge.document import Document, place_of, read_text
from planner.knowledge.load import read_knowledge_base
from planner.knowledge.schema import KnowledgeBaseFile, PredicateSpec, QuantitySpec, TypeSpec

Spec = TypeVar("Spec", PredicateSpec, QuantitySpec, tuple[str, ...])
Origin = tuple[Document, tuple[str, ...]]
"""A document, and the place in it."""


class KnowledgeBasePart(Slot):
    """A file of a knowledge base that others complete; its slots are those of `KnowledgeBaseFile`."""

    types: dict[Word, TypeSpec] = Field(default_factory=dict)
    functions: dict[Word, tuple[Word, ...]] = Field(default_factory=dict)
    predicates: dict[Word, PredicateSpec] = Field(default_factory=dict)
    quantities: dict[Word, QuantitySpec] = Field(default_factory=dict)
    actions: tuple[ActionSpec, ...] = ()


def merge_knowledge_bases(paths: Sequence[str | Path]) -> KnowledgeBase:
    """The knowledge base that the files define together, the first file's actions first.

    :raises KnowledgeBaseError: if one is missing or malformed, two define the same name differently, or the whole does
        not fit the schema.
    """
    texts = tuple((read_text(path), str(path)) for path in paths)
    return read_knowledge_base(*texts[0]) if len(texts) == 1 else _merged(texts)


@lru_cache(maxsize=8)
def _merged(texts: tuple[tuple[str, str], ...]) -> KnowledgeBase:
    merge = _Merge()
    for text, origin in texts:
        document = Document.parse(text, origin)
        merge.add(document, _part(document))
    return merge.result()


def read_knowledge_base_part(path: str | Path) -> KnowledgeBasePart:
    """One of several files of a knowledge base, each slot checked, but not against the others.

    :raises KnowledgeBaseError: if it is missing or malformed.
    """
    return _read_part(read_text(path), str(path))


@lru_cache(maxsize=8)
def _read_part(text: str, origin: str) -> KnowledgeBasePart:
    return _part(Document.parse(text, origin))


def _part(document: Document) -> KnowledgeBasePart:
    try:
        return KnowledgeBasePart.model_validate(document.data)
    except ValidationError as error:
        raise document.refused(error) from error


@dataclass(slots=True)
class _Merge:
    """What was taken so far, and where each name was first defined."""

    types: dict[str, TypeSpec] = field(default_factory=dict)
    functions: dict[str, tuple[str, ...]] = field(default_factory=dict)
    predicates: dict[str, PredicateSpec] = field(default_factory=dict)
    quantities: dict[str, QuantitySpec] = field(default_factory=dict)
    actions: list[ActionSpec] = field(default_factory=list)
    _first: dict[tuple[str, str], Origin] = field(default_factory=dict)
    _action_origins: list[Origin] = field(default_factory=list)

    def add(self, document: Document, part: KnowledgeBasePart) -> None:
        """:raises KnowledgeBaseError: if it defines differently what is defined already."""
        faults = [
            *self._take_types(document, part.types),
            *self._take(document, "functions", part.functions, self.functions),
            *self._take(document, "predicates", part.predicates, self.predicates),
            *self._take(document, "quantities", part.quantities, self.quantities),
            *self._take_actions(document, part.actions),
        ]
        if faults:
            raise document.invalid(faults)

    def _take_types(self, document: Document, types: Mapping[str, TypeSpec]) -> Iterator[str]:
        for name, spec in types.items():
            known = self.types.get(name, spec)
            if spec.model_copy(update={"values": known.values}) != known:
                yield self._conflict(document, ("types", name))
                continue
            self._first.setdefault(("types", name), (document, ("types", name)))
            values = tuple(dict.fromkeys((*known.values, *spec.values)))
            self.types[name] = known.model_copy(update={"values": values})

    def _take(
        self, document: Document, slot: str, specs: Mapping[str, Spec], taken: dict[str, Spec]
    ) -> Iterator[str]:
        for name, spec in specs.items():
            if taken.setdefault(name, spec) != spec:
                yield self._conflict(document, (slot, name))
            self._first.setdefault((slot, name), (document, (slot, name)))

    def _take_actions(self, document: Document, actions: Sequence[ActionSpec]) -> Iterator[str]:
        """Take actions in; one whose number another file has used gets the next free one."""
        known = {action.name: action for action in self.actions}
        numbers = {action.identifier for action in self.actions}
        for index, action in enumerate(actions):
            place = ("actions", str(index))
            if action.name in known:
                same = action.model_copy(update={"identifier": known[action.name].identifier})
                if same != known[action.name] or self._first["actions", action.name][0] is document:
                    yield self._conflict(document, place, name=action.name)
                continue
            known[action.name] = action
            number = max(numbers) + 1 if action.identifier in numbers else action.identifier
            numbers.add(number)
            self._first["actions", action.name] = (document, place)
            self._action_origins.append((document, place))
            self.actions.append(action.model_copy(update={"identifier": number}))

    def _conflict(self, document: Document, place: tuple[str, ...], name: str | None = None) -> str:
        name = name or place[1]
        other, at = self._first[place[0], name]
        twice = "defined twice" if other is document else "defined differently"
        said = f"{twice}, first in {other.origin}, line {other.line(at)}"
        return document.describe(place, f"{name} is {said}")

    def result(self) -> KnowledgeBase:
        """:raises KnowledgeBaseError: naming the file and place of what does not fit the others."""
        try:
            return KnowledgeBase(
                KnowledgeBaseFile(
                    types=self.types,
                    functions=self.functions,
                    predicates=self.predicates,
                    quantities=self.quantities,
                    actions=tuple(self.actions),
                )
            )
        except ValidationError as error:
            raise KnowledgeBaseError("\n".join(self._placed(error))) from error

    def _placed(self, error: ValidationError) -> Iterator[str]:
        for one in error.errors():
            named, message = place_of(one["msg"])
            place = named or tuple(str(part) for part in one["loc"])
            document, at = self._origin(place)
            if document is None:
                yield f"the knowledge bases together are not valid: {'.'.join(place)}: {message}"
            else:
                yield f"{document.origin} is not a valid knowledge base:"
                yield document.describe(at, message)

    def _origin(self, place: Sequence[str]) -> tuple[Document | None, tuple[str, ...]]:
        if len(place) > 1 and place[0] == "actions" and int(place[1]) < len(self._action_origins):
            document, at = self._action_origins[int(place[1])]
            return document, (*at, *place[2:])
        if tuple(place[:2]) in self._first:
            document, _ = self._first[place[0], place[1]]
            return document, tuple(place)
        return None, tuple(place)
