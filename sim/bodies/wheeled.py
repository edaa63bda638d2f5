"""The wheeled body: differential drive. Motors turn its wheels, and traction on the floor moves it, or does not."""

from math import cos, hypot, remainder, sin, tau

import numpy as np

from robots.body import Pose
from robots.world import RobotSpec
from robots.world.bodies import WheeledBodySpec
from sim.bodies.axle import STILL, Axle, Velocity
from sim.bodies.base import SimulatedBody
from sim.bodies.encoders import Encoders
from sim.physics.jaws import Jaws
from sim.physics.scene import TICK_S, Scene
from sim.snapshot import RampedState, StreamState, WheeledState

LIFTED_M_S, LIFTED_RAD_S = 5.0, 30.0
"""What seems to have moved faster than this was lifted and set down: it stands."""


class WheeledBody(SimulatedBody):
    """Pushes and collisions act through the solver: the axle goes on from the motion that they leave it."""

    def __init__(
        self,
        spec: RobotSpec,
        measures: WheeledBodySpec,
        jaws: Jaws,
        scene: Scene,
        told: Pose,
        rng: np.random.Generator,
    ) -> None:
        super().__init__(spec, jaws)
        self._measures, self._scene, self._rng = measures, scene, rng.spawn(1)[0]
        self._encoders = Encoders(measures, told, rng)
        self._axle = Axle(measures, self._encoders.grip)
        self._last = scene.pose(spec.name)

    @property
    def driven(self) -> tuple[float, float]:
        left, right = self._axle.rims_m_s
        return ((left + right) / 2, (right - left) / self._measures.base_m)

    def drive(self) -> None:
        pose = self._scene.pose(self.spec.name)
        now = self._axle.follow(_moved(self._last, pose))
        self._encoders.roll(self._axle.rims_m_s, TICK_S)
        self._last = pose
        left, right = (self._measures.slip * self._rng.standard_normal(2)).tolist()
        velocity = self._axle.roll(now, *self._wanted, slip=(left, right))
        self._scene.drive(self.spec.name, velocity.ahead_m_s, velocity.turn_rad_s, velocity.left_m_s)

    def count_way(self, true: Pose) -> None:
        self._encoders.read()

    def drive_state(self) -> WheeledState:
        return WheeledState(
            encoders=self._encoders.state(),
            axle=self._axle.state(),
            last=self._last,
            floor=StreamState.of(self._rng),
        )

    def recall_drive(self, state: RampedState | WheeledState) -> None:
        if not isinstance(state, WheeledState):
            raise ValueError(f"{self.spec.name} has wheels, but its snapshot has none")
        self._encoders.recall(state.encoders)
        self._axle.recall(state.axle, self._encoders.grip)
        self._last = state.last
        state.floor.restore(self._rng)

    def touches(self) -> bool:
        return self._scene.touched(self.spec.name)

    def get_position(self) -> Pose:
        return self._encoders.pose


def _moved(last: Pose, now: Pose) -> Velocity:
    """The mean velocity of the last tick, in the frame that the body has now."""
    east, north = (now.x_m - last.x_m) / TICK_S, (now.y_m - last.y_m) / TICK_S
    turn = remainder(now.heading_rad - last.heading_rad, tau) / TICK_S
    if hypot(east, north) > LIFTED_M_S or abs(turn) > LIFTED_RAD_S:
        return STILL
    ahead, left = cos(now.heading_rad), sin(now.heading_rad)
    return Velocity(east * ahead + north * left, north * ahead - east * left, turn)
