"""Dead reckoning that drifts, from the robot's initial pose: by its noisy motion, or by wheel encoders."""

from math import cos, floor, remainder, sin, tau

import numpy as np

from robots.physical.body import Pose
from robots.world.bodies import WheeledBodySpec
from sim.snapshot import EncoderState, OdometryState

SCALE_SIGMA = 0.01  # error of the distance or of the wheels' radius, a constant of the robot, as a share
TURN_SCALE_SIGMA = 0.01  # error of the turn or of the wheels' distance, likewise
UNEVEN_SIGMA = 0.001  # difference of one wheel's radius from the other's, as a share
STEP_SIGMA = 0.02  # random error of the distance in one reading, as a share
TURN_SIGMA = 0.02  # random error of the turn in one reading, as a share
DRIFT_RAD_PER_M = 0.01  # random veer by the distance driven


class Odometry:
    """The pose estimate of a body without wheels, world frame. Sideways slip is not measured."""

    def __init__(self, initial: Pose, true: Pose, rng: np.random.Generator) -> None:
        self._rng = rng
        self.state = OdometryState(
            estimate=initial,
            last=true,
            scale=1 + SCALE_SIGMA * rng.standard_normal(),
            turn_scale=1 + TURN_SCALE_SIGMA * rng.standard_normal(),
        )

    def update(self, true: Pose) -> None:
        """Account for the motion since the last update."""
        state = self.state
        last = state.last
        turn = remainder(true.heading_rad - last.heading_rad, tau)
        middle = last.heading_rad + turn / 2
        ahead = (true.x_m - last.x_m) * cos(middle) + (true.y_m - last.y_m) * sin(middle)
        noise = self._rng.standard_normal(3).tolist()
        measured_ahead = ahead * (state.scale + STEP_SIGMA * noise[0])
        measured_turn = (
            turn * (state.turn_scale + TURN_SIGMA * noise[1]) + DRIFT_RAD_PER_M * abs(ahead) * noise[2]
        )
        state.estimate = advance_pose(state.estimate, measured_ahead, measured_turn)
        state.last = true


class Encoders:
    """The pose estimate of a wheeled body, which counts its wheels' turns: slip on the floor shows as drift.

    It uses the wheels' radius and distance from the world file. The true ones differ a little: these errors are
    constants of the robot, drawn with the seed.
    """

    def __init__(self, spec: WheeledBodySpec, initial: Pose, rng: np.random.Generator) -> None:
        both, left, right, base = rng.standard_normal(4)
        self._count_m = tau * spec.radius_m / spec.counts
        self.state = EncoderState(
            grip=(
                float(1 + SCALE_SIGMA * both + UNEVEN_SIGMA * left),
                float(1 + SCALE_SIGMA * both + UNEVEN_SIGMA * right),
            ),
            believed_base_m=spec.base_m * float(1 + TURN_SCALE_SIGMA * base),
            rolled_m=(0.0, 0.0),
            counted=(0, 0),
            pose=initial,
        )

    def roll(self, rims_m_s: tuple[float, float], step_s: float) -> None:
        """Account for the wheels' turns of one step."""
        state = self.state
        state.rolled_m = (
            state.rolled_m[0] + rims_m_s[0] / state.grip[0] * step_s,
            state.rolled_m[1] + rims_m_s[1] / state.grip[1] * step_s,
        )

    def read(self) -> None:
        """Account for the counts since the last reading."""
        state = self.state
        counted = (floor(state.rolled_m[0] / self._count_m), floor(state.rolled_m[1] / self._count_m))
        left_m = (counted[0] - state.counted[0]) * self._count_m
        right_m = (counted[1] - state.counted[1]) * self._count_m
        state.counted = counted
        state.pose = advance_pose(
            state.pose, (left_m + right_m) / 2, (right_m - left_m) / state.believed_base_m
        )


def advance_pose(pose: Pose, ahead_m: float, turn_rad: float) -> Pose:
    """The pose after driving a short distance while turning, with the mean heading of the two."""
    heading = pose.heading_rad + turn_rad / 2
    return Pose(
        x_m=pose.x_m + ahead_m * cos(heading),
        y_m=pose.y_m + ahead_m * sin(heading),
        heading_rad=remainder(pose.heading_rad + turn_rad, tau),
    )
