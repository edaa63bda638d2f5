"""The wheeled body: differential drive. Motors turn its wheels, and traction on the floor moves it, or does not."""

from dataclasses import replace
from math import cos, hypot, remainder, sin, tau

import numpy as np

from robots.physical.body import GRIPPER_REACH_M, Pose
from robots.world import RobotSpec
from robots.world.bodies import WheeledBodySpec
from sim.bodies.axle import STILL, Axle, Velocity
from sim.bodies.base import SimulatedBody
from sim.bodies.odometry import Encoders
from sim.clock import TICK_S
from sim.physics.beam import Load
from sim.physics.jaws import Jaws
from sim.physics.scene import ROVER_INERTIA_KG_M2, ROVER_MASS_KG, Scene
from sim.snapshot import RampedState, StreamState, WheeledState

LIFTED_M_S = 5.0
LIFTED_RAD_S = 30.0
"""A body that seems to have moved faster than this was lifted and set down: it stands."""


class WheeledBody(SimulatedBody):
    """Pushes and collisions act through the solver: the axle continues from the motion the solver leaves."""

    def __init__(
        self,
        spec: RobotSpec,
        wheels: WheeledBodySpec,
        jaws: Jaws,
        scene: Scene,
        told: Pose,
        rng: np.random.Generator,
    ) -> None:
        super().__init__(spec, jaws, scene)
        self._wheels = wheels
        self._rng = rng.spawn(1)[0]
        self._encoders = Encoders(wheels, told, rng)
        self._axle = Axle(wheels, self._encoders.state.grip)
        self._last = scene.pose(spec.name)

    @property
    def driven(self) -> tuple[float, float]:
        left, right = self._axle.state.rims_m_s
        return ((left + right) / 2, (right - left) / self._wheels.base_m)

    def drive(self) -> None:
        pose = self._scene.pose(self.spec.name)
        pulled = _pulled(_mean_velocity(self._last, pose), self._jaws.load(self.spec.name))
        now = self._axle.follow(pulled)
        self._encoders.roll(self._axle.state.rims_m_s, TICK_S)
        self._last = pose
        left, right = (self._wheels.slip * self._rng.standard_normal(2)).tolist()
        velocity = self._axle.roll(now, *self._command, slip=(left, right))
        self._scene.drive(self.spec.name, velocity.ahead_m_s, velocity.turn_rad_s, velocity.left_m_s)

    def update_odometry(self, true: Pose) -> None:
        self._encoders.read()

    def get_position(self) -> Pose:
        return self._encoders.state.pose

    def drive_state(self) -> WheeledState:
        return WheeledState(
            encoders=replace(self._encoders.state),
            axle=replace(self._axle.state),
            last=self._last,
            floor=StreamState.of(self._rng),
        )

    def restore_drive(self, state: RampedState | WheeledState) -> None:
        if not isinstance(state, WheeledState):
            raise ValueError(f"{self.spec.name} has wheels, but its snapshot has none")
        self._encoders.state = replace(state.encoders)
        self._axle.state = replace(state.axle)
        self._axle.grip = state.encoders.grip
        self._last = state.last
        state.floor.restore(self._rng)


def _pulled(now: Velocity, load: Load) -> Velocity:
    """The chassis' velocity after a tick of what the object on its capture head exerts."""
    torque_n_m = load.torque_n_m + GRIPPER_REACH_M * load.force_n.imag
    return Velocity(
        now.ahead_m_s + load.force_n.real / ROVER_MASS_KG * TICK_S,
        now.left_m_s + load.force_n.imag / ROVER_MASS_KG * TICK_S,
        now.turn_rad_s + torque_n_m / ROVER_INERTIA_KG_M2 * TICK_S,
    )


def _mean_velocity(last: Pose, now: Pose) -> Velocity:
    """The mean velocity of the last tick, in the body's present frame."""
    east_m_s = (now.x_m - last.x_m) / TICK_S
    north_m_s = (now.y_m - last.y_m) / TICK_S
    turn_rad_s = remainder(now.heading_rad - last.heading_rad, tau) / TICK_S
    if hypot(east_m_s, north_m_s) > LIFTED_M_S or abs(turn_rad_s) > LIFTED_RAD_S:
        return STILL
    cosine = cos(now.heading_rad)
    sine = sin(now.heading_rad)
    return Velocity(east_m_s * cosine + north_m_s * sine, north_m_s * cosine - east_m_s * sine, turn_rad_s)
