"""The parameter file of the ROS 2 adapter: examples/ros2/robot.yaml, docs/ros2.md."""

from pathlib import Path
from typing import Literal

import yaml
from pydantic import Field, ValidationError, model_validator
from typing_extensions import Self

from robots.adapters.packet_forms import PacketForm
from robots.data import Checked, faults_in, read_yaml
from robots.errors import RobotError


class ParameterError(RobotError):
    """Raised when a parameter file cannot be read or is not valid; names the file, line and slot."""


class Place(Checked):
    """A pose in the world's frame: metres and degrees. `dock`: its name in the docking server's data, for DOCK."""

    x_m: float
    y_m: float
    heading_deg: float = 0.0
    dock: str | None = None


class PacketAction(Checked):
    """The action that carries out the packets of a tag.

    `form`: the fields of its goal: those of nav2's NavigateToPose or DockRobot, or of CarryOutPacket, for anything
    else. `place`: the packet's argument that names the place. `repeatable`: the goal may be sent again, because its
    action ends where it would have ended before; such packets can be paused.
    """

    form: Literal["navigate", "dock", "packet"]
    action: str
    type: str
    place: str | None = None
    arguments: tuple[str, ...] = ()
    repeatable: bool = False
    dock_type: str = ""

    @model_validator(mode="after")
    def _has_a_place(self) -> Self:
        if self.form != "packet" and self.place is None:
            raise ValueError(
                f"place: the form {self.form} needs the packet's argument that names the place, say ref2"
            )
        return self


class Topic(Checked):
    """A topic and its type."""

    topic: str
    type: str


class PoseFrame(Checked):
    """The robot's own frame in `/tf`. A transform that is older than `max_age_s` does not count."""

    frame: str = "base_link"
    max_age_s: float = Field(default=2.0, gt=0)


class Ros2Parameters(Checked):
    """One robot. `map_in_world`: the pose of the map's origin in the world's frame, metres and degrees.

    `pose`: a topic that has it, or the robot's frame in `/tf`.
    `speed_m_s`, `turn_rad_s`: what it says of itself. `server_timeout_s`: how long an action server may be away before
    its packet fails. `memory`: the file of its persistent memory.
    """

    world: str
    robot: str
    memory: Path
    map_frame: str = "map"
    map_in_world: tuple[float, float, float] = (0.0, 0.0, 0.0)
    pose: Topic | PoseFrame = Topic(topic="amcl_pose", type="geometry_msgs/msg/PoseWithCovarianceStamped")
    battery: Topic | None = Topic(topic="battery_state", type="sensor_msgs/msg/BatteryState")
    speed_m_s: float = Field(default=0.5, gt=0)
    turn_rad_s: float = Field(default=1.0, gt=0)
    server_timeout_s: float = Field(default=10.0, gt=0)
    places: dict[str, Place]
    packets: dict[str, PacketAction] = Field(min_length=1)

    @property
    def forms(self) -> dict[str, PacketForm]:
        """The forms of the packets that it takes."""
        return {tag: self._form(action) for tag, action in self.packets.items()}

    def _form(self, action: PacketAction) -> PacketForm:
        if action.place is None:
            return PacketForm(arguments=action.arguments)
        return PacketForm(
            arguments=tuple(dict.fromkeys((*action.arguments, action.place))),
            choices={action.place: frozenset(self.places)},
        )


def read_parameters(path: Path) -> Ros2Parameters:
    """:raises ParameterError: naming the file, and the line and slot of each fault."""
    try:
        text = path.read_text(encoding="utf-8")
        return Ros2Parameters.model_validate(read_yaml(text))
    except ValidationError as error:
        lines = "\n  ".join(faults_in(text, error))
        raise ParameterError(f"{path} is not a valid parameter file:\n  {lines}") from error
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise ParameterError(f"{path} cannot be read as a parameter file: {error}") from error
