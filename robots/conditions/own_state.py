"""Conditions on the robot's own state: gripper, battery and operator."""

from typing import Annotated

from pydantic import Field

from robots.conditions.verdict import Condition, Verdict
from robots.perception.percepts import GRIP, TOUCH, Percepts


class BetweenJaws(Condition, needs=GRIP):
    """The object interrupts the jaws' light barrier."""

    object: str

    def check(self, percepts: Percepts) -> Verdict:
        there = percepts.gripper.between_jaws
        return Verdict(there == self.object, f"has {there or 'nothing'} between its jaws")


class Holding(Condition, needs=GRIP):
    """The gripper holds the object."""

    object: str

    def check(self, percepts: Percepts) -> Verdict:
        return Verdict(percepts.holding == self.object, f"holds {percepts.holding or 'nothing'}")


class Measured(Condition):
    """A sensor of an installed package reads the quantity within these limits; without one it does not hold."""

    quantity: str
    least: float = -1e30
    most: float = 1e30

    @property
    def quantities(self) -> frozenset[str]:
        return frozenset({self.quantity})

    def check(self, percepts: Percepts) -> Verdict:
        value = percepts.measured.get(self.quantity)
        if value is None:
            return Verdict(False, f"measures no {self.quantity}")
        return Verdict(self.least <= value <= self.most, f"measures {self.quantity} {value:g}")


class Empty(Condition, needs=GRIP):
    """The gripper holds nothing; with `open` its jaws must be open, too."""

    open: bool = False

    def check(self, percepts: Percepts) -> Verdict:
        jaws = "closed" if percepts.gripper.closed else "open"
        holds = percepts.holding is None and not (self.open and jaws == "closed")
        return Verdict(holds, f"holds {percepts.holding or 'nothing'}, jaws {jaws}")


class Bumped(Condition, needs=TOUCH):
    """The bumper has touched something within the last seconds."""

    within_s: Annotated[float, Field(ge=0)] = 0.5

    def check(self, percepts: Percepts) -> Verdict:
        if percepts.bumper:
            return Verdict(True, "touches something")
        if percepts.bumped_s is None:
            return Verdict(False, "has touched nothing")
        ago_s = percepts.time_s - percepts.bumped_s
        return Verdict(ago_s <= self.within_s, f"touched something {ago_s:.1f} s ago")


class Charged(Condition):
    """The battery's charge is at least the share `to`."""

    to: Annotated[float, Field(gt=0, le=1)]

    def check(self, percepts: Percepts) -> Verdict:
        return Verdict(percepts.battery >= self.to, f"has its battery at {percepts.battery:.0%}")


class Charging(Condition):
    """The battery is being charged."""

    def check(self, percepts: Percepts) -> Verdict:
        return Verdict(percepts.charging, f"{'is' if percepts.charging else 'is not'} charged")


class Commanded(Condition):
    """The operator's command is to move; without one, obstacle avoidance must not move the robot either."""

    def check(self, percepts: Percepts) -> Verdict:
        moves = percepts.drive_command is not None and percepts.drive_command.moves
        return Verdict(moves, f"is {'commanded' if moves else 'not commanded'} to move")


class NotDriven(Condition):
    """No operator drives the robot."""

    def check(self, percepts: Percepts) -> Verdict:
        free = percepts.drive_command is None
        return Verdict(free, f"is {'not ' if free else ''}driven by an operator")
