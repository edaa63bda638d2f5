"""The form of a packet's content: [sensor pre-conditions, behaviour patterns, sensor post-conditions] (MACTA
§3).
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from robots.conditions import AnyCondition, Condition
from robots.patterns import BehaviourPattern


class Checked(BaseModel):
    """Base: immutable, unknown keys are an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class PacketSpec(Checked):
    """A packet's content as a template: strings that begin with `$` name arguments, `$me` the robot itself.

    `arguments` must be given; `places`, `objects` and `robots` say which of them name what. `before` and
    `after` are the sensor pre- and post-conditions. Our additions: `waiting`, patterns active until the pre-
    conditions hold; `maintain`, conditions whose loss is a failure; `goal`, the place whose approach point
    measures progress.
    """

    tag: str
    about: str
    arguments: tuple[str, ...]
    places: tuple[str, ...] = ()
    robots: tuple[str, ...] = ()
    before: tuple[dict[str, Any], ...] = ()
    waiting: tuple[dict[str, Any], ...] = ()
    patterns: tuple[dict[str, Any], ...] = Field(min_length=1)
    maintain: tuple[dict[str, Any], ...] = ()
    after: tuple[dict[str, Any], ...] = Field(min_length=1)
    goal: str | None = None

    def bind(self, arguments: dict[str, str]) -> "BoundPacket":
        """The packet for these arguments; a name that no argument gives stays unknown to the senses.

        :raises pydantic.ValidationError: if a condition or pattern is malformed.
        """

        def fill(value: Any) -> Any:
            if isinstance(value, str) and value.startswith("$"):
                return arguments.get(value[1:], value)
            if isinstance(value, dict):
                return {key: fill(inner) for key, inner in value.items()}
            return [fill(inner) for inner in value] if isinstance(value, list | tuple) else value

        conditions, patterns = _conditions(), _patterns()
        return BoundPacket(
            tag=self.tag,
            before=conditions.validate_python(fill(self.before)),
            waiting=patterns.validate_python(fill(self.waiting)),
            patterns=patterns.validate_python(fill(self.patterns)),
            maintain=conditions.validate_python(fill(self.maintain)),
            after=conditions.validate_python(fill(self.after)),
            goal=fill(self.goal),
        )


# NOTE: a checker takes 20 ms to make, longer than half a tick: made at first use, then kept.
@cache
def _conditions() -> TypeAdapter[tuple[AnyCondition, ...]]:
    return TypeAdapter(tuple[AnyCondition, ...])


@cache
def _patterns() -> TypeAdapter[tuple[BehaviourPattern, ...]]:
    return TypeAdapter(tuple[BehaviourPattern, ...])


@dataclass(frozen=True, slots=True, kw_only=True)
class BoundPacket:
    """A packet's content with its arguments in place."""

    tag: str
    before: tuple[Condition, ...]
    waiting: tuple[BehaviourPattern, ...] = ()
    patterns: tuple[BehaviourPattern, ...]
    maintain: tuple[Condition, ...] = ()
    after: tuple[Condition, ...]
    goal: str | None = None
