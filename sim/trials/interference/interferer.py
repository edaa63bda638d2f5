"""Puts obstacles in front of the moving robot, as the experimenters did (P-SMPA §6), and records what it detects."""

from cmath import phase
from dataclasses import dataclass
from enum import StrEnum
from math import tau

import numpy as np

from robots.physical.body import RADIUS_M, Pose
from robots.physical.geometry import to_robot, to_world
from sim.clock import CONTROL_S
from sim.trials.interference.corridor import DOOR_M, ROBOT, START_M, WIDTH_M
from sim.world.simulation import Simulation

THRESHOLD_M = 0.5
"""Range below which an obstacle counts as detected (P-SMPA §6.1)."""
BOX_SIDE_M = 0.3
BOX_HEIGHT_M = 0.8
BALL_RADIUS_M = 0.05
ROLLING_M_S2 = 0.9
"""How fast the floor slows a rolling ball down: a robot brakes at 1 m/s², and the paper does not describe its floor."""
GAP_M = (0.3, 0.48)
"""Distance of an obstacle from the hull: within the threshold, and enough to stop for a robot that detects it."""
BESIDE_M = 0.1
FROM_WALL_M = 0.35
PASSED_M = 0.4
STAYS_S = 8.0
"""An obstacle is removed when the robot is past it, or after this time."""
MOVING_M_S = 0.15
LAST_M = 2.2
"""Distance of the last obstacle from the door."""


class Kind(StrEnum):
    """An obstacle, by the sensor that must detect it."""

    BOX = "sonar"
    """A tall box."""
    BALL = "bumper"
    """A small ball."""


@dataclass(slots=True, kw_only=True)
class Interference:
    """One obstacle in the way: from when to when, and whether the robot detected it in time."""

    since_s: float
    until_s: float = 0.0
    detected: bool = False
    touched: bool = False


class Interferer:
    """Puts one obstacle after the other before the robot, at places of its way that a seed decides."""

    def __init__(self, simulation: Simulation, kind: Kind, times: int, seed: int) -> None:
        self._simulation = simulation
        self._kind = kind
        self._rng = np.random.default_rng([seed, times, kind is Kind.BOX])
        section_m = (DOOR_M - LAST_M - START_M) / times
        shares = self._rng.uniform(0.2, 0.8, times)
        self._marks_m = [START_M + section_m * (n + float(share)) for n, share in enumerate(shares)]
        self._body: int | None = None
        self._last: Pose = simulation.scene.pose(ROBOT)
        self.done: list[Interference] = []

    def act(self) -> None:
        """One control tick: put an obstacle down, or take it away."""
        pose = self._simulation.scene.pose(ROBOT)
        now_s = self._simulation.clock.now_s()
        ahead_m = to_robot(self._last, complex(pose.x_m, pose.y_m)).real
        self._last = pose
        if self._body is None:
            due = len(self.done) < len(self._marks_m) and pose.x_m >= self._marks_m[len(self.done)]
            if due and ahead_m >= MOVING_M_S * CONTROL_S:
                self._put(pose, now_s)
        elif self._past(pose) or now_s - self.done[-1].since_s > STAYS_S:
            self._simulation.scene.remove(self._body)
            self._body = None
            self.done[-1].until_s = now_s

    def note_contact(self) -> None:
        """One tick of the world: note whether the robot runs into the obstacle."""
        if self._body is not None and self._simulation.scene.meets(ROBOT, self._body):
            self.done[-1].touched = True

    def note_detection(self) -> None:
        """One control tick, after the robot has sensed: note whether it detects the obstacle.

        The box counts if the sonar beam that points at it reads less than the threshold before the robot runs into it;
        the ball if the bumper reports the contact.
        """
        if self._body is None:
            return
        readings = self._simulation.bodies[ROBOT].sense()
        now = self.done[-1]
        if self._kind is Kind.BALL:
            now.detected |= now.touched and bool(readings.bumper)
        elif readings.ranges_m is not None and not now.touched:
            offset = to_robot(self._simulation.scene.pose(ROBOT), complex(*self._obstacle_point()))
            beams = len(readings.ranges_m)
            beam = round(phase(offset) * beams / tau) % beams
            now.detected |= bool(readings.ranges_m[beam] < THRESHOLD_M)

    def _put(self, pose: Pose, now_s: float) -> None:
        gap_m = self._rng.uniform(*GAP_M)
        beside_m = self._rng.uniform(-BESIDE_M, BESIDE_M)
        half_m = BOX_SIDE_M / 2 if self._kind is Kind.BOX else BALL_RADIUS_M
        at = to_world(pose, complex(RADIUS_M + gap_m + half_m, beside_m))
        if not FROM_WALL_M < at.imag < WIDTH_M - FROM_WALL_M:
            return
        scene = self._simulation.scene
        point = (at.real, at.imag)
        if self._kind is Kind.BOX:
            self._body = scene.put_box(point, pose.heading_rad, side_m=BOX_SIDE_M, height_m=BOX_HEIGHT_M)
        else:
            self._body = scene.put_ball(point, radius_m=BALL_RADIUS_M, rolling_m_s2=ROLLING_M_S2)
        self.done.append(Interference(since_s=now_s))

    def _past(self, pose: Pose) -> bool:
        return self._obstacle_point()[0] < pose.x_m - PASSED_M

    def _obstacle_point(self) -> tuple[float, float]:
        assert self._body is not None
        return self._simulation.scene.point_of(self._body)
