"""Reads YAML; base classes of checked data."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self, dataclass_transform

import yaml
from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""libyaml's loader where yaml was built with it, about ten times as fast."""


@dataclass_transform(frozen_default=True, kw_only_default=True)
class Frozen:
    """Base of families of frozen dataclasses: a subclass is one without a decorator of its own."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        dataclass(frozen=True, kw_only=True)(cls)


class Strict(Frozen):
    """Base of what is read from data: unknown keys and infinite numbers are errors."""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid", allow_inf_nan=False)


class NamedVariant(Strict):
    """Base of classes that a data file chooses by name; the name is the class name in snake case."""

    variant_name: ClassVar[str]

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        cls.variant_name = re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()


@dataclass(frozen=True, slots=True)
class ChosenBy:
    """Annotates a base class: data name one of its subclasses at this key, beside that subclass's fields."""

    key: str

    def __get_pydantic_core_schema__(
        self, kind: type[NamedVariant], handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        choices: dict[Any, CoreSchema] = {
            one.variant_name: core_schema.no_info_before_validator_function(
                self._without_name, handler.generate_schema(one)
            )
            for one in kind.__subclasses__()
        }
        return core_schema.tagged_union_schema(choices, self.key)

    def _without_name(self, slots: Mapping[str, Any]) -> dict[str, Any]:
        return {name: value for name, value in slots.items() if name != self.key}


class Checked(BaseModel):
    """Base of checked data: immutable; unknown keys and infinite numbers are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Memory(Checked):
    """Base of state that outlives a power failure: its owner changes it in place and saves a copy."""

    model_config = ConfigDict(frozen=False)

    def saved(self) -> Self:
        return self.model_copy(deep=True)


def read_yaml(text: str) -> Any:
    """The document that the text holds.

    :raises yaml.YAMLError: if it is not YAML. Raised by yaml's own loader, whose message shows the line.
    :raises ValueError: if it is too large or too deep, or holds an impossible number or date.
    """
    try:
        check_extent(text)
        return yaml.load(text, Loader=LOADER)
    except yaml.YAMLError:
        return yaml.safe_load(text)


MAX_DEPTH = 50
MAX_NODES = 500_000
"""How deep a file may be nested, and how many values it may hold with its aliases written out."""


def check_extent(text: str) -> None:
    """Refuse what would take minutes or the whole stack to read: aliases of aliases, lists in lists.

    :raises ValueError: naming the line.
    :raises yaml.YAMLError: if it is not YAML.
    """
    sizes = [0]  # of the collections that are open
    anchors: list[str | None] = []
    anchored: dict[str | None, int] = {}
    for event in yaml.parse(text, Loader=LOADER):
        if isinstance(event, yaml.CollectionStartEvent):
            sizes.append(1)
            anchors.append(event.anchor)
            if len(anchors) > MAX_DEPTH:
                raise ValueError(f"{_line(event)}: nested more than {MAX_DEPTH} deep")
            continue
        if isinstance(event, yaml.CollectionEndEvent):
            size = sizes.pop()
            anchor = anchors.pop()
        elif isinstance(event, yaml.AliasEvent):
            if event.anchor not in anchored:
                raise ValueError(f"{_line(event)}: the alias *{event.anchor} has no anchor before it")
            size = anchored[event.anchor]
            anchor = None
        elif isinstance(event, yaml.ScalarEvent):
            size = 1
            anchor = event.anchor
        else:
            continue
        if anchor is not None:
            anchored[anchor] = size
        sizes[-1] += size
        if sizes[-1] > MAX_NODES:
            raise ValueError(f"{_line(event)}: more than {MAX_NODES} values, aliases written out")


def _line(event: yaml.Event) -> str:
    return "a line" if event.start_mark is None else f"line {event.start_mark.line + 1}"
