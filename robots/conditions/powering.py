"""Conditions on the battery, by its own gauge, which always runs."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import ConfigDict, Field

from robots.conditions.verdict import Verdict
from robots.perception.percepts import NOTHING, Needs, Percepts
from robots.reactive.responses import STRICT


@dataclass(frozen=True, slots=True, kw_only=True)
class Charged:
    """The battery holds a share of its charge, or more."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    needs: ClassVar[Needs] = NOTHING
    sense: Literal["charged"] = "charged"
    to: Annotated[float, Field(gt=0, le=1)]

    def check(self, percepts: Percepts) -> Verdict:
        return Verdict(percepts.battery >= self.to, f"has its battery at {percepts.battery:.0%}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Charging:
    """The battery is being charged."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    needs: ClassVar[Needs] = NOTHING
    sense: Literal["charging"] = "charging"

    def check(self, percepts: Percepts) -> Verdict:
        return Verdict(percepts.charging, f"{'is' if percepts.charging else 'is not'} charged")
