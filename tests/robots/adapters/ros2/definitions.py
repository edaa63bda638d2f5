"""The fields of the ROS 2 types that the adapter touches, with their types, and messages that hold to them.

They are those of the packages' definitions in Humble and in Jazzy: common_interfaces, rcl_interfaces,
unique_identifier_msgs, nav2_msgs, and for Humble opennav_docking_msgs, which has DockRobot there. As with ROS 2's own
Python messages, a field that a type does not have cannot be set, nor one to a value of another type; an int is no
float.
"""

from collections.abc import Mapping
from enum import Enum
from typing import Any

Fields = Mapping[str, str]
"""Types by the names of fields."""


class Distribution(Enum):
    """Of ROS 2."""

    HUMBLE = "humble"
    """Ubuntu 22.04, Python 3.10."""
    JAZZY = "jazzy"
    """Ubuntu 24.04, Python 3.12."""


MESSAGES: Mapping[str, Fields] = {
    "builtin_interfaces/msg/Time": {"sec": "int", "nanosec": "int"},
    "builtin_interfaces/msg/Duration": {"sec": "int", "nanosec": "int"},
    "std_msgs/msg/Empty": {},
    "std_msgs/msg/Header": {"stamp": "builtin_interfaces/msg/Time", "frame_id": "str"},
    "geometry_msgs/msg/Point": {"x": "float", "y": "float", "z": "float"},
    "geometry_msgs/msg/Vector3": {"x": "float", "y": "float", "z": "float"},
    "geometry_msgs/msg/Quaternion": {"x": "float", "y": "float", "z": "float", "w": "float=1"},
    "geometry_msgs/msg/Pose": {
        "position": "geometry_msgs/msg/Point",
        "orientation": "geometry_msgs/msg/Quaternion",
    },
    "geometry_msgs/msg/PoseStamped": {"header": "std_msgs/msg/Header", "pose": "geometry_msgs/msg/Pose"},
    "geometry_msgs/msg/PoseWithCovariance": {"pose": "geometry_msgs/msg/Pose", "covariance": "float[]"},
    "geometry_msgs/msg/PoseWithCovarianceStamped": {
        "header": "std_msgs/msg/Header",
        "pose": "geometry_msgs/msg/PoseWithCovariance",
    },
    "geometry_msgs/msg/Transform": {
        "translation": "geometry_msgs/msg/Vector3",
        "rotation": "geometry_msgs/msg/Quaternion",
    },
    "geometry_msgs/msg/TransformStamped": {
        "header": "std_msgs/msg/Header",
        "child_frame_id": "str",
        "transform": "geometry_msgs/msg/Transform",
    },
    "geometry_msgs/msg/Twist": {
        "linear": "geometry_msgs/msg/Vector3",
        "angular": "geometry_msgs/msg/Vector3",
    },
    "geometry_msgs/msg/TwistWithCovariance": {"twist": "geometry_msgs/msg/Twist", "covariance": "float[]"},
    "nav_msgs/msg/Odometry": {
        "header": "std_msgs/msg/Header",
        "child_frame_id": "str",
        "pose": "geometry_msgs/msg/PoseWithCovariance",
        "twist": "geometry_msgs/msg/TwistWithCovariance",
    },
    "sensor_msgs/msg/BatteryState": {
        "header": "std_msgs/msg/Header",
        **dict.fromkeys(
            ("voltage", "temperature", "current", "charge", "capacity", "design_capacity", "percentage"),
            "float",
        ),
        **dict.fromkeys(
            ("power_supply_status", "power_supply_health", "power_supply_technology"),
            "int",
        ),
        "present": "bool",
        "cell_voltage": "float[]",
        "cell_temperature": "float[]",
        "location": "str",
        "serial_number": "str",
    },
    "unique_identifier_msgs/msg/UUID": {"uuid": "int[]"},
    "action_msgs/msg/GoalInfo": {
        "goal_id": "unique_identifier_msgs/msg/UUID",
        "stamp": "builtin_interfaces/msg/Time",
    },
    "action_msgs/srv/CancelGoal_Request": {"goal_info": "action_msgs/msg/GoalInfo"},
    "GetResult_Request": {"goal_id": "unique_identifier_msgs/msg/UUID"},
}
NAVIGATE = "nav2_msgs/action/NavigateToPose"
CARRY_OUT = "my_robot_interfaces/action/CarryOutPacket"
DOCK = {
    Distribution.HUMBLE: "opennav_docking_msgs/action/DockRobot",
    Distribution.JAZZY: "nav2_msgs/action/DockRobot",
}
DOCKED: Fields = {"success": "bool=1", "error_code": "int", "num_retries": "int"}
DOCKING_GOAL: Fields = {
    "use_dock_id": "bool=1",
    "dock_id": "str",
    "dock_pose": "geometry_msgs/msg/PoseStamped",
    "dock_type": "str",
    "max_staging_time": "float=1000",
    "navigate_to_staging_pose": "bool=1",
}
CARRYING: Mapping[str, Fields] = {
    "Goal": {
        "packet_id": "str",
        "tag": "str",
        "argument_names": "str[]",
        "argument_values": "str[]",
        "timeout_s": "float",
    },
    "Result": {"success": "bool", "reason": "str", "perceived": "str[]"},
    "Feedback": {"events": "str[]"},
}
ERROR: Fields = {"error_code": "int", "error_msg": "str"}


