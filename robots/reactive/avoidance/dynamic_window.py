"""The dynamic window: Fox, Burgard & Thrun, "The dynamic window approach to collision avoidance", IEEE Robotics &
Automation Magazine 4(1), 1997. Of the velocities the robot can reach within a moment, and from which it can still
stop, the one that heads best, keeps clearest and drives fastest.
"""

from dataclasses import dataclass, field
from math import pi
from typing import Annotated

import numpy as np
from pydantic import Field

from robots.perception.percepts import SURROUNDINGS, Percepts
from robots.physical.body import RADIUS_M
from robots.reactive.avoidance.seam import Avoidance, AvoidanceMethod, Velocity, Wanted
from robots.reactive.avoidance.surroundings import Numbers, Points, Surroundings

LINEAR = 7
ANGULAR = 21
"""Numbers of speeds and turn rates that are sampled in the window."""
TOUCH_M = 0.005


class DynamicWindow(AvoidanceMethod, needs=SURROUNDINGS):
    """Settings: weights alpha, beta, gamma of the objective (eq. 13), and what the body can do."""

    heading_weight: Annotated[float, Field(ge=0, le=100)] = 1.0
    clearance_weight: Annotated[float, Field(ge=0, le=100)] = 1.0
    velocity_weight: Annotated[float, Field(ge=0, le=100)] = 0.5
    safety_m: Annotated[float, Field(ge=0.02, le=0.5)] = 0.1
    horizon_m: Annotated[float, Field(ge=0.3, le=2.0)] = 1.0
    window_s: Annotated[float, Field(ge=0.05, le=1.0)] = 0.25
    acceleration_m_s2: Annotated[float, Field(gt=0, le=10)] = 1.0
    turn_acceleration_rad_s2: Annotated[float, Field(gt=0, le=60)] = 6.0

    def begin(self) -> Avoidance:
        return DynamicWindowRun(self)


@dataclass(slots=True)
class DynamicWindowRun:
    """One packet's run."""

    settings: DynamicWindow
    surroundings: Surroundings = field(default_factory=Surroundings)

    def steer(self, wanted: Wanted, percepts: Percepts) -> Velocity:
        self.surroundings.update(percepts)
        now = Velocity(percepts.progress.speed_m_s, percepts.progress.turn_rad_s)
        linear, angular = self.window(now, wanted)
        points, reach_m = self._near(wanted)
        coast = self.coast(angular)
        clear_m = np.minimum(clearance_m(linear, angular, coast, points, reach_m), self.settings.horizon_m)
        value = self.objective(linear, coast, clear_m, wanted)
        value[~self.admissible(linear, angular, clear_m)] = -np.inf
        best = np.unravel_index(int(np.argmax(value)), value.shape)
        if value[best] == -np.inf:
            return Velocity(0.0, 0.5 * wanted.limits.angular_rad_s * (1 if wanted.direction_rad >= 0 else -1))
        return Velocity(float(linear[best]), float(angular[best]))

    def window(self, now: Velocity, wanted: Wanted) -> tuple[Numbers, Numbers]:
        """The velocities that can be reached within the window (eq. 15): two arrays (LINEAR, ANGULAR)."""
        s = self.settings
        rate = wanted.limits.angular_rad_s
        gain = s.acceleration_m_s2 * s.window_s
        turn = s.turn_acceleration_rad_s2 * s.window_s
        top = max(0.0, wanted.pace_m_s)
        speeds = np.clip(np.linspace(now.linear_m_s - gain, now.linear_m_s + gain, LINEAR), 0.0, top)
        rates = np.clip(np.linspace(now.angular_rad_s - turn, now.angular_rad_s + turn, ANGULAR), -rate, rate)
        linear, angular = np.meshgrid(speeds, rates, indexing="ij")
        return linear, angular

    def admissible(self, linear: Numbers, angular: Numbers, clear_m: Numbers) -> np.ndarray:
        """The velocities from which the robot can stop before an obstacle (eq. 14)."""
        s = self.settings
        radius = linear / np.maximum(np.abs(angular), 1e-6)
        clear_rad = clear_m / np.maximum(radius, 1e-6)
        return np.asarray(
            (linear <= np.sqrt(2 * clear_m * s.acceleration_m_s2))
            & ((linear < 1e-6) | (np.abs(angular) <= np.sqrt(2 * clear_rad * s.turn_acceleration_rad_s2)))
        )

    def coast(self, angular: Numbers) -> Numbers:
        """The angle that the robot turns within the window and while it then brakes to rest, radians."""
        s = self.settings
        return angular * s.window_s + angular * np.abs(angular) / (2 * s.turn_acceleration_rad_s2)

    def objective(self, linear: Numbers, coast: Numbers, clear_m: Numbers, wanted: Wanted) -> Numbers:
        """sigma(alpha heading + beta dist + gamma velocity), each normalised to [0, 1] (eq. 13)."""
        s = self.settings
        off = np.abs(np.angle(np.exp(1j * (wanted.direction_rad - coast))))
        heading = 1 - off / pi
        top = max(wanted.limits.linear_m_s, 1e-6)
        value = (
            s.heading_weight * heading
            + s.clearance_weight * clear_m / s.horizon_m
            + s.velocity_weight * linear / top
        )
        return smooth(value)

    def _near(self, wanted: Wanted) -> tuple[Points, Numbers]:
        """The obstacle points within the horizon, and the clearance required around each.

        Our choice: around a point that is nearer than that, the present distance is required.
        """
        here = self.surroundings
        along = (here.points * np.exp(-1j * wanted.direction_rad)).real
        near = (np.abs(here.points) <= self.settings.horizon_m + 0.5) & (along < wanted.distance_m)
        near &= here.certainty > 0.3
        points = here.points[near]
        reach_m = here.radii_m[near] + RADIUS_M + self.settings.safety_m
        return points, np.minimum(reach_m, np.maximum(np.abs(points) - TOUCH_M, 1e-3))


