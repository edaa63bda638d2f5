"""One goal of a ROS 2 action: sent or taken up again, followed to its end, cancelled.

Its id follows from the packet, so that after a restart of the adapter the server can be asked about it: results are
fetched from the action's `_action/get_result` service, which answers when the goal has ended, and with an unknown
status if the server does not know it. rclpy's goal handles would not outlive the process.
"""

import uuid
from collections.abc import Callable
from enum import IntEnum
from typing import Any

from robots.adapters.driver import Progress, ProgressState
from robots.adapters.ros2.goal_messages import facts_of
from robots.adapters.ros2.ros import Ros

GOALS = uuid.UUID("6d0f3b0e-3c5d-5d0c-9a37-5f0c7f6f8f11")
"""The name space of goals' ids."""


class GoalStatus(IntEnum):
    """action_msgs/msg/GoalStatus."""

    UNKNOWN = 0
    """The server does not know the goal."""
    ACCEPTED = 1
    """It will begin."""
    EXECUTING = 2
    """It is being carried out."""
    CANCELING = 3
    """It was asked to end, and still moves."""
    SUCCEEDED = 4
    """It has achieved what it is for."""
    CANCELED = 5
    """It has ended as asked."""
    ABORTED = 6
    """The server has given it up."""


class ActionServer:
    """What is sent to one action server and received from it."""

    def __init__(self, ros: Ros, name: str, type_name: str) -> None:
        self.name = name
        self.type = ros.type(type_name)
        self._ros = ros
        self._client = ros.action_client(ros.node, self.type, name)
        services = self.type.Impl
        self._results = ros.node.create_client(services.GetResultService, f"{name}/_action/get_result")
        self._cancels = ros.node.create_client(ros.cancel_goal, f"{name}/_action/cancel_goal")

    @property
    def is_ready(self) -> bool:
        """True while the server can be reached."""
        return bool(self._client.server_is_ready())

    def send(self, goal: Any, goal_id: uuid.UUID, feedback: Callable[[Any], None]) -> Any:
        """The future of the answer, which is `accepted` or not."""
        return self._client.send_goal_async(goal, feedback_callback=feedback, goal_uuid=self._id(goal_id))

    def result(self, goal_id: uuid.UUID) -> Any:
        """The future of `status` and `result`."""
        request = self.type.Impl.GetResultService.Request()
        request.goal_id = self._id(goal_id)
        return self._results.call_async(request)

    def cancel(self, goal_id: uuid.UUID) -> Any:
        request = self._ros.cancel_goal.Request()
        request.goal_info.goal_id = self._id(goal_id)
        return self._cancels.call_async(request)

    def _id(self, goal_id: uuid.UUID) -> Any:
        return self._ros.uuid(uuid=list(goal_id.bytes))


class ActionGoal:
    """The life of one goal. `follow` is called often, with the time; nothing here waits."""

    def __init__(
        self, server: ActionServer, key: str, message: Any, *, timeout_s: float, was_sent: bool
    ) -> None:
        """
        :param key: names the goal among all that the robot is ever given.
        :param message: the action's goal.
        :param timeout_s: how long the server may be away, or take to answer.
        :param was_sent: it may have been sent before a restart: it is asked for, and not sent.
        """
        self._server = server
        self._id = uuid.uuid5(GOALS, key)
        self._message = message
        self._timeout_s = timeout_s
        self._was_sent = was_sent
        self._waits_since_s: float | None = None
        self._answer: Any = None
        self._result: Any = None
        self._cancelled = False
        self._cancel_answer: Any = None
        self.feedback: Any = None
        """The last feedback, None before the first."""
        self.is_unknown = False
        """True if the server does not know the goal."""
        self._end: Progress | None = None

    @property
    def has_ended(self) -> bool:
        return self._end is not None

    @property
    def is_cancelled(self) -> bool:
        """True if it was asked to end."""
        return self._cancelled

    def cancel(self) -> None:
        """Ask the server to end it; if it was not sent yet, it is not."""
        self._cancelled = True

    def follow(self, now_s: float) -> Progress:
        """What has become of it."""
        if self._end is None:
            self._end = self._step(now_s)
        return self._end or Progress()

    def _step(self, now_s: float) -> Progress | None:
        if not self._server.is_ready and not _done(self._result):
            if self._cancelled and self._answer is None and not self._was_sent:
                return _failed("was cancelled before it began")
            self._result = None  # a server that starts again does not know of it
            return self._late(now_s, f"the action server {self._server.name} is not available")
        if self._was_sent or self._answer is not None:
            return self._follow(now_s)
        if self._cancelled:
            return _failed("was cancelled before it began")
        self._waits_since_s = None
        self._answer = self._server.send(self._message, self._id, self._note)
        return None

    def _follow(self, now_s: float) -> Progress | None:
        """It was sent: ask for its end, and for its cancellation once it is accepted."""
        if self._answer is not None and not _done(self._answer):
            return self._late(now_s, f"the action server {self._server.name} does not answer")
        if self._answer is not None and not self._answer.result().accepted:
            return _failed(f"was rejected by the action server {self._server.name}")
        if self._result is None:
            self._result = self._server.result(self._id)
        if self._cancelled and self._cancel_answer is None:
            self._cancel_answer = self._server.cancel(self._id)
        if not _done(self._result):
            self._waits_since_s = None
            return None
        response = self._result.result()
        return self._ended(GoalStatus(response.status), response.result)

    def _ended(self, status: GoalStatus, result: Any) -> Progress:
        words = _words(result)
        if status is GoalStatus.SUCCEEDED:
            if getattr(result, "success", True):
                perceived = facts_of(getattr(result, "perceived", ()))
                return Progress(state=ProgressState.FINISHED, perceived=perceived or None)
            return _failed(f"did not succeed{words}")
        if status is GoalStatus.CANCELED:
            return _failed("was cancelled" if self._cancelled else f"was cancelled by another client{words}")
        if status is GoalStatus.ABORTED:
            return _failed(f"was aborted by {self._server.name}{words}")
        self.is_unknown = True
        return _failed(
            f"has an unknown outcome: the action server {self._server.name} does not know its goal any more"
        )

    def _late(self, now_s: float, why: str) -> Progress | None:
        if self._waits_since_s is None:
            self._waits_since_s = now_s
        if now_s - self._waits_since_s <= self._timeout_s:
            return None
        return _failed(f"{why} for {self._timeout_s:.0f} s")

    def _note(self, message: Any) -> None:
        self.feedback = message.feedback


def _done(future: Any) -> bool:
    return future is not None and bool(future.done())


def _failed(detail: str) -> Progress:
    return Progress(state=ProgressState.FAILED, detail=detail)


def _words(result: Any) -> str:
    """What the server says of a failure: NavigateToPose and DockRobot since Jazzy, CarryOutPacket."""
    code = getattr(result, "error_code", 0)
    said = getattr(result, "reason", "") or getattr(result, "error_msg", "")
    parts = [str(said)] if said else []
    parts += [f"error {code}"] if code else []
    return f": {', '.join(parts)}" if parts else ""