def actions(distribution: Distribution) -> Mapping[str, Mapping[str, Fields]]:
    """The fields of each action's goal, result and feedback."""
    is_humble = distribution is Distribution.HUMBLE
    return {
        NAVIGATE: {
            "Goal": {"pose": "geometry_msgs/msg/PoseStamped", "behavior_tree": "str"},
            "Result": {"result": "std_msgs/msg/Empty"} if is_humble else ERROR,
            "Feedback": {
                "current_pose": "geometry_msgs/msg/PoseStamped",
                "navigation_time": "builtin_interfaces/msg/Duration",
                "estimated_time_remaining": "builtin_interfaces/msg/Duration",
                "number_of_recoveries": "int",
                "distance_remaining": "float",
            },
        },
        DOCK[distribution]: {
            "Goal": DOCKING_GOAL,
            "Result": DOCKED if is_humble else DOCKED | ERROR,
            "Feedback": {
                "state": "int",
                "docking_time": "builtin_interfaces/msg/Duration",
                "num_retries": "int",
            },
        },
        CARRY_OUT: CARRYING,
    }


BASIC: Mapping[str, type] = {"int": int, "float": float, "bool": bool, "str": str}


class Message:
    """A message of these fields; each begins as its type's zero, or what the definition states."""

    def __init__(self, fields: Fields, **values: Any) -> None:
        object.__setattr__(self, "_fields", fields)
        for name, kind in fields.items():
            object.__setattr__(self, name, _first(kind))
        for name, value in values.items():
            setattr(self, name, value)

    def __setattr__(self, name: str, value: Any) -> None:
        fields: Fields = self._fields  # type: ignore[attr-defined]
        if name not in fields:
            raise AttributeError(f"the message has no field {name}; it has {', '.join(fields)}")
        if not _fits(fields[name], value):
            raise TypeError(f"the field {name} is of the type {fields[name]}, not {value!r}")
        object.__setattr__(self, name, value)


def message(kind: str, **values: Any) -> Message:
    """:param kind: a key of `MESSAGES`."""
    return Message(MESSAGES[kind], **values)


def _first(kind: str) -> Any:
    if kind.endswith("[]"):
        return []
    name, _, value = kind.partition("=")
    return BASIC[name](float(value or 0) if name != "str" else "") if name in BASIC else message(name)


def _fits(kind: str, value: Any) -> bool:
    if kind.endswith("[]"):
        return isinstance(value, list) and all(_fits(kind[:-2], one) for one in value)
    name = kind.partition("=")[0]
    if name in BASIC:
        return type(value) is BASIC[name]
    return isinstance(value, Message) and value._fields is MESSAGES[name]  # type: ignore[attr-defined]
