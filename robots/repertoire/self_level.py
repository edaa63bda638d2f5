"""The self level (MACTA §3): the patterns that all driving packets share, and the battery levels."""

from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any

import yaml
from pydantic import Field, ValidationError, model_validator

from robots.data import Checked, read_yaml
from robots.errors import RepertoireError
from robots.repertoire.schema import PacketSpec, behaviour_patterns

FILE = "self_level.yaml"


class SelfLevel(Checked):
    """Shares of a full battery, 0 to 1, the shared patterns, and those of a retry, which lasts `retry_s` seconds.

    Below `low` a robot without a script seeks its charger, below `needed` it accepts no script, and below `critical` it
    gives up the one it has. The values are our choice.
    """

    low: float = Field(gt=0, le=1)
    needed: float = Field(gt=0, le=1)
    critical: float = Field(gt=0, le=1)
    patterns: tuple[dict[str, Any], ...]
    retry: tuple[dict[str, Any], ...]
    retry_s: float = Field(gt=0, le=60)

    @model_validator(mode="after")
    def _in_order(self) -> "SelfLevel":
        if not self.critical < self.needed <= self.low:
            raise ValueError("the levels must be critical < needed <= low")
        behaviour_patterns().validate_python((*self.patterns, *self.retry))
        return self

    def added_to(self, spec: PacketSpec) -> PacketSpec:
        """The packet with the shared patterns of those degrees of freedom that its own patterns act on, and a retry."""

        def group(patterns: Sequence[Mapping[str, Any]]) -> tuple[Mapping[str, Any], ...]:
            moved = {one["dof"] for one in patterns}
            return (*patterns, *(one for one in self.patterns if one["dof"] in moved))

        shared: dict[str, Any] = {"waiting": group(spec.waiting), "patterns": group(spec.patterns)}
        if not spec.retry and spec.retries:
            shared |= {"retry": self.retry, "retry_s": self.retry_s}
        return spec.model_copy(update=shared)


@cache
def load_self_level() -> SelfLevel:
    """The self level that ships with the robots' software.

    :raises RepertoireError: saying what is wrong with it.
    """
    text = resources.files("robots.repertoire").joinpath(FILE).read_text(encoding="utf-8")
    try:
        return SelfLevel.model_validate(read_yaml(text))
    except (yaml.YAMLError, ValidationError) as error:
        raise RepertoireError(f"{FILE} is no self level: {error}") from error
