"""A rover's simulated body: implements `robots.body.Body`, and knows no more than a real one would."""

from math import inf

from robots.body import ALL_SENSORS, Pose, Readings, Sensor
from robots.sensing.energy import load_powers
from robots.world import RobotSpec
from sim.battery import Battery
from sim.jaws import Jaws
from sim.odometry import Odometry
from sim.scene import TICK_S

ACCELERATION_M_S2 = 1.0
TURN_ACCELERATION_RAD_S2 = 6.0


class SimulatedBody:
    """Commands are held, and followed within limits of speed and acceleration (our choice of measures)."""

    def __init__(self, spec: RobotSpec, jaws: Jaws, odometry: Odometry) -> None:
        self.spec = spec
        self.odometry = odometry
        self._jaws = jaws
        self._wanted = (0.0, 0.0)
        self._driven = (0.0, 0.0)
        self._readings: Readings | None = None
        self.running = ALL_SENSORS
        self.battery = Battery(load_powers())

    def set_velocity(self, linear_m_s: float, angular_rad_s: float) -> None:
        self._wanted = (
            _clip(linear_m_s, self.spec.speed_m_s),
            _clip(angular_rad_s, self.spec.turn_rad_s),
        )

    def set_gripper(self, *, closed: bool) -> None:
        self._jaws.move(self.spec.name, closed=closed)

    def get_position(self) -> Pose:
        return self.odometry.pose

    def run_sensors(self, sensors: frozenset[Sensor]) -> None:
        self.running = sensors

    def sense(self) -> Readings:
        if self._readings is None:
            raise RuntimeError(f"{self.spec.name} senses before the world's first tick")
        return self._readings

    def refresh(self, readings: Readings) -> None:
        """Hand over what the sensors say at this tick (called by the world)."""
        self._readings = readings

    def accelerate(self) -> tuple[float, float]:
        """The velocity of the coming tick: metres a second ahead, radians a second counter-clockwise."""
        limits = (ACCELERATION_M_S2 * TICK_S, TURN_ACCELERATION_RAD_S2 * TICK_S)
        linear, angular = (
            now + _clip(wanted - now, limit)
            for now, wanted, limit in zip(self._driven, self._wanted, limits, strict=True)
        )
        self._driven = (linear, angular)
        return self._driven

    def spend(self, step_s: float, *, at_home: bool) -> None:
        """Let the battery pay for a step."""
        self.battery.pass_time(step_s, running=self.running, driven=self._driven, at_home=at_home)


def _clip(value: float, limit: float) -> float:
    """Within the limit; a command that is no number stops the motion."""
    return max(-limit, min(limit, value)) if -inf < value < inf else 0.0
