"""Conditions on the gripper."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from robots.conditions.verdict import Verdict
from robots.data import Strict
from robots.perception.percepts import GRIP, NOTHING, TOUCH, Needs, Percepts


@dataclass(frozen=True, slots=True, kw_only=True)
class BetweenJaws(Strict):
    """The jaws' light barrier meets an object."""

    needs: ClassVar[Needs] = GRIP
    sense: Literal["between_jaws"] = "between_jaws"
    object: str

    def check(self, percepts: Percepts) -> Verdict:
        there = percepts.gripper.between_jaws
        return Verdict(there == self.object, f"has {there or 'nothing'} between its jaws")


@dataclass(frozen=True, slots=True, kw_only=True)
class Holding(Strict):
    """Holds an object."""

    needs: ClassVar[Needs] = GRIP
    sense: Literal["holding"] = "holding"
    object: str

    def check(self, percepts: Percepts) -> Verdict:
        return Verdict(percepts.holding == self.object, f"holds {percepts.holding or 'nothing'}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Empty(Strict):
    """The gripper holds nothing. `open`: and its jaws are open."""

    needs: ClassVar[Needs] = GRIP
    sense: Literal["empty"] = "empty"
    open: bool = False

    def check(self, percepts: Percepts) -> Verdict:
        jaws = "closed" if percepts.gripper.closed else "open"
        holds = percepts.holding is None and not (self.open and jaws == "closed")
        return Verdict(holds, f"holds {percepts.holding or 'nothing'}, jaws {jaws}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Bumped(Strict):
    """The bumper has touched something within the last seconds."""

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Charged(Strict):
    """The battery holds a share of its charge, or more."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["charged"] = "charged"
    to: Annotated[float, Field(gt=0, le=1)]

    def check(self, percepts: Percepts) -> Verdict:
        return Verdict(percepts.battery >= self.to, f"has its battery at {percepts.battery:.0%}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Charging(Strict):
    """The battery is being charged."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["charging"] = "charging"

    def check(self, percepts: Percepts) -> Verdict:
        return Verdict(percepts.charging, f"{'is' if percepts.charging else 'is not'} charged")


@dataclass(frozen=True, slots=True, kw_only=True)
class Commanded(Strict):
    """The operator commands it to move; without that it stands, whatever avoidance asks for."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["commanded"] = "commanded"

    def check(self, percepts: Percepts) -> Verdict:
        moves = percepts.drive_command is not None and percepts.drive_command.moves
        return Verdict(moves, f"is {'commanded' if moves else 'not commanded'} to move")


@dataclass(frozen=True, slots=True, kw_only=True)
class NotDriven(Strict):
    """No operator drives it."""

    needs: ClassVar[Needs] = NOTHING
    sense: Literal["not_driven"] = "not_driven"

    def check(self, percepts: Percepts) -> Verdict:
        free = percepts.drive_command is None
        return Verdict(free, f"is {'not ' if free else ''}driven by an operator")
