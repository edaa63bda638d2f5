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
    `unique_identifier_msgs.msg.UUID`; `sensor_qos`: `rclpy.qos.qos_profile_sensor_data`, which receives from publishers
    of any reliability; `buffer`: a `tf2_ros.Buffer` that `listener` fills, None if it is not wanted; `newest`:
    `rclpy.time.Time()`, which stands for the newest transform; `transform_error`: `tf2_ros.TransformException`.
    """

    node: Any
    action_client: Any
    cancel_goal: Any
    uuid: Any
    sensor_qos: Any
    buffer: Any = None
    listener: Any = None
    newest: Any = None
    transform_error: type[Exception] = Exception

    def type(self, name: str) -> Any:
        """The class of a type such as `nav2_msgs/action/NavigateToPose`.

        :raises RosError: if it is not installed.
        """
        return ros_type(name)

    def transform(self, target: str, source: str, *, max_age_s: float) -> Any:
        """The newest geometry_msgs/TransformStamped from a frame to another; None if there is none that is not older.

        A transform with the stamp 0 is static.
        """
        try:
            found = self.buffer.lookup_transform(target, source, self.newest)
        except self.transform_error:
            return None
        stamp_s = found.header.stamp.sec + found.header.stamp.nanosec * 1e-9
        now_s = self.node.get_clock().now().nanoseconds * 1e-9
        return found if stamp_s == 0 or now_s - stamp_s <= max_age_s else None


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


def load_ros(node_name: str, *, transforms: bool = False) -> Ros:
    """Initialise rclpy and make a node.

    :param transforms: it listens to `/tf`.
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
    node = rclpy.create_node(node_name)
    return Ros(
        node=node,
        action_client=ros_type("rclpy/action/ActionClient"),
        cancel_goal=ros_type("action_msgs/srv/CancelGoal"),
        uuid=ros_type("unique_identifier_msgs/msg/UUID"),
        sensor_qos=import_module("rclpy.qos").qos_profile_sensor_data,
        **(_transforms(node) if transforms else {}),
    )


def _transforms(node: Any) -> dict[str, Any]:
    """What of tf2_ros looks transforms up.

    :raises RosError: if it is not installed.
    """
    try:
        tf2_ros: Any = import_module("tf2_ros")
    except ImportError as error:
        raise RosError(f"tf2_ros cannot be imported ({error}); install ros-$ROS_DISTRO-tf2-ros-py") from error
    buffer = tf2_ros.Buffer()
    return {
        "buffer": buffer,
        "listener": tf2_ros.TransformListener(buffer, node),
        "newest": import_module("rclpy.time").Time(),
        "transform_error": tf2_ros.TransformException,
    }


def spin(ros: Ros, seconds: float) -> None:
    """Run the node's callbacks for at most so long (wall clock)."""
    import_module("rclpy").spin_once(ros.node, timeout_sec=max(0.0, seconds))
