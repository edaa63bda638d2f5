"""Parts of a robot that installed packages add to what a world file may name, by kind: bodies and sensors."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import ConfigDict, GetCoreSchemaHandler, SerializationInfo, SerializerFunctionWrapHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from robots.data import Checked
from robots.errors import ExtensionError
from robots.extensions import installed, load_class


class PackagePartSpec(Checked):
    """Base of what a package's part is in a world file: its kind, and the parameters that a subclass adds."""

    model_config = ConfigDict(json_schema_extra={"additionalProperties": True})

    kind: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PartOfPackage:
    """Annotates a field: its kind alone, or a mapping with its kind; one of ours, or one that a package registers.

    :param group: the packages' entry points.
    :param base: the class that a package's specs are subclasses of.
    :param shipped: the type of ours, None if there are none; `kinds` are theirs.
    :param stated_as: the type of what a file may state, for its JSON Schema.
    """

    group: str
    base: type[PackagePartSpec]
    shipped: Any = None
    kinds: tuple[str, ...] = ()
    stated_as: Any

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        inner = handler.generate_schema(self.base if self.shipped is None else self.shipped)
        return core_schema.no_info_wrap_validator_function(
            self._read,
            inner,
            json_schema_input_schema=handler.generate_schema(self.stated_as),
            serialization=core_schema.wrap_serializer_function_ser_schema(
                _written, schema=inner, info_arg=True
            ),
        )

    def _read(self, value: Any, handler: core_schema.ValidatorFunctionWrapHandler) -> Any:
        if isinstance(value, self.base):
            return value
        stated = {"kind": value} if isinstance(value, str) else value
        kind = stated.get("kind") if isinstance(stated, Mapping) else None
        if kind in self.kinds or (self.shipped is not None and not isinstance(kind, str)):
            return handler(stated)
        return self._class_of(kind).model_validate(stated)

    def _class_of(self, kind: Any) -> type[PackagePartSpec]:
        try:
            found = load_class(self.group, kind, self.base) if isinstance(kind, str) else None
            others = () if found is not None else installed(self.group).keys()
        except ExtensionError as error:
            raise PydanticCustomError("broken_extension", "{words}", {"words": str(error)}) from error
        if found is None:
            choices = ", ".join(sorted({*self.kinds, *others})) or "none is installed"
            words = f"unknown kind {kind!r}; choices: {choices}"
            raise PydanticCustomError("unknown_kind", "{words}", {"words": words})
        known: type[PackagePartSpec] = found
        return known


def _written(value: Any, handler: SerializerFunctionWrapHandler, info: SerializationInfo) -> Any:
    if isinstance(value, PackagePartSpec):
        return {
            "kind": value.kind,
            **value.model_dump(mode=info.mode, exclude_defaults=info.exclude_defaults),
        }
    # NOTE: the kind chooses the class, so that it is written though it is its class's default.
    return {"kind": value.kind, **handler(value)}
