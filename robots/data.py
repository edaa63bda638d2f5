"""Checked data: what YAML holds, and the base of everything that is read from it."""

from typing import Any, ClassVar

import yaml
from pydantic import BaseModel, ConfigDict

YAML_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""libyaml's loader where yaml was built with it, about ten times as fast."""


class Strict:
    """Base of dataclasses that are read from data: unknown keys and infinite numbers are errors."""

    __slots__ = ()
    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid", allow_inf_nan=False)


class Checked(BaseModel):
    """Base of checked data: immutable; unknown keys and infinite numbers are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def read_yaml(text: str) -> Any:
    """The document that the text holds.

    :raises yaml.YAMLError: if it is not YAML. Raised by yaml's own loader, whose message shows the line.
    """
    try:
        return yaml.load(text, Loader=YAML_LOADER)
    except yaml.YAMLError:
        return yaml.safe_load(text)
