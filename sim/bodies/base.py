"""What all simulated bodies share: the command that is held, gripper, sensors, battery."""

from abc import ABC, abstractmethod
from math import inf

from robots.physical.body import ALL_SENSORS, Pose, Readings, Sensor
from robots.physical.energy import load_powers
from robots.physical.sonar import Activity, cascade
from robots.world import RobotSpec
from sim.bodies.battery import Battery
from sim.physics.jaws import Jaws
from sim.snapshot import BodyState, RampedState, WheeledState


class SimulatedBody(ABC):
    """Implements `robots.physical.body.Body`, and knows no more than a real one would."""

    def __init__(self, spec: RobotSpec, jaws: Jaws) -> None:
        self.spec = spec
        self._jaws = jaws
        self._wanted = (0.0, 0.0)
        self._readings: Readings | None = None
        self._activities: list[Activity] = []
        self.running = ALL_SENSORS
        self.battery = Battery(load_powers(), level=spec.battery)

    @property
    @abstractmethod
    def driven(self) -> tuple[float, float]:
        """How its drive moves it: metres a second ahead, radians a second counter-clockwise."""

    @abstractmethod
    def drive(self) -> None:
        """Move for the coming tick, or have the scene move it (called by the world before each tick)."""

    @abstractmethod
    def count_way(self, true: Pose) -> None:
        """Bring odometry up to date (called by the world before it senses)."""

    @abstractmethod
    def touches(self) -> bool:
        """True while it presses against something."""

    @abstractmethod
    def get_position(self) -> Pose: ...

    @abstractmethod
    def drive_state(self) -> RampedState | WheeledState:
        """What to go on with of its drive and odometry."""

    @abstractmethod
    def recall_drive(self, state: RampedState | WheeledState) -> None:
        """:raises ValueError: if it is another kind's."""

    def state(self) -> BodyState:
        return BodyState(
            wanted=self._wanted,
            running=self.running,
            left_j=self.battery.left_j,
            charging=self.battery.charging,
            drive=self.drive_state(),
        )

    def recall(self, state: BodyState) -> None:
        """Go on as the body of a snapshot.

        :raises ValueError: if it is of another kind.
        """
        self._wanted, self.running = state.wanted, state.running
        self.battery.recall(state.left_j, charging=state.charging)
        self.recall_drive(state.drive)

    def set_velocity(self, linear_m_s: float, angular_rad_s: float) -> None:
        """Take a command, and hold it until the next; with an empty battery it is to stop."""
        drives = self.battery.level > 0
        self._wanted = (
            clip(linear_m_s, self.spec.speed_m_s * drives),
            clip(angular_rad_s, self.spec.turn_rad_s * drives),
        )

    def set_gripper(self, *, closed: bool) -> None:
        self._jaws.move(self.spec.name, closed=closed)

    def run_sensors(self, sensors: frozenset[Sensor]) -> None:
        self.running = sensors

    def sense(self) -> Readings:
        if self._readings is None:
            raise RuntimeError(f"{self.spec.name} senses before the world's first tick")
        return self._readings

    def install(self, activity: Activity) -> None:
        """Set up, at the start, a module that senses after those that are there; the first are the sensors' drivers."""
        self._activities.append(activity)

    def refresh(self, readings: Readings) -> None:
        """Hand over what the sensors' drivers say at this tick (called by the world)."""
        self._readings = cascade(readings, self._activities)

    def spend(self, step_s: float, *, at_home: bool) -> None:
        """Let the battery pay for a step."""
        self.battery.pass_time(step_s, running=self.running, driven=self.driven, at_home=at_home)


def clip(value: float, limit: float) -> float:
    """Within the limit; a command that is no number stops the motion."""
    return max(-limit, min(limit, value)) if -inf < value < inf else 0.0
