"""Bodies without wheels, which follow the commanded velocity within limits of acceleration.

The velocity-set body is moved by the scene, which stops it where something is in the way.
"""

from dataclasses import replace

from robots.physical.body import GRIPPER_REACH_M, Pose
from robots.world import RobotSpec
from robots.world.bodies import Ramps
from sim.bodies.base import SimulatedBody, clip
from sim.bodies.odometry import Odometry
from sim.clock import TICK_S
from sim.physics.jaws import Jaws
from sim.physics.scene import Scene
from sim.snapshot import RampedState, WheeledState


class RampedBody(SimulatedBody):
    """Holds commands, and follows them within limits of speed and acceleration (the values are our choice)."""

    def __init__(self, spec: RobotSpec, ramps: Ramps, jaws: Jaws, scene: Scene, odometry: Odometry) -> None:
        super().__init__(spec, jaws, scene)
        self._limits = (ramps.acceleration_m_s2 * TICK_S, ramps.turn_acceleration_rad_s2 * TICK_S)
        self._odometry = odometry
        self._driven = (0.0, 0.0)

    @property
    def driven(self) -> tuple[float, float]:
        return self._driven

    def update_odometry(self, true: Pose) -> None:
        self._odometry.update(true)

    def get_position(self) -> Pose:
        return self._odometry.state.estimate

    def drive_state(self) -> RampedState:
        return RampedState(driven=self._driven, odometry=replace(self._odometry.state))

    def restore_drive(self, state: RampedState | WheeledState) -> None:
        if not isinstance(state, RampedState):
            raise ValueError(f"{self.spec.name} has no wheels, but its snapshot has")
        self._driven = state.driven
        self._odometry.state = replace(state.odometry)

    def _ramp(self) -> None:
        """Set the velocity of the coming tick: as near to the command as the ramps allow."""
        linear, angular = self._driven
        wanted_linear, wanted_angular = self._command
        max_linear, max_angular = self._limits
        self._driven = (
            linear + clip(wanted_linear - linear, max_linear),
            angular + clip(wanted_angular - angular, max_angular),
        )


GIVES_M_S_N = 0.004
"""How much slower or faster a drive is for each newton on the capture head (our choice)."""
GIVES_RAD_S_N_M = 0.01
"""The same of turning, for each newton metre about the body's middle."""


class VelocityBody(RampedBody):
    """Has the commanded velocity, unless something is in the way.

    What hangs on its capture head drags it along while it drives; while it stands, its brakes hold it.
    """

    def drive(self) -> None:
        self._ramp()
        linear_m_s, angular_rad_s = self._driven
        if self._driven != (0.0, 0.0):
            load = self._jaws.load(self.spec.name)
            linear_m_s += GIVES_M_S_N * load.force_n.real
            angular_rad_s += GIVES_RAD_S_N_M * (load.torque_n_m + GRIPPER_REACH_M * load.force_n.imag)
        self._scene.drive(self.spec.name, linear_m_s, angular_rad_s)
