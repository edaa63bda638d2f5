"""The form of a packet's content: [sensor pre-conditions, behaviour patterns, sensor post-conditions] (MACTA §3)."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from pydantic import Field, TypeAdapter, model_validator
from typing_extensions import Self

from robots.conditions.composition import AnyCondition
from robots.conditions.motion import Elapsed, Faster, Travelled
from robots.conditions.verdict import Condition
from robots.data import Checked
from robots.reactive.avoidance import AnyAvoidance
from robots.reactive.patterns import BehaviourPattern, Level
from robots.reactive.stall import RETRIES, STALLED_S
from robots.repertoire.parameters import LIMITS, MAX_DISTANCE, MAX_VELOCITY, Parameter, Value
from robots.repertoire.wanted_result import WantedResult
from robots.repertoire.wording import TIMEOUT as TIMEOUT_S
from robots.repertoire.wording import Wording

TOO_FAST = "toofast"
TOO_FAR = "toofar"
TIMEOUT = "timeout"
"""Events that every packet has (SRA fig. 4)."""
PATTERNS = "patterns"
PATTERNS_OF = "patterns_of"
TOO_FAST_FACTOR = 1.1
"""Of the velocity limit; odometry errs by some per cent."""


class PacketSpec(Checked):
    """A packet's content as a template: strings that begin with `$` name arguments, `$me` the robot itself.

    `arguments` must be given, those in `optional` need not; `places` and `robots` say which of the former name what.
    `before` and `after` are the sensor pre- and post-conditions. `basic`: every robot can carry it out.

    Our additions: `waiting`, patterns that act until the pre-conditions hold; `maintain`, conditions whose loss is a
    failure; `goal`, the place or thing that measures progress; `stalled_s`, how long without progress before a retry;
    `retries`, how often (None: no progress is asked for); `retry`, the patterns that act during one, for `retry_s`,
    without any those of the self level. `long`: the content of the tag when `object` is a long one,
    whose handles are "$object@left", "@right" and "@free"; "$place@off" is where to hold off a place. In place of a
    pattern may stand `patterns_of`, all patterns of another packet, with this packet's arguments. `results`: images and
    readings that it takes as it ends.

    SRA's: `parameters`, with the limits of every packet; `target`, an argument that is either an `object` or a
    way-point `x`, `y`; `events`; `avoid`, how obstacles are avoided: by the packet's `patterns`, or by a method of
    `robots.reactive.avoidance`, which replaces the patterns of the environment level.

    `words`: how a person asks for it.
    """

    tag: str = Field(pattern=r"^[A-Z][A-Z0-9_]*$", max_length=64)
    about: str
    basic: bool = False
    arguments: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()
    places: tuple[str, ...] = ()
    robots: tuple[str, ...] = ()
    long: bool = False
    target: bool = False
    parameters: dict[str, Parameter] = Field(default_factory=dict)
    before: tuple[dict[str, Any], ...] = ()
    waiting: tuple[dict[str, Any], ...] = ()
    patterns: tuple[dict[str, Any], ...] = Field(min_length=1)
    maintain: tuple[dict[str, Any], ...] = ()
    after: tuple[dict[str, Any], ...] = Field(min_length=1)
    results: tuple[dict[str, Any], ...] = Field(default=(), max_length=4)
    events: dict[str, tuple[dict[str, Any], ...]] = Field(default_factory=dict)
    avoid: str | dict[str, Any] = PATTERNS
    goal: str | None = None
    retries: int | None = Field(default=RETRIES, ge=0)
    retry: tuple[dict[str, Any], ...] = ()
    retry_s: float = Field(default=0.0, ge=0, le=60)
    stalled_s: float = Field(default=STALLED_S, gt=0)
    words: tuple[Wording, ...] = Field(default=(), max_length=16)

    @model_validator(mode="after")
    def _names_its_arguments(self) -> Self:
        for slot in ("places", "robots"):
            for name in getattr(self, slot):
                if name not in self.arguments:
                    choices = ", ".join(self.arguments) or "none"
                    raise ValueError(f"{slot}: {name} is not one of the arguments; choices: {choices}")
        return self

    @model_validator(mode="after")
    def _words_fill_its_arguments(self) -> Self:
        target = ("object", "x", "y") if self.target else ()
        known = (*self.arguments, *self.optional, *target, *self.parameters, *LIMITS, TIMEOUT_S)
        for one in self.words:
            for name in one.fills():
                if name not in known:
                    raise ValueError(
                        f"words: {name} is no argument or parameter; choices: {', '.join(sorted(known))}"
                    )
        return self

    def with_patterns_of(self, packets: Mapping[str, Sequence[Mapping[str, Any]]]) -> "PacketSpec":
        """The packet with each `patterns_of` replaced by that packet's patterns.

        :param packets: patterns by packet name.
        :raises ValueError: if it names an unknown packet.
        """

        def group(patterns: Iterable[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
            for one in patterns:
                if one.keys() != {PATTERNS_OF}:
                    yield one
                elif str(one[PATTERNS_OF]) in packets:
                    yield from packets[str(one[PATTERNS_OF])]
                else:
                    raise ValueError(
                        f"patterns of {one[PATTERNS_OF]}, which is not a packet of this repertoire"
                    )

        shared = {slot: tuple(group(getattr(self, slot))) for slot in ("waiting", "patterns", "retry")}
        return self.model_copy(update=shared)

    @property
    def name(self) -> str:
        """The key in a repertoire: the tag, marked if the content is for long objects."""
        return f"{self.tag} (long)" if self.long else self.tag

    def defaults(self) -> dict[str, Value]:
        """The default values of its parameters and limits."""
        return {name: one.default for name, one in {**LIMITS, **self.parameters}.items()}

    def bind(self, arguments: Mapping[str, Value], timeout_s: float = 60.0) -> "BoundPacket":
        """The packet for these arguments. Names without an argument are left as they are; parameters have defaults.

        :raises pydantic.ValidationError: if a condition or pattern is malformed.
        """
        values = {**self.defaults(), **arguments, "timeout_s": timeout_s}

        def fill(value: Any) -> Any:
            return filled(value, values)

        conditions = sensor_conditions()
        patterns = behaviour_patterns()
        acting = patterns.validate_python(fill(self.patterns))
        avoid = avoidance_methods().validate_python(named_method(fill(self.avoid)))
        max_velocity_m_s = float(values[MAX_VELOCITY])
        max_distance_m = float(values[MAX_DISTANCE])
        events = {name: conditions.validate_python(fill(one)) for name, one in self.events.items()}
        return BoundPacket(
            tag=self.tag,
            before=conditions.validate_python(fill(self.before)),
            waiting=patterns.validate_python(fill(self.waiting)),
            patterns=tuple(one for one in acting if avoid is None or one.level is not Level.ENVIRONMENT),
            maintain=conditions.validate_python(fill(self.maintain)),
            after=conditions.validate_python(fill(self.after)),
            results=packet_results().validate_python(fill(self.results)),
            events=events | _limits(max_velocity_m_s, max_distance_m, timeout_s),
            avoid=avoid,
            max_velocity_m_s=max_velocity_m_s,
            max_distance_m=max_distance_m,
            goal=fill(self.goal),
            retries=self.retries,
            retry=patterns.validate_python(fill(self.retry)),
            retry_s=self.retry_s,
            stalled_s=self.stalled_s,
        )


def filled(template: Any, values: Mapping[str, Value]) -> Any:
    """A template with its names replaced by their values."""
    if isinstance(template, str) and template.startswith("$"):
        name, at, handle = template[1:].partition("@")
        value = values.get(name, f"${name}")
        return f"{value}@{handle}" if at else value
    if isinstance(template, dict):
        return {key: filled(inner, values) for key, inner in template.items()}
    if isinstance(template, list | tuple):
        return [filled(inner, values) for inner in template]
    return template


def names_in(template: Any) -> Iterator[str]:
    """The names of `$name` strings in a template."""
    if isinstance(template, str) and template.startswith("$"):
        yield template[1:].partition("@")[0]
    elif isinstance(template, Mapping):
        for inner in template.values():
            yield from names_in(inner)
    elif isinstance(template, list | tuple):
        for inner in template:
            yield from names_in(inner)


def _limits(
    max_velocity_m_s: float, max_distance_m: float, timeout_s: float
) -> dict[str, tuple[Condition, ...]]:
    """The events of the base class Behaviour (SRA fig. 4)."""
    return {
        TOO_FAST: (Faster(m_s=TOO_FAST_FACTOR * max_velocity_m_s),),
        TOO_FAR: (Travelled(m=max_distance_m),),
        TIMEOUT: (Elapsed(s=timeout_s),),
    }


# NOTE: a TypeAdapter takes 20 ms to make, half a tick: made at first use, then kept.
@cache
def sensor_conditions() -> TypeAdapter[tuple[AnyCondition, ...]]:
    return TypeAdapter(tuple[AnyCondition, ...])


@cache
def behaviour_patterns() -> TypeAdapter[tuple[BehaviourPattern, ...]]:
    return TypeAdapter(tuple[BehaviourPattern, ...])


@cache
def packet_results() -> TypeAdapter[tuple[WantedResult, ...]]:
    return TypeAdapter(tuple[WantedResult, ...])


@cache
def avoidance_methods() -> TypeAdapter[AnyAvoidance | None]:
    return TypeAdapter(AnyAvoidance | None)


def named_method(avoid: Any) -> Any:
    """The settings of an avoidance method, which may be given by its name alone; None for the patterns."""
    if not isinstance(avoid, str):
        return avoid
    return None if avoid == PATTERNS else {"by": avoid}


@dataclass(frozen=True, slots=True, kw_only=True)
class BoundPacket:
    """A packet's content with its arguments in place."""

    tag: str
    before: tuple[Condition, ...]
    waiting: tuple[BehaviourPattern, ...] = ()
    patterns: tuple[BehaviourPattern, ...]
    maintain: tuple[Condition, ...] = ()
    after: tuple[Condition, ...]
    results: tuple[WantedResult, ...] = ()
    events: Mapping[str, tuple[Condition, ...]] = field(default_factory=dict)
    avoid: AnyAvoidance | None = None
    max_velocity_m_s: float = LIMITS[MAX_VELOCITY].most
    max_distance_m: float = LIMITS[MAX_DISTANCE].most
    goal: str | None = None
    retries: int | None = RETRIES
    retry: tuple[BehaviourPattern, ...] = ()
    retry_s: float = 0.0
    stalled_s: float = STALLED_S

    @property
    def cameras(self) -> frozenset[str]:
        """Those that its results are images of."""
        return frozenset(one.image for one in self.results if one.image is not None)
