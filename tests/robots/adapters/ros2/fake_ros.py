"""ROS 2 as the adapter meets it: futures, action servers that accept, reject, abort, forget and die, and messages.

Types have the fields of Humble and Jazzy; a field that a type does not have cannot be set, as in ROS 2.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

from robots.adapters.ros2.ros import Ros, RosError


class Future:
    """rclpy.task.Future, as far as it is used."""

    def __init__(self) -> None:
        self._value: Any = None
        self._done = False

    def done(self) -> bool:
        return self._done

    def result(self) -> Any:
        return self._value

    def set_result(self, value: Any) -> None:
        self._value = value
        self._done = True


class Message:
    """A message with these fields and no others."""

    def __init__(self, **fields: Any) -> None:
        for name, value in fields.items():
            object.__setattr__(self, name, value)

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in self.__dict__:
            raise AttributeError(f"the message has no field {name}")
        object.__setattr__(self, name, value)


def pose(x: float = 0.0, y: float = 0.0, z: float = 0.0, w: float = 1.0) -> Message:
    return Message(position=Message(x=x, y=y, z=0.0), orientation=Message(x=0.0, y=0.0, z=z, w=w))


def stamped() -> Message:
    return Message(header=Message(stamp=None, frame_id=""), pose=pose())


GOALS: dict[str, Callable[[], Message]] = {
    "nav2_msgs/action/NavigateToPose": lambda: Message(pose=stamped(), behavior_tree=""),
    "nav2_msgs/action/DockRobot": lambda: Message(
        use_dock_id=True,
        dock_id="",
        dock_pose=stamped(),
        dock_type="",
        max_staging_time=1000.0,
        navigate_to_staging_pose=True,
    ),
    "my_robot_interfaces/action/CarryOutPacket": lambda: Message(
        packet_id="", tag="", argument_names=[], argument_values=[], timeout_s=0.0
    ),
}
RESULTS: dict[str, Callable[[], Message]] = {
    "nav2_msgs/action/NavigateToPose": lambda: Message(error_code=0, error_msg=""),
    "nav2_msgs/action/DockRobot": lambda: Message(success=True, error_code=0, num_retries=0),
    "my_robot_interfaces/action/CarryOutPacket": lambda: Message(success=True, reason="", perceived=[]),
}


@dataclass
class Server:
    """An action server. It outlives the adapter's process, unless it is restarted itself."""

    type_name: str
    available: bool = True
    accepts: bool = True
    answers: bool = True
    goals: dict[bytes, Message] = field(default_factory=dict)
    begun: list[Message] = field(default_factory=list)
    """The goals that were carried out, each once."""
    status: dict[bytes, int] = field(default_factory=dict)
    results: dict[bytes, Message] = field(default_factory=dict)
    waiting: dict[bytes, list[Future]] = field(default_factory=dict)
    feedback: Callable[[Any], None] | None = None
    cancels: int = 0

    def send(self, goal: Message, goal_id: bytes) -> Future:
        """As rclpy's server does, it rejects an id that it knows."""
        answer = Future()
        if not self.available or not self.answers:
            return answer
        accepted = self.accepts and goal_id not in self.goals
        if accepted:
            self.goals[goal_id] = goal
            self.begun.append(goal)
            self.status[goal_id] = 2
        answer.set_result(SimpleNamespace(accepted=accepted))
        return answer

    def result(self, goal_id: bytes) -> Future:
        answer = Future()
        if not self.available:
            return answer
        if goal_id not in self.goals:
            answer.set_result(SimpleNamespace(status=0, result=RESULTS[self.type_name]()))
        elif goal_id in self.results:
            answer.set_result(SimpleNamespace(status=self.status[goal_id], result=self.results[goal_id]))
        else:
            self.waiting.setdefault(goal_id, []).append(answer)
        return answer

    def cancel(self, goal_id: bytes) -> Future:
        self.cancels += 1
        answer = Future()
        if self.available:
            answer.set_result(SimpleNamespace(return_code=0 if goal_id in self.goals else 2))
            if goal_id in self.goals and goal_id not in self.results:
                self.end(5, goal_id)
        return answer

    def end(self, status: int = 4, goal_id: bytes | None = None, **fields: Any) -> None:
        """The goal ends: 4 succeeded, 5 cancelled, 6 aborted; the newest if no id is given."""
        key = goal_id or list(self.goals)[-1]
        result = RESULTS[self.type_name]()
        for name, value in fields.items():
            setattr(result, name, value)
        self.status[key] = status
        self.results[key] = result
        for future in self.waiting.pop(key, []):
            future.set_result(SimpleNamespace(status=status, result=result))

    def restart(self) -> None:
        """It forgets its goals."""
        self.goals.clear()
        self.results.clear()
        self.waiting.clear()
        self.available = True

    def feed_back(self, **fields: Any) -> None:
        assert self.feedback is not None
        self.feedback(SimpleNamespace(feedback=SimpleNamespace(**fields)))


class FakeRos(Ros):
    """Everything that the adapter imports of ROS 2. Action servers are made before it, and shared by all of a test."""

    def type(self, name: str) -> Any:
        if name in GOALS:
            request = lambda: SimpleNamespace(goal_id=None)  # noqa: E731
            services = SimpleNamespace(GetResultService=SimpleNamespace(Request=request))
            return SimpleNamespace(Goal=GOALS[name], Impl=services, name=name)
        if name.split("/", maxsplit=1)[0] in ("geometry_msgs", "sensor_msgs", "nav_msgs"):
            return name
        raise RosError(f"the ROS 2 type {name} cannot be imported")


class Node:
    def __init__(self, servers: dict[str, Server]) -> None:
        self._servers = servers
        self.subscriptions: dict[str, Callable[[Any], None]] = {}

    def create_subscription(self, kind: Any, topic: str, callback: Callable[[Any], None], depth: int) -> None:
        self.subscriptions[topic] = callback

    def create_client(self, kind: Any, name: str) -> Any:
        action, _, service = name.partition("/_action/")
        server = self._servers[action]
        if service == "get_result":
            return SimpleNamespace(call_async=lambda request: server.result(bytes(request.goal_id.uuid)))
        assert service == "cancel_goal", name
        return SimpleNamespace(
            call_async=lambda request: server.cancel(bytes(request.goal_info.goal_id.uuid))
        )


def fake_ros(servers: dict[str, Server]) -> tuple[FakeRos, Node]:
    node = Node(servers)

    class Client:
        def __init__(self, node: Any, kind: Any, name: str) -> None:
            self._server = servers[name]
            assert self._server.type_name == kind.name

        def server_is_ready(self) -> bool:
            return self._server.available

        def send_goal_async(self, goal: Message, *, feedback_callback: Any, goal_uuid: Any) -> Future:
            self._server.feedback = feedback_callback
            return self._server.send(goal, bytes(goal_uuid.uuid))

    cancel_goal = SimpleNamespace(
        Request=lambda: SimpleNamespace(goal_info=SimpleNamespace(goal_id=None, stamp=None))
    )
    ros = FakeRos(
        node=node,
        action_client=Client,
        cancel_goal=cancel_goal,
        uuid=lambda uuid: SimpleNamespace(uuid=uuid),
    )
    return ros, node
