"""The normalised functions f_r and f_u of a stimulus (MACTA eq. 1, table 2)."""

from abc import ABC, abstractmethod
from math import copysign, sqrt
from typing import Annotated

from pydantic import Field

from robots.data import ChosenBy, NamedVariant
from robots.extensions import RESPONSES

MAX_GAIN = 20.0


class Response(NamedVariant, ABC):
    """f_r or f_u; data choose a subclass by its name as the form: `{form: linear, gain: 0.5}`."""

    @abstractmethod
    def at(self, s: float) -> float:
        """The value for a stimulus in [-1, 1]."""


class Constant(Response):
    """A constant, independent of the stimulus: table 2's `translate`."""

    value: Annotated[float, Field(ge=-1, le=1)]

    def at(self, s: float) -> float:
        return self.value


class Linear(Response):
    """gain * s + offset, clipped to [-limit, limit]."""

    gain: Annotated[float, Field(ge=-MAX_GAIN, le=MAX_GAIN)] = 1.0
    offset: Annotated[float, Field(ge=-1, le=1)] = 0.0
    limit: Annotated[float, Field(ge=0, le=1)] = 1.0

    def at(self, s: float) -> float:
        return max(-self.limit, min(self.limit, self.gain * s + self.offset))


class Size(Response):
    """min(1, gain * |s|): a utility that grows with the stimulus on either side."""

    gain: Annotated[float, Field(ge=-MAX_GAIN, le=MAX_GAIN)] = 1.0

    def at(self, s: float) -> float:
        return min(1.0, self.gain * abs(s))


class Quick(Response):
    """sign(s) * sqrt|s|, or sqrt|s| as a utility: table 2's "under-damped", steep at 0."""

    signed: bool = True

    def at(self, s: float) -> float:
        root = sqrt(min(1.0, abs(s)))
        return copysign(root, s) if self.signed else root


class Slow(Response):
    """sign(s) * (1 - sqrt(1 - |s|)): our reading of table 2's "over-damped", flat at 0."""

    def at(self, s: float) -> float:
        return copysign(1 - sqrt(1 - min(1.0, abs(s))), s)


class Full(Response):
    """sign(s): our reading of table 2's `s1 + 1`, which is at least 1 for any proximity."""

    def at(self, s: float) -> float:
        return copysign(1.0, s) if s else 0.0


AnyResponse = Annotated[Response, ChosenBy("form", RESPONSES)]
