"""Builds orders: a leg of nodes and edges for each packet of a script, released one after the other. Pure.

A leg ends at a node without actions, the decision point, on which the vehicle waits for the next: it is resent with
every update, and vehicles of 2.0 would carry out its actions again. The first message of an order holds the vehicle's
present position and, not yet released, all that is planned; it moves nothing, so a late copy of it does no harm.
Update n releases the leg of the order's n-th packet.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from robots.adapters.vda5050.frame import Frame, Pose
from robots.adapters.vda5050.messages import (
    Action,
    ActionParameter,
    Deviation,
    Edge,
    Node,
    NodePosition,
    Order,
)
from robots.adapters.vda5050.settings import ActionSettings, PacketSettings, PlacePose, Settings
from robots.data import Memory
from robots.errors import RobotError
from robots.wire import BehaviourPacket

START_NODE = "start"
ORDER_PREFIX = "macta."
"""Orders that begin so are this adapter's."""
START_DEVIATION_M = 1.0
"""The vehicle counts as standing on an order's first node up to this distance: it may drift while it is told."""


class OrderError(RobotError):
    """Raised when a packet cannot be put as nodes, edges and actions."""


class Leg(Memory):
    """The part of an order that carries a packet out; it follows the node before it. All is released or nothing."""

    packet_id: str
    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]

    @property
    def end(self) -> Node:
        """The decision point."""
        return self.nodes[-1]

    @property
    def actions(self) -> tuple[Action, ...]:
        return tuple(action for node in self.nodes for action in node.actions)

    def as_released(self) -> tuple[list[Node], list[Edge]]:
        update = {"released": True}
        return (
            [node.model_copy(update=update) for node in self.nodes],
            [edge.model_copy(update=update) for edge in self.edges],
        )


class Route(Memory):
    """A whole order: the node on which it starts, and the legs of its packets in order."""

    order_id: str
    start: Node
    legs: tuple[Leg, ...]

    def index(self, packet_id: str) -> int | None:
        """The number of a packet's leg, from 0; None if it is not of this order."""
        return next((i for i, leg in enumerate(self.legs) if leg.packet_id == packet_id), None)

    def update(self, released: int, *, horizon: bool) -> Order:
        """The message that has released as many legs; its `order_update_id` is that number.

        It begins at the decision point of what was released before.
        """
        ahead = self.legs[released:] if horizon else ()
        if released == 0:
            nodes = [self.start]
            edges: list[Edge] = []
        else:
            stitch = self.legs[released - 2].end if released > 1 else self.start
            leg_nodes, edges = self.legs[released - 1].as_released()
            nodes = [stitch.model_copy(update={"released": True}), *leg_nodes]
        return Order(
            order_id=self.order_id,
            order_update_id=released,
            nodes=(*nodes, *(node for leg in ahead for node in leg.nodes)),
            edges=(*edges, *(edge for leg in ahead for edge in leg.edges)),
        )


def route(
    order_id: str, packets: Sequence[BehaviourPacket], start: Pose, settings: Settings, frame: Frame
) -> Route:
    """The order that carries packets out.

    :param start: the vehicle's pose on its map.
    :raises OrderError: naming the packet and what is missing.
    """
    builder = _Builder(order_id, start, settings, frame)
    return Route(order_id=order_id, start=builder.start, legs=tuple(map(builder.leg, packets)))


def fit_id(name: str) -> str:
    """A name as an identifier of the characters that the standard recommends (§7.1.2)."""
    return re.sub(r"[^A-Za-z0-9_.:-]", "_", name)


def why_not(packet: BehaviourPacket, settings: Settings) -> str | None:
    """Why a packet cannot be put as an order; None if it can."""
    try:
        route(ORDER_PREFIX, [packet], (0.0, 0.0, 0.0), settings, settings.frame)
    except OrderError as error:
        return str(error)
    return None


