"""The Vector Field Histogram Plus: Ulrich & Borenstein, "VFH+: Reliable obstacle avoidance for fast mobile robots",
ICRA 1998. From a certainty grid to a direction in four stages: primary, binary and masked polar histogram, cost.
"""

from dataclasses import dataclass, field
from math import cos, sqrt, tau
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from robots.perception.percepts import SURROUNDINGS, Percepts
from robots.physical.body import RADIUS_M
from robots.physical.geometry import clip, wrap
from robots.reactive.avoidance.seam import Avoidance, AvoidanceMethod, Velocity, Wanted
from robots.reactive.avoidance.surroundings import Numbers, Points, Surroundings

SECTORS = 72
SECTOR_RAD = tau / SECTORS
Sectors = NDArray[np.bool_]


class VfhPlus(AvoidanceMethod, needs=SURROUNDINGS):
    """Settings. Weights are mu_1 to mu_3 of the cost function; the paper wants mu_1 > mu_2 + mu_3.

    Our choice of scale: an occupied cell at the window's edge has magnitude 1; nearer cells have more.
    """

    target_weight: Annotated[float, Field(ge=0, le=100)] = 5.0
    heading_weight: Annotated[float, Field(ge=0, le=100)] = 2.0
    previous_weight: Annotated[float, Field(ge=0, le=100)] = 2.0
    safety_m: Annotated[float, Field(ge=0.02, le=0.5)] = 0.1
    window_m: Annotated[float, Field(ge=0.4, le=2.0)] = 1.4
    low: Annotated[float, Field(gt=0)] = 0.2
    high: Annotated[float, Field(gt=0)] = 0.5
    wide: Annotated[int, Field(ge=2, le=36)] = 12

    def begin(self) -> Avoidance:
        return VfhPlusRun(self)


@dataclass(slots=True)
class VfhPlusRun:
    """One packet's run. Sectors are directions of odometry's frame, so that they can be compared tick by tick."""

    settings: VfhPlus
    surroundings: Surroundings = field(default_factory=Surroundings)
    _blocked: Sectors = field(default_factory=lambda: np.zeros(SECTORS, dtype=np.bool_))
    previous_rad: float | None = None

    def steer(self, wanted: Wanted, percepts: Percepts) -> Velocity:
        self.surroundings.update(percepts)
        heading = percepts.odometry.heading_rad
        near = self._near(wanted)
        points = self.surroundings.points[near]
        reach = self.surroundings.radii_m[near] + RADIUS_M + self.settings.safety_m
        histogram = self.histogram(points, reach, self.surroundings.certainty[near], heading)
        self._blocked = binary(histogram, self._blocked, low=self.settings.low, high=self.settings.high)
        masked = self._blocked | masked_sectors(points, reach, heading, _turning_radius(wanted, percepts))
        target = wrap(heading + wanted.direction_rad)
        course = self.course(masked, target, heading)
        if course is None:
            return Velocity(0.0, self._search(wanted))
        self.previous_rad = course
        return self._drive(wrap(course - heading), wanted, points, reach)

    def histogram(self, points: Points, reach_m: Numbers, certainty: Numbers, heading: float) -> Numbers:
        """The primary polar histogram: magnitudes c^2 (a - b d^2) of the cells, each over the sectors that the robot's
        width about it covers (eqs 1-5).

        :param points: shape (K,), robot's frame; `reach_m`: (K,), robot's radius and safety beyond each.
        :returns: shape (SECTORS,).
        """
        far = np.abs(points)
        magnitude = certainty**2 * (1 + np.maximum(0.0, self.settings.window_m**2 - far**2))
        half = np.arcsin(np.clip(reach_m / np.maximum(far, 1e-6), 0.0, 1.0))
        off = np.angle(np.exp(1j * (_directions()[:, None] - heading)) * np.conj(points)[None, :])
        covered: NDArray[np.bool_] = np.abs(off) <= half[None, :]
        return np.asarray(covered @ magnitude, dtype=np.float64)

    def course(self, blocked: Sectors, target: float, heading: float) -> float | None:
        """The candidate direction of least cost (eqs 9-11), odometry's frame; None if all are blocked."""
        candidates = candidate_directions(blocked, target, self.settings.wide)
        if not candidates:
            return None
        previous = self.previous_rad if self.previous_rad is not None else heading
        weights = self._weights()
        aims = (target, heading, previous)

        def cost(candidate: float) -> float:
            return sum(w * abs(wrap(candidate - aim)) for w, aim in zip(weights, aims, strict=True))

        return min(candidates, key=cost)

    def _weights(self) -> tuple[float, float, float]:
        return self.settings.target_weight, self.settings.heading_weight, self.settings.previous_weight

    def _near(self, wanted: Wanted) -> NDArray[np.bool_]:
        points = self.surroundings.points
        along = (points * np.exp(-1j * wanted.direction_rad)).real
        return np.asarray((np.abs(points) <= self.settings.window_m) & (along < wanted.distance_m))

    def _search(self, wanted: Wanted) -> float:
        """The turn rate on the spot while every direction is blocked, always to one side."""
        return (1.0 if wanted.direction_rad >= 0 else -1.0) * 0.5 * wanted.limits.angular_rad_s

    def _drive(self, turn: float, wanted: Wanted, points: Points, reach_m: Numbers) -> Velocity:
        """The velocity towards the course, reduced with the turn and with the free distance ahead.

        Our choice: the paper leaves the speed open.
        """
        gap_m = free_way_m(points, reach_m - 0.5 * self.settings.safety_m)
        pace = min(wanted.pace_m_s, sqrt(max(0.0, gap_m)) * 0.8) * max(0.0, cos(turn)) ** 2
        rate = wanted.limits.angular_rad_s
        return Velocity(pace, clip(2.0 * turn, -rate, rate))


