"""The seam of obstacle avoidance: what is wanted, and who makes it safe."""

from dataclasses import dataclass, replace
from math import inf
from typing import NamedTuple, Protocol

from robots.perception.percepts import Percepts
from robots.reactive.synthesis import DegreeOfFreedom, Motion, Resultants, Utilitor


class Velocity(NamedTuple):
    """Metres a second ahead, radians a second counter-clockwise."""

    linear_m_s: float
    angular_rad_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """What the resultants of the synthesis ask for.

    `direction_rad`: where to, in the robot's frame, (-pi/2, pi/2): the resultant rotate response is an angle (MACTA
    eq. 2). `pace_m_s` is the resultant translate response as a speed, `limits` the body's full speed and turn rate.
    `distance_m`: what lies farther in that direction is not in the way.
    """

    direction_rad: float
    pace_m_s: float
    limits: Velocity
    distance_m: float = inf


class Avoidance(Protocol):
    """One packet's run of a method. Called every tick, so that it learns its surroundings; paces above 0 only."""

    def steer(self, wanted: Wanted, percepts: Percepts) -> Velocity:
        """The velocity to drive at: near to what is wanted, and clear of what is in the way."""
        ...


BEFORE_M = 0.15
"""The goal itself is not in the way, nor is what lies behind it."""


@dataclass(frozen=True, slots=True)
class Filter:
    """One packet's avoidance. `goal`: the place or thing that the packet leads to."""

    avoidance: Avoidance
    goal: str | None

    def apply(self, motion: Motion, resultant: Resultants, percepts: Percepts, limits: Velocity) -> Motion:
        """The motion made safe. Turns on the spot and backing pass: both methods choose ways ahead."""
        rotate = resultant.get(DegreeOfFreedom.ROTATE, Utilitor(0.0, 0.0))
        at = percepts.locate(self.goal) if self.goal is not None else None
        wanted = Wanted(
            direction_rad=rotate.r,
            pace_m_s=max(0.0, motion.linear_m_s),
            limits=limits,
            distance_m=inf if at is None else abs(at) - BEFORE_M,
        )
        safe = self.avoidance.steer(wanted, percepts)
        if motion.linear_m_s <= 0:
            return motion
        return replace(motion, linear_m_s=safe.linear_m_s, angular_rad_s=safe.angular_rad_s)
