"""Conditions on the gripper."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from pydantic import ConfigDict

from robots.conditions.verdict import Verdict
from robots.perception.percepts import GRIP, Needs, Percepts
from robots.reactive.responses import STRICT


@dataclass(frozen=True, slots=True, kw_only=True)
class BetweenJaws:
    """The jaws' light barrier meets an object."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    needs: ClassVar[Needs] = GRIP
    sense: Literal["between_jaws"] = "between_jaws"
    object: str

    def check(self, percepts: Percepts) -> Verdict:
        there = percepts.gripper.between_jaws
        return Verdict(there == self.object, f"has {there or 'nothing'} between its jaws")


@dataclass(frozen=True, slots=True, kw_only=True)
class Holding:
    """Holds an object."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    needs: ClassVar[Needs] = GRIP
    sense: Literal["holding"] = "holding"
    object: str

    def check(self, percepts: Percepts) -> Verdict:
        return Verdict(percepts.holding == self.object, f"holds {percepts.holding or 'nothing'}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Empty:
    """The gripper holds nothing. `open`: and its jaws are open."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    needs: ClassVar[Needs] = GRIP
    sense: Literal["empty"] = "empty"
    open: bool = False

    def check(self, percepts: Percepts) -> Verdict:
        jaws = "closed" if percepts.gripper.closed else "open"
        holds = percepts.holding is None and not (self.open and jaws == "closed")
        return Verdict(holds, f"holds {percepts.holding or 'nothing'}, jaws {jaws}")
