"""Reads YAML; base classes of checked data."""

import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, ClassVar

import yaml
from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, TypeAdapter
from pydantic_core import CoreSchema, PydanticCustomError, ValidationError, core_schema
from typing_extensions import Self, dataclass_transform

from robots.errors import ExtensionError
from robots.extensions import installed, load_class

if sys.version_info >= (3, 11):
    from enum import StrEnum as StrEnum  # noqa: PLC0414  # novm
else:
    from enum import Enum

    class StrEnum(str, Enum):
        """Python 3.11's own: members are strings, and are written as their values."""

        def __str__(self) -> str:
            return str.__str__(self)

        def __format__(self, format_spec: str) -> str:
            return str.__format__(self, format_spec)


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
    """Annotates a base class: data name one of its subclasses at this key, beside that subclass's fields.

    :param group: the entry points by which installed packages add subclasses, each under its `variant_name`.
    """

    key: str
    group: str

    def __get_pydantic_core_schema__(
        self, kind: type[NamedVariant], handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        named: dict[str, type[NamedVariant]] = {}
        for one in kind.__subclasses__():
            named.setdefault(one.variant_name, one)  # a package's class does not replace one of ours
        choices: dict[Any, CoreSchema] = {
            name: core_schema.no_info_before_validator_function(
                self._without_name, handler.generate_schema(one)
            )
            for name, one in named.items()
        }
        return core_schema.no_info_wrap_validator_function(
            partial(self._read, kind, frozenset(choices)), core_schema.tagged_union_schema(choices, self.key)
        )

    def _read(
        self,
        kind: type[NamedVariant],
        shipped: frozenset[str],
        value: Any,
        handler: core_schema.ValidatorFunctionWrapHandler,
    ) -> Any:
        name = value.get(self.key) if isinstance(value, Mapping) else None
        if not isinstance(name, str) or name in shipped:
            return handler(value)
        try:
            found = load_class(self.group, name, kind)
            others = () if found is not None else installed(self.group).keys()
        except ExtensionError as error:
            raise _refusal(str(error)) from error
        if found is None:
            choices = ", ".join(sorted({*shipped, *others}))
            raise _refusal(f"unknown {self.key} {name!r}; choices: {choices}")
        if found.variant_name != name:
            raise _refusal(
                f"{self.group}: {name} is the class {found.__qualname__}; register it as {found.variant_name}"
            )
        return _adapter(found).validate_python(self._without_name(value))

    def _without_name(self, slots: Mapping[str, Any]) -> dict[str, Any]:
        return {name: value for name, value in slots.items() if name != self.key}


@cache
def _adapter(kind: type[NamedVariant]) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def _refusal(words: str) -> PydanticCustomError:
    return PydanticCustomError("unknown_choice", "{words}", {"words": words})


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
        yaml.safe_load(text)
        raise  # what only yaml's own loader accepts, such as an escape of half a character


_SLOT = re.compile(r"[a-z]+(?:\.[A-Za-z0-9_]+)+")


def faults_in(text: str, error: ValidationError, within: Sequence[str | int] = ()) -> list[str]:
    """A schema's complaints about a YAML text, each with its line and slot.

    :param within: the slot that was checked, if not the whole text.
    """
    return [place_in(text, (*within, *one["loc"]), one["msg"]) for one in error.errors()]


def place_in(text: str, slot: Sequence[str | int], message: str) -> str:
    """`line 31, robots.2.start: …`; a message that itself begins with a slot, `robots.fred starts …`, keeps it."""
    said = message.removeprefix("Value error, ")
    named = _SLOT.match(said)
    where = [str(part) for part in slot] or (named[0].split(".") if named else [])
    line = _line_of(text, where)
    name = f"{'.'.join(map(str, slot))}: " if slot else "" if named else "file: "
    return f"line {line}, {name}{said}"


def _line_of(text: str, where: Sequence[str]) -> int:
    """The line of the deepest part that is there; the parts of a list are named by number or by their `name`."""
    node = yaml.compose(text, Loader=LOADER)
    line = 1
    for part in where:
        children = _children(node)
        if part not in children:
            break
        node = children[part]
        line = node.start_mark.line + 1
    return line


def _children(node: yaml.Node | None) -> dict[str, yaml.Node]:
    if isinstance(node, yaml.MappingNode):
        return {str(key.value): value for key, value in node.value}
    if not isinstance(node, yaml.SequenceNode):
        return {}
    children: dict[str, yaml.Node] = {}
    for index, child in enumerate(node.value):
        children[str(index)] = child
        if isinstance(name := _children(child).get("name"), yaml.ScalarNode):
            children[name.value] = child
    return children


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