def clearance_m(
    linear: Numbers, angular: Numbers, coast: Numbers, points: Points, reach_m: Numbers
) -> Numbers:
    """How far each velocity's arc can be followed ("dist"): inf if it meets nothing.

    A round robot that turns on the spot meets nothing. Our choice: for such a turn the free distance straight ahead
    after it counts; otherwise standing still in front of an obstacle would score best.

    :param linear: any shape; `angular`, and `coast`, the turn until rest, alike.
    :param points: shape (K,), robot's frame; `reach_m` alike.
    :returns: shape of `linear`, metres along the arc.
    """
    if not points.size:
        return np.full(linear.shape, np.inf)
    speed = linear[..., None]
    rate = angular[..., None]
    straight = np.abs(rate) < 1e-3
    still = speed < 1e-6
    radius = np.abs(speed / np.where(straight, 1.0, rate))
    mirrored = np.where(rate >= 0, points, np.conj(points))  # every arc turns left, about (0, radius)
    from_middle = mirrored - 1j * radius
    away = np.abs(from_middle)
    met = (np.abs(away - radius) < reach_m) & (radius > 1e-6)
    half = np.arccos(np.clip((radius**2 + away**2 - reach_m**2) / np.maximum(2 * radius * away, 1e-9), -1, 1))
    turn = (np.angle(from_middle * 1j) - half) % (2 * pi)
    on_arc = np.where(met, radius * turn, np.inf)
    turned = points * np.exp(-1j * np.where(still, coast[..., None], 0.0))
    ahead = (np.abs(turned.imag) < reach_m) & (turned.real > 0)
    on_line = np.where(ahead, turned.real - np.sqrt(np.maximum(reach_m**2 - turned.imag**2, 0.0)), np.inf)
    far = np.where(straight | still, np.maximum(on_line, 0.0), on_arc)
    return np.asarray(far.min(axis=-1))


def smooth(value: Numbers) -> Numbers:
    """sigma: the mean over neighbouring velocities, which keeps more clearance beside obstacles; shape as given."""
    padded = np.pad(value, 1, mode="edge")
    rows = (padded[:-2] + padded[1:-1] + padded[2:]) / 3
    return np.asarray((rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]) / 3)
