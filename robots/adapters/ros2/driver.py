"""Carries packets out by ROS 2 actions; implements `robots.adapters.PacketDriver`. Its node is spun by the caller."""

from collections.abc import Mapping
from dataclasses import replace
from math import isnan, radians
from typing import Any

from robots.adapters.driver import Progress, ProgressState
from robots.adapters.ros2.frames import PlanePose, heading_of, turned
from robots.adapters.ros2.goal import ActionGoal, ActionServer
from robots.adapters.ros2.goal_messages import goal_message
from robots.adapters.ros2.parameters import PacketAction, PoseFrame, Ros2Parameters
from robots.adapters.ros2.ros import Ros
from robots.clock import Clock
from robots.wire import BehaviourPacket, Telemetry

CHARGING = 1
"""POWER_SUPPLY_STATUS_CHARGING of sensor_msgs/BatteryState."""


class Ros2Driver:
    """One goal at a time. It is sent by the first `poll` after `start`: the memory says by then that it will be."""

    def __init__(self, ros: Ros, parameters: Ros2Parameters, clock: Clock) -> None:
        """:param clock: of the machine, for the time that servers may take.

        :raises RosError: if a type of the parameters cannot be imported.
        """
        self._ros = ros
        self._parameters = parameters
        self._clock = clock
        named = {(action.action, action.type) for action in parameters.packets.values()}
        self._servers = {pair: ActionServer(ros, *pair) for pair in sorted(named)}
        self._packet: BehaviourPacket | None = None
        self._goal: ActionGoal | None = None
        self._attempt = 0
        self._remembered: tuple[str, int] | None = None
        """The packet that a process before this one may have sent, and the number of its goal."""
        self._pauses = False
        self._pose: PlanePose | None = None
        self._battery: Any = None
        if not isinstance(parameters.pose, PoseFrame):
            kind = ros.type(parameters.pose.type)
            ros.node.create_subscription(kind, parameters.pose.topic, self._note_pose, ros.sensor_qos)
        if parameters.battery is not None:
            kind = ros.type(parameters.battery.type)
            ros.node.create_subscription(kind, parameters.battery.topic, self._note_battery, ros.sensor_qos)

    def memory(self) -> Mapping[str, Any]:
        if self._packet is None:
            return {}
        return {"packet": self._packet.id, "attempt": self._attempt}

    def recall(self, memory: Mapping[str, Any]) -> None:
        if memory:
            self._remembered = str(memory["packet"]), int(memory["attempt"])

    def start(self, packet: BehaviourPacket) -> str | None:
        remembered = self._remembered
        was_sent = remembered is not None and remembered[0] == packet.id
        self._attempt = remembered[1] if was_sent and remembered is not None else 0
        self._remembered = None
        self._packet = packet
        self._pauses = False
        self._goal = self._new_goal(packet, was_sent=was_sent)
        return None

    def poll(self) -> Progress:
        goal = self._goal
        packet = self._packet
        if goal is None or packet is None:
            return Progress()
        progress = goal.follow(self._clock.now_s())
        if progress.state is ProgressState.RUNNING:
            return replace(progress, events=self._events(goal))
        action = self._parameters.packets[packet.tag]
        may_send_again = (
            action.repeatable or action.form == "packet"
        )  # CarryOutPacket's servers know packets' ids
        if goal.is_unknown and may_send_again and not self._pauses and not goal.is_cancelled:
            self._begin_again(packet)
            return Progress()
        return progress

    def pause(self) -> None:
        """End the goal of a repeatable action, to send another when the robot goes on. Others run to their end."""
        if self._packet is None or self._goal is None or not self._action(self._packet).repeatable:
            return
        self._pauses = True
        self._goal.cancel()
        self._goal.follow(self._clock.now_s())

    def resume(self) -> None:
        if not self._pauses or self._packet is None or self._goal is None:
            return
        self._pauses = False
        if self._goal.follow(self._clock.now_s()).state is not ProgressState.FINISHED:
            self._begin_again(self._packet)

    def cancel(self) -> None:
        if self._goal is not None:
            self._goal.cancel()

    def telemetry(self) -> Telemetry | None:
        if isinstance(self._parameters.pose, PoseFrame):
            self._pose = self._looked_up(self._parameters.pose)
        if self._pose is None:
            return None
        battery = self._battery
        charge = float(battery.percentage) if battery is not None else 1.0
        feedback = self._goal.feedback if self._goal is not None and not self._goal.has_ended else None
        return Telemetry(
            at_s=0.0,
            x_m=self._pose.x_m,
            y_m=self._pose.y_m,
            heading_rad=self._pose.heading_rad,
            battery=1.0 if isnan(charge) else min(1.0, max(0.0, charge)),
            charging=battery is not None and battery.power_supply_status == CHARGING,
            goal_m=getattr(feedback, "distance_remaining", None),
        )

    def _action(self, packet: BehaviourPacket) -> PacketAction:
        return self._parameters.packets[packet.tag]

    def _new_goal(self, packet: BehaviourPacket, *, was_sent: bool) -> ActionGoal:
        action = self._action(packet)
        server = self._servers[action.action, action.type]
        return ActionGoal(
            server,
            f"{packet.id}#{self._attempt}",
            goal_message(server.type, packet, action, self._parameters),
            timeout_s=self._parameters.server_timeout_s,
            was_sent=was_sent,
        )

    def _begin_again(self, packet: BehaviourPacket) -> None:
        """Send the goal once more, under another id."""
        self._attempt += 1
        self._goal = self._new_goal(packet, was_sent=False)

    def _events(self, goal: ActionGoal) -> tuple[str, ...]:
        """Those of CarryOutPacket's feedback; each feedback is told once."""
        events = tuple(getattr(goal.feedback, "events", ()))
        if events:
            goal.feedback = None
        return events

    def _note_pose(self, message: Any) -> None:
        """Of PoseWithCovarianceStamped or Odometry: both have the pose at the same place."""
        pose = message.pose.pose
        self._pose = self._in_world(pose.position, pose.orientation)

    def _looked_up(self, pose: PoseFrame) -> PlanePose | None:
        """The robot's pose by `/tf`; None if no transform is known that is new enough."""
        found = self._ros.transform(self._parameters.map_frame, pose.frame, max_age_s=pose.max_age_s)
        return (
            None if found is None else self._in_world(found.transform.translation, found.transform.rotation)
        )

    def _in_world(self, point: Any, orientation: Any) -> PlanePose:
        x_m, y_m, heading_deg = self._parameters.map_in_world
        at = PlanePose(point.x, point.y, heading_of(orientation))
        return turned(at, PlanePose(x_m, y_m, radians(heading_deg)))

    def _note_battery(self, message: Any) -> None:
        self._battery = message
