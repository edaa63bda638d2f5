"""Conditions on what an operator who drives the robot wishes."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from pydantic import ConfigDict

from robots.conditions.verdict import Verdict
from robots.perception.percepts import NOTHING, Needs, Percepts
from robots.reactive.responses import STRICT


@dataclass(frozen=True, slots=True, kw_only=True)
class Wished:
    """The operator wishes it to move; without that it stands, however near something is."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    needs: ClassVar[Needs] = NOTHING
    sense: Literal["wished"] = "wished"

    def check(self, percepts: Percepts) -> Verdict:
        moves = percepts.wish is not None and percepts.wish.moves
        return Verdict(moves, f"is {'wished' if moves else 'not wished'} to move")


@dataclass(frozen=True, slots=True, kw_only=True)
class LetGo:
    """No operator drives it."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    needs: ClassVar[Needs] = NOTHING
    sense: Literal["let_go"] = "let_go"

    def check(self, percepts: Percepts) -> Verdict:
        free = percepts.wish is None
        return Verdict(free, "is let go of" if free else "is driven by an operator")