class _Builder:
    """Numbers nodes, edges and actions, and knows where the vehicle stands after each."""

    def __init__(self, order_id: str, start: Pose, settings: Settings, frame: Frame) -> None:
        self._order_id = order_id
        self._settings = settings
        self._frame = frame
        self._sequence = 0
        deviation = Deviation(a=START_DEVIATION_M, b=START_DEVIATION_M)
        self._position = NodePosition(
            x=start[0], y=start[1], map_id=frame.map_id, allowed_deviation_xy=deviation
        )
        self._name = START_NODE
        self.start = Node(node_id=START_NODE, sequence_id=0, released=True, node_position=self._position)

    def leg(self, packet: BehaviourPacket) -> Leg:
        rule = self._settings.all_packets.get(packet.tag)
        if rule is None:
            choices = ", ".join(sorted(self._settings.all_packets))
            raise OrderError(f"no settings say how to carry out {packet.tag}; packets: {choices}")
        place = None if rule.drive is None else packet.arguments.get(rule.drive)
        if place is not None:
            self._go_to(place, packet, dock=rule.dock)
        actions = tuple(self._actions(packet, rule))
        nodes = [self._node(actions)]
        edges = [self._edge(nodes[0])]
        if actions:
            if place is not None and rule.leave:
                self._go_to(place, packet, dock=False)
            nodes.append(self._node(()))
            edges.append(self._edge(nodes[-1]))
        return Leg(packet_id=packet.id, nodes=tuple(nodes), edges=tuple(edges))

    def _go_to(self, place: str, packet: BehaviourPacket, *, dock: bool) -> None:
        known = self._settings.places.get(place)
        if known is None:
            raise OrderError(
                f"{packet.tag}: the pose of {place} is not known; give it under `places`, or a world file"
            )
        here = self._frame.in_world((self._position.x, self._position.y, 0.0))
        pose: PlacePose = known.pose(dock=dock, near=here[:2])
        x, y, theta = self._frame.on_map((pose.x, pose.y, pose.heading_rad or 0.0))
        deviation_m = self._settings.deviation_m * self._frame.scale
        self._name = known.node or place
        self._position = NodePosition(
            x=round(x, 6),
            y=round(y, 6),
            theta=None if pose.heading_rad is None else round(theta, 5),
            map_id=self._frame.map_id,
            allowed_deviation_xy=Deviation(a=deviation_m, b=deviation_m),
            allowed_deviation_theta=None if pose.heading_rad is None else self._settings.deviation_rad,
        )

    def _node(self, actions: tuple[Action, ...]) -> Node:
        self._sequence += 2
        return Node(
            node_id=self._name,
            sequence_id=self._sequence,
            released=False,
            node_position=self._position,
            actions=actions,
        )

    def _edge(self, node: Node) -> Edge:
        number = node.sequence_id - 1
        return Edge(edge_id=f"e{number}", sequence_id=number, released=False)

    def _actions(self, packet: BehaviourPacket, rule: PacketSettings) -> Iterator[Action]:
        for index, action in enumerate(rule.actions):
            added = self._settings.action_parameters.get(action.type, {})
            yield Action(
                action_type=action.type,
                action_id=f"{self._order_id}:{fit_id(packet.id.rpartition('/')[2])}:{index}",
                blocking_type=action.blocking,
                action_parameters=_parameters(action, added, packet.arguments),
            )


def _parameters(
    action: ActionSettings, added: Mapping[str, Any], arguments: Mapping[str, str]
) -> tuple[ActionParameter, ...]:
    filled = ((key, _filled(value, arguments)) for key, value in (action.parameters | dict(added)).items())
    return tuple(ActionParameter(key=key, value=value) for key, value in filled if value is not None)


def _filled(value: Any, arguments: Mapping[str, str]) -> Any:
    """A parameter's value; None if it stands for an argument that the packet does not have."""
    if isinstance(value, str) and value.startswith("$"):
        return arguments.get(value[1:])
    return value
