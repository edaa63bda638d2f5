"""The seam of obstacle avoidance: what is wanted, and who makes it safe."""

from dataclasses import dataclass
from math import inf
from typing import NamedTuple, Protocol

from robots.perception.percepts import Percepts


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
