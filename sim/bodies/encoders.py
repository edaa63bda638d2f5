"""Odometry of a wheeled body: it counts its wheels' turns, so that slip on the floor shows as drift."""

from math import floor, tau

import numpy as np

from robots.physical.body import Pose
from robots.world.bodies import WheeledBodySpec
from sim.bodies.odometry import SCALE_SIGMA, TURN_SCALE_SIGMA, reckoned
from sim.snapshot import EncoderState

UNEVEN_SIGMA = 0.001
"""How much the radius of one wheel is off the other's, as a share."""


class Encoders:
    """Dead reckoning from the pose the robot was told, with the radii and the base that the file names.

    The true ones are a little off: errors are constants of the robot, drawn by the seed.
    """

    def __init__(self, spec: WheeledBodySpec, told: Pose, rng: np.random.Generator) -> None:
        both, left, right, base = rng.standard_normal(4)
        self.grip = (
            float(1 + SCALE_SIGMA * both + UNEVEN_SIGMA * left),
            float(1 + SCALE_SIGMA * both + UNEVEN_SIGMA * right),
        )
        self._believed_base_m = spec.base_m * float(1 + TURN_SCALE_SIGMA * base)
        self._count_m = tau * spec.radius_m / spec.counts
        self._rolled_m = [0.0, 0.0]
        self._counted = (0, 0)
        self.pose = told

    def state(self) -> EncoderState:
        return EncoderState(
            grip=self.grip,
            believed_base_m=self._believed_base_m,
            rolled_m=(self._rolled_m[0], self._rolled_m[1]),
            counted=self._counted,
            pose=self.pose,
        )

    def recall(self, state: EncoderState) -> None:
        self.grip, self._believed_base_m = state.grip, state.believed_base_m
        self._rolled_m, self._counted, self.pose = list(state.rolled_m), state.counted, state.pose

    def roll(self, rims_m_s: tuple[float, float], step_s: float) -> None:
        """The wheels' turns of one step."""
        for wheel in (0, 1):
            self._rolled_m[wheel] += rims_m_s[wheel] / self.grip[wheel] * step_s

    def read(self) -> None:
        """Account for the counts since the last reading."""
        counted = (floor(self._rolled_m[0] / self._count_m), floor(self._rolled_m[1] / self._count_m))
        left_m, right_m = (
            (now - before) * self._count_m for now, before in zip(counted, self._counted, strict=True)
        )
        self._counted = counted
        self.pose = reckoned(self.pose, (left_m + right_m) / 2, (right_m - left_m) / self._believed_base_m)
