"""ROS 2 as the adapter meets it: futures, transforms, and action servers that accept, reject, abort, forget and die.

Messages have the fields of Humble's or Jazzy's definitions (`definitions`).
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

from robots.adapters.ros2.ros import Ros, RosError
from tests.robots.adapters.ros2.definitions import MESSAGES, Distribution, Message, actions, message


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


def pose(x: float = 0.0, y: float = 0.0, z: float = 0.0, w: float = 1.0) -> Message:
    return message(
        "geometry_msgs/msg/Pose",
        position=message("geometry_msgs/msg/Point", x=x, y=y),
        orientation=message("geometry_msgs/msg/Quaternion", z=z, w=w),
    )


@dataclass
class Server:
    """An action server. It outlives the adapter's process, unless it is restarted itself."""

    type_name: str
    distribution: Distribution = Distribution.JAZZY
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

    def made(self, part: str, **fields: Any) -> Message:
        """A goal, result or feedback of this action."""
        return Message(actions(self.distribution)[self.type_name][part], **fields)

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
            answer.set_result(SimpleNamespace(status=0, result=self.made("Result")))
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
        result = self.made("Result", **({"success": status == 4} | fields if self.tells_success else fields))
        self.status[key] = status
        self.results[key] = result
        for future in self.waiting.pop(key, []):
            future.set_result(SimpleNamespace(status=status, result=result))

    @property
    def tells_success(self) -> bool:
        return "success" in actions(self.distribution)[self.type_name]["Result"]

    def restart(self) -> None:
        """It forgets its goals."""
        self.goals.clear()
        self.results.clear()
        self.waiting.clear()
        self.available = True

    def feed_back(self, **fields: Any) -> None:
        assert self.feedback is not None
        self.feedback(SimpleNamespace(feedback=self.made("Feedback", **fields)))


class TransformError(Exception):
    """tf2_ros.TransformException."""


@dataclass
class Buffer:
    """A tf2_ros.Buffer. `known`: transforms by target and source."""

    known: dict[tuple[str, str], Message] = field(default_factory=dict)

    def lookup_transform(self, target: str, source: str, time: Any) -> Message:
        assert time == 0, "the newest one is asked for"
        if (target, source) not in self.known:
            raise TransformError(f"{target} and {source} are not connected")
        return self.known[target, source]


@dataclass(frozen=True, slots=True)
class FakeRos(Ros):
    """Everything that the adapter imports of ROS 2. Action servers are made before it, and shared by all of a test."""

    distribution: Distribution = Distribution.JAZZY

    def type(self, name: str) -> Any:
        known = actions(self.distribution)
        if name in known:
            request = lambda: Message({"goal_id": "unique_identifier_msgs/msg/UUID"})  # noqa: E731
            services = SimpleNamespace(GetResultService=SimpleNamespace(Request=request))
            return SimpleNamespace(Goal=lambda: Message(known[name]["Goal"]), Impl=services, name=name)
        if name in MESSAGES:
            return name
        raise RosError(f"the ROS 2 type {name} cannot be imported")


class Node:
    def __init__(self, servers: dict[str, Server], seconds: Callable[[], float]) -> None:
        self._servers = servers
        self._seconds = seconds
        self.subscriptions: dict[str, Callable[[Any], None]] = {}

    def create_subscription(self, kind: str, topic: str, callback: Callable[[Any], None], qos: Any) -> None:
        assert kind in MESSAGES
        assert qos == "sensor data", "a reliable subscription hears no best-effort publisher"
        self.subscriptions[topic] = callback

    def get_clock(self) -> Any:
        nanoseconds = round(self._seconds() * 1e9)
        return SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=nanoseconds))

    def create_client(self, kind: Any, name: str) -> Any:
        action, _, service = name.partition("/_action/")
        server = self._servers[action]
        if service == "get_result":
            return SimpleNamespace(call_async=lambda request: server.result(bytes(request.goal_id.uuid)))
        assert service == "cancel_goal", name
        return SimpleNamespace(
            call_async=lambda request: server.cancel(bytes(request.goal_info.goal_id.uuid))
        )


def fake_ros(servers: dict[str, Server], seconds: Callable[[], float]) -> tuple[FakeRos, Node]:
    """:param seconds: of the node's clock."""
    node = Node(servers, seconds)

    class Client:
        def __init__(self, node: Any, kind: Any, name: str) -> None:
            self._server = servers[name]
            assert self._server.type_name == kind.name

        def server_is_ready(self) -> bool:
            return self._server.available

        def send_goal_async(self, goal: Message, *, feedback_callback: Any, goal_uuid: Any) -> Future:
            self._server.feedback = feedback_callback
            return self._server.send(goal, bytes(goal_uuid.uuid))

    distribution = next(iter(servers.values())).distribution
    ros = FakeRos(
        node=node,
        action_client=Client,
        cancel_goal=SimpleNamespace(Request=lambda: message("action_msgs/srv/CancelGoal_Request")),
        uuid=lambda uuid: message("unique_identifier_msgs/msg/UUID", uuid=uuid),
        sensor_qos="sensor data",
        buffer=Buffer(),
        newest=0,
        transform_error=TransformError,
        distribution=distribution,
    )
    return ros, node
