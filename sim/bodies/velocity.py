"""The velocity-set body: the scene gives it the velocity it is told, and stops it where something is in the way."""

from robots.body import Pose
from robots.world import RobotSpec
from robots.world.bodies import Ramps
from sim.bodies.odometry import Odometry
from sim.bodies.simulated import SimulatedBody, clip
from sim.jaws import Jaws
from sim.scene import TICK_S, Scene


class VelocityBody(SimulatedBody):
    """Commands are held, and followed within limits of speed and acceleration (our choice of measures)."""

    def __init__(self, spec: RobotSpec, ramps: Ramps, jaws: Jaws, scene: Scene, odometry: Odometry) -> None:
        super().__init__(spec, jaws)
        self._ramps, self._scene, self._odometry = ramps, scene, odometry
        self._driven = (0.0, 0.0)

    @property
    def driven(self) -> tuple[float, float]:
        return self._driven

    def drive(self) -> None:
        self._driven = ramped(self._driven, self._wanted, self._ramps)
        self._scene.drive(self.spec.name, *self._driven)

    def count_way(self, true: Pose) -> None:
        self._odometry.update(true)

    def touches(self) -> bool:
        return self._scene.touched(self.spec.name)

    def get_position(self) -> Pose:
        return self._odometry.pose


def ramped(driven: tuple[float, float], wanted: tuple[float, float], ramps: Ramps) -> tuple[float, float]:
    """The velocity one tick later: as near to what is wanted as the ramps allow."""
    limits = (ramps.acceleration_m_s2 * TICK_S, ramps.turn_acceleration_rad_s2 * TICK_S)
    linear, angular = (
        now + clip(then - now, limit) for now, then, limit in zip(driven, wanted, limits, strict=True)
    )
    return linear, angular
