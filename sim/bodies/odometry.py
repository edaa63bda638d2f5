"""Dead reckoning that drifts, from the pose the robot was told: by noisy motion, or by counts of the wheels' turns."""

from math import cos, floor, remainder, sin, tau

import numpy as np

from robots.physical.body import Pose
from robots.world.bodies import WheeledBodySpec
from sim.snapshot import EncoderState, OdometryState

SCALE_SIGMA = 0.01  # error of the wheels' radius, a constant of the robot
TURN_SCALE_SIGMA = 0.01
UNEVEN_SIGMA = 0.001  # difference of one wheel's radius from the other's, as a share
STEP_SIGMA = 0.02  # random error, share of the distance in one reading
TURN_SIGMA = 0.02
DRIFT_RAD_PER_M = 0.01  # random veer by the distance driven


class Odometry:
    """The pose estimate of a body without wheels, world frame. Sideways slip is not measured."""

    def __init__(self, told: Pose, true: Pose, rng: np.random.Generator) -> None:
        self.pose = told
        self._last = true
        self._rng = rng
        self._scale = 1 + SCALE_SIGMA * rng.standard_normal()
        self._turn_scale = 1 + TURN_SCALE_SIGMA * rng.standard_normal()

    def state(self) -> OdometryState:
        return OdometryState(
            estimate=self.pose, last=self._last, scale=self._scale, turn_scale=self._turn_scale
        )

    def restore(self, state: OdometryState) -> None:
        self.pose = state.estimate
        self._last = state.last
        self._scale = state.scale
        self._turn_scale = state.turn_scale

    def update(self, true: Pose) -> None:
        """Account for the motion since the last update."""
        turn = remainder(true.heading_rad - self._last.heading_rad, tau)
        middle = self._last.heading_rad + turn / 2
        ahead = (true.x_m - self._last.x_m) * cos(middle) + (true.y_m - self._last.y_m) * sin(middle)
        noise = self._rng.standard_normal(3)
        measured_ahead = ahead * (self._scale + STEP_SIGMA * noise[0])
        measured_turn = (
            turn * (self._turn_scale + TURN_SIGMA * noise[1]) + DRIFT_RAD_PER_M * abs(ahead) * noise[2]
        )
        self.pose = advanced(self.pose, measured_ahead, measured_turn)
        self._last = true


class Encoders:
    """The pose estimate of a wheeled body, which counts its wheels' turns: slip on the floor shows as drift.

    It reckons with the radii and the base of the world file. The true ones differ a little: errors are constants of
    the robot, drawn by the seed.
    """

    def __init__(self, spec: WheeledBodySpec, told: Pose, rng: np.random.Generator) -> None:
        both, left, right, base = rng.standard_normal(4)
        self.grip = (
            float(1 + SCALE_SIGMA * both + UNEVEN_SIGMA * left),
            float(1 + SCALE_SIGMA * both + UNEVEN_SIGMA * right),
        )
        """True radius of each wheel as a share of the nominal one."""
        self.pose = told
        self._believed_base_m = spec.base_m * float(1 + TURN_SCALE_SIGMA * base)
        self._count_m = tau * spec.radius_m / spec.counts
        self._rolled_m = (0.0, 0.0)
        self._counted = (0, 0)

    def state(self) -> EncoderState:
        return EncoderState(
            grip=self.grip,
            believed_base_m=self._believed_base_m,
            rolled_m=self._rolled_m,
            counted=self._counted,
            pose=self.pose,
        )

    def restore(self, state: EncoderState) -> None:
        self.grip = state.grip
        self.pose = state.pose
        self._believed_base_m = state.believed_base_m
        self._rolled_m = state.rolled_m
        self._counted = state.counted

    def roll(self, rims_m_s: tuple[float, float], step_s: float) -> None:
        """Account for the wheels' turns of one step."""
        self._rolled_m = (
            self._rolled_m[0] + rims_m_s[0] / self.grip[0] * step_s,
            self._rolled_m[1] + rims_m_s[1] / self.grip[1] * step_s,
        )

    def read(self) -> None:
        """Account for the counts since the last reading."""
        counted = (floor(self._rolled_m[0] / self._count_m), floor(self._rolled_m[1] / self._count_m))
        left_m = (counted[0] - self._counted[0]) * self._count_m
        right_m = (counted[1] - self._counted[1]) * self._count_m
        self._counted = counted
        self.pose = advanced(self.pose, (left_m + right_m) / 2, (right_m - left_m) / self._believed_base_m)


def advanced(pose: Pose, ahead_m: float, turn_rad: float) -> Pose:
    """The pose after a short distance ahead while turning."""
    heading = pose.heading_rad + turn_rad / 2
    return Pose(
        x_m=pose.x_m + ahead_m * cos(heading),
        y_m=pose.y_m + ahead_m * sin(heading),
        heading_rad=remainder(pose.heading_rad + turn_rad, tau),
    )
