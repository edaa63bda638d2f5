"""The normalised functions f_r and f_u of a stimulus (MACTA eq. 1, table 2)."""

from dataclasses import dataclass
from math import copysign, sqrt
from typing import Annotated, Literal, Protocol

from pydantic import Field

from robots.data import Strict

MAX_GAIN = 20.0


class Response(Protocol):
    """f_r or f_u."""

    def at(self, s: float) -> float: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Constant(Strict):
    """The same whatever is sensed: table 2's `translate`."""

    form: Literal["constant"] = "constant"
    value: Annotated[float, Field(ge=-1, le=1)]

    def at(self, s: float) -> float:
        return self.value


@dataclass(frozen=True, slots=True, kw_only=True)
class Linear(Strict):
    """gain * s + offset, clipped to `limit` either way."""

    form: Literal["linear"] = "linear"
    gain: Annotated[float, Field(ge=-MAX_GAIN, le=MAX_GAIN)] = 1.0
    offset: Annotated[float, Field(ge=-1, le=1)] = 0.0
    limit: Annotated[float, Field(ge=0, le=1)] = 1.0

    def at(self, s: float) -> float:
        return max(-self.limit, min(self.limit, self.gain * s + self.offset))


@dataclass(frozen=True, slots=True, kw_only=True)
class Size(Strict):
    """|s|: a utility that grows with the stimulus on either side."""

    form: Literal["size"] = "size"
    gain: Annotated[float, Field(ge=-MAX_GAIN, le=MAX_GAIN)] = 1.0

    def at(self, s: float) -> float:
        return min(1.0, self.gain * abs(s))


@dataclass(frozen=True, slots=True, kw_only=True)
class Quick(Strict):
    """sign(s) * sqrt|s|, or sqrt|s| as a utility: table 2's "under-damped", steep at 0."""

    form: Literal["quick"] = "quick"
    signed: bool = True

    def at(self, s: float) -> float:
        root = sqrt(min(1.0, abs(s)))
        return copysign(root, s) if self.signed else root


@dataclass(frozen=True, slots=True, kw_only=True)
class Slow(Strict):
    """sign(s) * (1 - sqrt(1 - |s|)): our reading of table 2's "over-damped", flat at 0."""

    form: Literal["slow"] = "slow"

    def at(self, s: float) -> float:
        return copysign(1 - sqrt(1 - min(1.0, abs(s))), s)


@dataclass(frozen=True, slots=True, kw_only=True)
class Full(Strict):
    """sign(s) (our reading of table 2's `s1 + 1`, which no proximity keeps below 1)."""

    form: Literal["full"] = "full"

    def at(self, s: float) -> float:
        return copysign(1.0, s) if s else 0.0


AnyResponse = Annotated[Constant | Linear | Size | Quick | Slow | Full, Field(discriminator="form")]
