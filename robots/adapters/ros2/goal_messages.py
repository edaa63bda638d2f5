"""Goals' fields: of nav2_msgs NavigateToPose and DockRobot (Humble, Jazzy), and of CarryOutPacket (examples/ros2)."""

from math import cos, radians, sin
from typing import Any

from robots.adapters.ros2.frames import PlanePose, turned_back
from robots.adapters.ros2.parameters import PacketAction, Place, Ros2Parameters
from robots.wire import BehaviourPacket, SymbolicFact


def goal_message(kind: Any, packet: BehaviourPacket, action: PacketAction, parameters: Ros2Parameters) -> Any:
    """The goal for a packet. `kind`: the action's type."""
    goal = kind.Goal()
    place = parameters.places[packet.arguments[action.place]] if action.place is not None else None
    if action.form == "navigate" and place is not None:
        _fill_pose(goal.pose, place, parameters)
    elif action.form == "dock" and place is not None:
        goal.use_dock_id = place.dock is not None
        goal.dock_id = place.dock or ""
        goal.dock_type = action.dock_type
        goal.navigate_to_staging_pose = True
        _fill_pose(goal.dock_pose, place, parameters)
    else:
        goal.packet_id = packet.id
        goal.tag = packet.tag
        goal.argument_names = list(packet.arguments)
        goal.argument_values = list(packet.arguments.values())
        goal.timeout_s = packet.timeout_s
    return goal


def _fill_pose(stamped: Any, place: Place, parameters: Ros2Parameters) -> None:
    """Fill a geometry_msgs/PoseStamped. Its stamp stays zero: the newest transform counts."""
    x_m, y_m, heading_deg = parameters.map_in_world
    offset = PlanePose(x_m, y_m, radians(heading_deg))
    at = turned_back(PlanePose(place.x_m, place.y_m, radians(place.heading_deg)), offset)
    stamped.header.frame_id = parameters.map_frame
    stamped.pose.position.x = at.x_m
    stamped.pose.position.y = at.y_m
    stamped.pose.orientation.z = sin(at.heading_rad / 2)
    stamped.pose.orientation.w = cos(at.heading_rad / 2)


def facts_of(texts: Any) -> tuple[SymbolicFact, ...]:
    """Facts in the form `in(sample_1, bay_7)`; what is not of that form is left out."""
    found = []
    for text in texts:
        predicate, _, rest = str(text).strip().partition("(")
        if predicate and rest.endswith(")"):
            args = tuple(arg.strip() for arg in rest[:-1].split(",") if arg.strip())
            found.append(SymbolicFact(predicate=predicate.strip(), args=args))
    return tuple(found)
