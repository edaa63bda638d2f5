"""The seam to ROS 2: what is used of rclpy and of its messages, imported when it is asked for."""

from dataclasses import dataclass
from importlib import import_module
from typing import Any

from robots.errors import RobotError


class RosError(RobotError):
    """Raised when ROS 2, or a type that a parameter file names, cannot be imported; says what to install or source."""


@dataclass(frozen=True, slots=True)
class Ros:
    """A node and what makes clients of it. The types are ROS 2's own, so that tests can put others in their place.

    `action_client`: `rclpy.action.ActionClient`; `cancel_goal`: `action_msgs.srv.CancelGoal`; `uuid`:
    `unique_identifier_msgs.msg.UUID`.
    """

    node: Any
    action_client: Any
    cancel_goal: Any
    uuid: Any

    def type(self, name: str) -> Any:
        """The class of a type such as `nav2_msgs/action/NavigateToPose`.

        :raises RosError: if it is not installed.
        """
        return ros_type(name)


def ros_type(name: str) -> Any:
    """:raises RosError: if the type's package is not installed or sourced, or has no such type."""
    package, _, rest = name.partition("/")
    folder, _, kind = rest.partition("/")
    try:
        return getattr(import_module(f"{package}.{folder}"), kind)
    except (ImportError, AttributeError, ValueError) as error:
        raise RosError(
            f"the ROS 2 type {name} cannot be imported ({error}); install ros-$ROS_DISTRO-{package.replace('_', '-')}, "
            "or build it in a workspace, and source that workspace's setup.bash before macta-robot is started"
        ) from error


def load_ros(node_name: str) -> Ros:
    """Initialise rclpy and make a node.

    :raises RosError: if ROS 2 cannot be imported.
    """
    try:
        rclpy: Any = import_module("rclpy")
    except ImportError as error:
        raise RosError(
            f"rclpy cannot be imported ({error}); source /opt/ros/$ROS_DISTRO/setup.bash, and install macta-robots "
            "into an environment of the same Python that sees ROS 2: python3 -m venv --system-site-packages FOLDER"
        ) from error
    rclpy.init()
    return Ros(
        node=rclpy.create_node(node_name),
        action_client=ros_type("rclpy/action/ActionClient"),
        cancel_goal=ros_type("action_msgs/srv/CancelGoal"),
        uuid=ros_type("unique_identifier_msgs/msg/UUID"),
    )


def spin(ros: Ros, seconds: float) -> None:
    """Run the node's callbacks for at most so long (wall clock)."""
    import_module("rclpy").spin_once(ros.node, timeout_sec=max(0.0, seconds))