def binary(histogram: Numbers, before: Sectors, *, low: float, high: float) -> Sectors:
    """The binary polar histogram: blocked above `high`, free below `low`, else as before (eq. 6)."""
    return np.asarray((histogram > high) | (before & (histogram >= low)))


def masked_sectors(points: Points, reach_m: Numbers, heading: float, radius_m: float) -> Sectors:
    """The directions that obstacles on the robot's narrowest arc to either side make unreachable (eqs 7-8).

    :param radius_m: of the narrowest arc at the present speed; 0 turns on the spot, which masks nothing.
    """
    masked = np.zeros(SECTORS, dtype=np.bool_)
    if radius_m <= 0:
        return masked
    off = np.angle(np.exp(1j * (_directions() - heading)))
    bearings = np.angle(points)
    for side in (1, -1):
        on_arc = np.abs(points - side * 1j * radius_m) < radius_m + reach_m
        met = side * bearings[on_arc & (side * bearings > 0)]
        if met.size:
            masked |= side * off > met.min()
    return masked


def candidate_directions(blocked: Sectors, target: float, wide: int) -> list[float]:
    """The directions worth a cost: the middle of narrow openings, both edges of wide ones with half of `wide` kept
    from them, and the target's own if it lies between (eqs 9-10).
    """
    if not blocked.any():
        return [target]
    found: list[float] = []
    shifted = np.roll(blocked, -int(np.argmax(blocked)))  # begins with a blocked sector
    first = int(np.argmax(blocked))
    edges = np.flatnonzero(np.diff(np.concatenate([shifted, [True]]).astype(np.int8)))
    for right, left in zip(edges[::2] + 1, edges[1::2], strict=True):
        low = (first + right) * SECTOR_RAD
        high = (first + left) * SECTOR_RAD
        if left - right < wide:
            found.append(wrap((low + high) / 2))
            continue
        low = low + wide / 2 * SECTOR_RAD
        high = high - wide / 2 * SECTOR_RAD
        found += [wrap(low), wrap(high)]
        if (target - low) % tau <= high - low:
            found.append(target)
    return found


def free_way_m(points: Points, reach_m: Numbers) -> float:
    """The free distance straight ahead, given the clearance around each point; inf if nothing is in the way."""
    ahead = (points.real > 0) & (np.abs(points.imag) < reach_m)
    if not ahead.any():
        return float("inf")
    met = points[ahead].real - np.sqrt(reach_m[ahead] ** 2 - points[ahead].imag ** 2)
    return float(np.min(met))


def _turning_radius(wanted: Wanted, percepts: Percepts) -> float:
    speed_m_s = percepts.progress.speed_m_s
    return speed_m_s / wanted.limits.angular_rad_s if speed_m_s > 0.05 else 0.0


def _directions() -> Numbers:
    return np.asarray(np.arange(SECTORS) * SECTOR_RAD, dtype=np.float64)
