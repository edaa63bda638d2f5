"""The base class of simulated bodies: held command, gripper, sensors, battery."""

from abc import ABC, abstractmethod
from dataclasses import replace
from math import inf
from typing import Protocol

from robots.physical.body import ALL_SENSORS, Image, Pose, Readings
from robots.physical.energy import load_powers
from robots.physical.sonar import Activity, cascade
from robots.world import RobotSpec
from sim.bodies.battery import Battery
from sim.physics.jaws import Jaws
from sim.physics.scene import Scene
from sim.snapshot import BodyState, RampedState, WheeledState


class Camera(Protocol):
    """A simulated camera."""

    def take(self) -> Image: ...


class SimulatedBody(ABC):
    """Implements `robots.physical.body.Body`; knows no more than a real one. Subclasses decide how it moves."""

    def __init__(self, spec: RobotSpec, jaws: Jaws, scene: Scene) -> None:
        self.spec = spec
        self.running: frozenset[str] = ALL_SENSORS
        self.battery = Battery(load_powers(), capacity_wh=spec.battery_wh, level=spec.battery)
        self._jaws = jaws
        self._scene = scene
        self._command = (0.0, 0.0)
        self._readings: Readings | None = None
        self._activities: list[Activity] = []
        self._cameras: dict[str, Camera] = {}

    @property
    @abstractmethod
    def driven(self) -> tuple[float, float]:
        """The drive's velocity: metres a second ahead, radians a second counter-clockwise."""

    @property
    def is_commanded(self) -> bool:
        """True while it holds a command to move."""
        return self._command != (0.0, 0.0)

    @abstractmethod
    def drive(self) -> None:
        """Move for the coming tick, or set the velocity in the scene (called before each tick)."""

    @abstractmethod
    def update_odometry(self, true: Pose) -> None:
        """Bring odometry up to date (called before the world senses)."""

    def touches(self) -> bool:
        """True while it presses against something."""
        return self._scene.touched(self.spec.name)

    @abstractmethod
    def get_position(self) -> Pose: ...

    @abstractmethod
    def drive_state(self) -> RampedState | WheeledState:
        """State of its drive and odometry, for a snapshot."""

    @abstractmethod
    def restore_drive(self, state: RampedState | WheeledState) -> None:
        """:raises ValueError: if it is another kind's."""

    def state(self) -> BodyState:
        return BodyState(
            wanted=self._command,
            running=self.running,
            left_j=self.battery.left_j,
            charging=self.battery.charging,
            drive=self.drive_state(),
        )

    def restore(self, state: BodyState) -> None:
        """Go on in this state. A drive of another kind is that of the robot's former body: this one begins at rest."""
        self._command = state.wanted
        self.running = state.running
        self.battery.left_j = state.left_j
        self.battery.charging = state.charging
        if isinstance(state.drive, type(self.drive_state())):
            self.restore_drive(state.drive)

    def set_velocity(self, linear_m_s: float, angular_rad_s: float) -> None:
        """Take a command, and hold it until the next; with an empty battery the command is to stop.

        On a slope the body drives at a share of the commanded speed.
        """
        powered = self.battery.level > 0
        self._command = (
            clip(linear_m_s, self.spec.speed_m_s * powered) * self._scene.pace(self.spec.name),
            clip(angular_rad_s, self.spec.turn_rad_s * powered),
        )

    def set_gripper(self, *, closed: bool) -> None:
        self._jaws.move(self.spec.name, closed=closed)

    def run_sensors(self, sensors: frozenset[str]) -> None:
        self.running = sensors

    def sense(self) -> Readings:
        if self._readings is None:
            raise RuntimeError(f"{self.spec.name} senses before the world's first tick")
        return self._readings

    def install(self, activity: Activity) -> None:
        """Add a module that senses after those already installed; the sensors' drivers come first."""
        self._activities.append(activity)

    def install_camera(self, name: str, camera: Camera) -> None:
        """Add a camera, which takes an image in each tick in which it runs."""
        self._cameras[name] = camera

    def refresh(self, readings: Readings) -> None:
        """Take the sensors' readings of this tick (called by the world)."""
        self._readings = cascade(readings, self._activities)
        if taken := {name: self._cameras[name].take() for name in self._cameras.keys() & self.running}:
            self._readings = replace(self._readings, images=taken)

    def drain_battery(self, step_s: float, *, at_charger: bool) -> None:
        """Account for the energy of a step."""
        self.battery.advance(step_s, running=self.running, driven=self.driven, at_charger=at_charger)


def clip(value: float, limit: float) -> float:
    """Clamp to the limit; a command that is not a finite number stops the motion."""
    return max(-limit, min(limit, value)) if -inf < value < inf else 0.0
