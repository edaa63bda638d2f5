"""Conditions on what the hull feels."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from pydantic import ConfigDict, Field

from robots.conditions.verdict import Verdict
from robots.perception.percepts import TOUCH, Needs, Percepts
from robots.reactive.responses import STRICT


@dataclass(frozen=True, slots=True, kw_only=True)
class Bumped:
    """The bumper has touched something within the last seconds."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    needs: ClassVar[Needs] = TOUCH
    sense: Literal["bumped"] = "bumped"
    within_s: float = Field(default=0.5, ge=0)

    def check(self, percepts: Percepts) -> Verdict:
        if percepts.bumper:
            return Verdict(True, "touches something")
        if percepts.bumped_s is None:
            return Verdict(False, "has touched nothing")
        ago_s = percepts.time_s - percepts.bumped_s
        return Verdict(ago_s <= self.within_s, f"touched something {ago_s:.1f} s ago")
