"""The seam of obstacle avoidance, and the filter between behaviour synthesis and body."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from math import inf
from typing import NamedTuple, Protocol

from robots.perception.percepts import Percepts, SensingVariant
from robots.reactive.synthesis import DegreeOfFreedom, Motion, Resultants, Utilitor


class Velocity(NamedTuple):
    """Metres a second ahead, radians a second counter-clockwise."""

    linear_m_s: float
    angular_rad_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """The motion that the resultants of the synthesis ask for.

    `direction_rad`: where to, in the robot's frame, (-pi/2, pi/2): the resultant rotate response is an angle (MACTA
    eq. 2). `pace_m_s` is the resultant translate response as a speed, `limits` the body's full speed and turn rate.
    `distance_m`: obstacles farther in that direction are ignored.
    """

    direction_rad: float
    pace_m_s: float
    limits: Velocity
    distance_m: float = inf


class Avoidance(Protocol):
    """One packet's run of a method. Called every tick, to keep its map of the surroundings."""

    def steer(self, wanted: Wanted, percepts: Percepts) -> Velocity:
        """A velocity near the wanted one that is clear of obstacles."""
        ...


class AvoidanceMethod(SensingVariant, ABC):
    """A method and its settings. Data name the subclass and its fields: `avoid: {by: vfh_plus, safety_m: 0.2}`."""

    @abstractmethod
    def begin(self) -> Avoidance:
        """A packet's run begins."""


GOAL_MARGIN_M = 0.15
"""Obstacles at and behind the goal, from this far before it, are ignored."""


@dataclass(frozen=True, slots=True)
class Filter:
    """One packet's avoidance. `goal`: the place or thing that the packet goes to."""

    avoidance: Avoidance
    goal: str | None

    def apply(self, motion: Motion, resultant: Resultants, percepts: Percepts, limits: Velocity) -> Motion:
        """The safe motion. Turns on the spot and backing pass unchanged: both methods choose directions ahead."""
        rotate = resultant.get(DegreeOfFreedom.ROTATE, Utilitor(0.0, 0.0))
        at = percepts.locate(self.goal) if self.goal is not None else None
        wanted = Wanted(
            direction_rad=rotate.r,
            pace_m_s=max(0.0, motion.linear_m_s),
            limits=limits,
            distance_m=inf if at is None else abs(at) - GOAL_MARGIN_M,
        )
        safe = self.avoidance.steer(wanted, percepts)
        if motion.linear_m_s <= 0:
            return motion
        return replace(motion, linear_m_s=safe.linear_m_s, angular_rad_s=safe.angular_rad_s)
