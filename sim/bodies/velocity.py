"""The velocity-set body: the scene gives it the velocity it is told, and stops it where something is in the way."""

from robots.body import Pose
from robots.world import RobotSpec
from sim.bodies.odometry import Odometry
from sim.bodies.simulated import SimulatedBody, clip
from sim.jaws import Jaws
from sim.scene import TICK_S, Scene

ACCELERATION_M_S2 = 1.0
TURN_ACCELERATION_RAD_S2 = 6.0


class VelocityBody(SimulatedBody):
    """Commands are held, and followed within limits of speed and acceleration (our choice of measures)."""

    def __init__(self, spec: RobotSpec, jaws: Jaws, scene: Scene, odometry: Odometry) -> None:
        super().__init__(spec, jaws)
        self._scene, self._odometry = scene, odometry
        self._driven = (0.0, 0.0)

    @property
    def driven(self) -> tuple[float, float]:
        return self._driven

    def drive(self) -> None:
        self._driven = accelerated(self._driven, self._wanted)
        self._scene.drive(self.spec.name, *self._driven)

    def count_way(self, true: Pose) -> None:
        self._odometry.update(true)

    def touches(self) -> bool:
        return self._scene.touched(self.spec.name)

    def get_position(self) -> Pose:
        return self._odometry.pose


def accelerated(driven: tuple[float, float], wanted: tuple[float, float]) -> tuple[float, float]:
    """The velocity one tick later: as near to what is wanted as acceleration allows."""
    linear, angular = (
        now + clip(then - now, limit * TICK_S)
        for now, then, limit in zip(
            driven, wanted, (ACCELERATION_M_S2, TURN_ACCELERATION_RAD_S2), strict=True
        )
    )
    return linear, angular
