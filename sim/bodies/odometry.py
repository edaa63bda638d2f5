"""Dead reckoning that drifts: from the pose the robot was told, by its wheels' noisy account of motion."""

from math import cos, remainder, sin, tau

import numpy as np

from robots.physical.body import Pose
from sim.snapshot import OdometryState

SCALE_SIGMA = 0.01  # error of the wheels' radius, a constant of the robot
TURN_SCALE_SIGMA = 0.01
STEP_SIGMA = 0.02  # random error, share of the way in one reading
TURN_SIGMA = 0.02
DRIFT_RAD_PER_M = 0.01  # random veer by the way driven


class Odometry:
    """The robot's own idea of its pose, world frame. Sideways slip is not felt by wheels."""

    def __init__(self, told: Pose, true: Pose, rng: np.random.Generator) -> None:
        self._estimate, self._last, self._rng = told, true, rng
        self._scale = 1 + SCALE_SIGMA * rng.standard_normal()
        self._turn_scale = 1 + TURN_SCALE_SIGMA * rng.standard_normal()

    @property
    def pose(self) -> Pose:
        return self._estimate

    def state(self) -> OdometryState:
        return OdometryState(
            estimate=self._estimate, last=self._last, scale=self._scale, turn_scale=self._turn_scale
        )

    def recall(self, state: OdometryState) -> None:
        self._estimate, self._last = state.estimate, state.last
        self._scale, self._turn_scale = state.scale, state.turn_scale

    def update(self, true: Pose) -> None:
        """Account for the motion since the last update."""
        turn = remainder(true.heading_rad - self._last.heading_rad, tau)
        middle = self._last.heading_rad + turn / 2
        ahead = (true.x_m - self._last.x_m) * cos(middle) + (true.y_m - self._last.y_m) * sin(middle)
        noise = self._rng.standard_normal(3)
        felt_ahead = ahead * (self._scale + STEP_SIGMA * noise[0])
        felt_turn = (
            turn * (self._turn_scale + TURN_SIGMA * noise[1]) + DRIFT_RAD_PER_M * abs(ahead) * noise[2]
        )
        self._estimate = reckoned(self._estimate, felt_ahead, felt_turn)
        self._last = true


def reckoned(pose: Pose, ahead_m: float, turn_rad: float) -> Pose:
    """The pose after a short way ahead while turning."""
    heading = pose.heading_rad + turn_rad / 2
    return Pose(
        x_m=pose.x_m + ahead_m * cos(heading),
        y_m=pose.y_m + ahead_m * sin(heading),
        heading_rad=remainder(pose.heading_rad + turn_rad, tau),
    )
