"""Bodies without wheels, which take up the velocity they are told.

The velocity-set one is moved by the scene, which stops it where something is in the way.
"""

from robots.body import Pose
from robots.world import RobotSpec
from robots.world.bodies import Ramps
from sim.bodies.base import SimulatedBody, clip
from sim.bodies.odometry import Odometry
from sim.physics.jaws import Jaws
from sim.physics.scene import TICK_S, Scene
from sim.snapshot import RampedState, WheeledState


class RampedBody(SimulatedBody):
    """Commands are held, and followed within limits of speed and acceleration (our choice of measures)."""

    def __init__(self, spec: RobotSpec, ramps: Ramps, jaws: Jaws, scene: Scene, odometry: Odometry) -> None:
        super().__init__(spec, jaws)
        self._ramps, self._scene, self._odometry = ramps, scene, odometry
        self._driven = (0.0, 0.0)

    @property
    def driven(self) -> tuple[float, float]:
        return self._driven

    def count_way(self, true: Pose) -> None:
        self._odometry.update(true)

    def get_position(self) -> Pose:
        return self._odometry.pose

    def drive_state(self) -> RampedState:
        return RampedState(driven=self._driven, odometry=self._odometry.state())

    def recall_drive(self, state: RampedState | WheeledState) -> None:
        if not isinstance(state, RampedState):
            raise ValueError(f"{self.spec.name} has no wheels, but its snapshot has")
        self._driven = state.driven
        self._odometry.recall(state.odometry)

    def _ramp(self) -> None:
        """Go over to the velocity of the coming tick: as near to what is wanted as the ramps allow."""
        limits = (self._ramps.acceleration_m_s2 * TICK_S, self._ramps.turn_acceleration_rad_s2 * TICK_S)
        linear, angular = (
            now + clip(then - now, limit)
            for now, then, limit in zip(self._driven, self._wanted, limits, strict=True)
        )
        self._driven = (linear, angular)


class VelocityBody(RampedBody):
    """Has the velocity it is told, unless something is in the way."""

    def drive(self) -> None:
        self._ramp()
        self._scene.drive(self.spec.name, *self._driven)

    def touches(self) -> bool:
        return self._scene.touched(self.spec.name)
