"""Between the synthesis and the body: obstacle avoidance as a filter on the resultants."""

from dataclasses import dataclass, replace
from math import inf

from robots.perception.percepts import Percepts
from robots.reactive.avoidance.seam import Avoidance, Velocity, Wanted
from robots.reactive.synthesis import DegreeOfFreedom, Motion, Resultants, Utilitor

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
