"""A vehicle of VDA 5050 3.0 that moves with stepped time, and notes what it has done.

It follows the standard's chapters on taking orders (§6.1), actions (§6.2) and states (§6.6), written apart from the
adapter, from which it uses the message types alone. It drives straight from node to node.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from math import atan2, cos, dist, sin

from robots.adapters.vda5050.messages import (
    Action,
    ActionState,
    ActionStatus,
    Connection,
    Edge,
    EdgeState,
    ErrorLevel,
    Headed,
    InstantActions,
    Load,
    MobileRobotPosition,
    Node,
    NodeState,
    OperatingMode,
    Order,
    PhysicalParameters,
    PowerSupply,
    ProtocolFeatures,
    Reference,
    State,
    SupportedAction,
    TypeSpecification,
    VehicleConnection,
    VehicleError,
    VehicleFactsheet,
    Visualization,
)
from robots.adapters.vda5050.topics import Topic

STATE_S = 30.0
"""A state is published at least this often."""
NODE_ACTIONS = {"pick": 3.0, "drop": 3.0, "startCharging": 1.0, "stopCharging": 1.0, "beep": 1.0}
"""What it can do at nodes, and how long that takes."""
INSTANT_ACTIONS = (
    "startPause",
    "stopPause",
    "cancelOrder",
    "stateRequest",
    "factsheetRequest",
    "stopCharging",
    "clearInstantActions",
    "stopHibernation",
)


@dataclass
class Running:
    """An action that is being carried out."""

    action: Action
    left_s: float


@dataclass
class SteppedVehicle:
    """Call `receive` with what arrives, `step` with the time that passes; `publish` takes what it sends."""

    publish: Callable[[Topic, Headed], None]
    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0
    speed_m_s: float = 0.5
    map_id: str = "default"
    mode: OperatingMode = OperatingMode.AUTOMATIC
    battery: float = 80.0
    charging: bool = False
    load: Load | None = None
    fails: frozenset[str] = frozenset()
    """Types of actions that fail."""
    holds_failed: bool = False
    """Failed actions may be tried again: it waits for that."""
    deeds: Counter[str] = field(default_factory=Counter)
    """How often each action was carried out, by its id, and each node reached, by order and sequence."""
    history: list[str] = field(default_factory=list)
    """Types of the actions done and nodes reached, in order."""

    def __post_init__(self) -> None:
        self.time_s = 0.0
        self._order: Order | None = None
        self._nodes: list[Node] = []
        self._edges: list[Edge] = []
        self._last: Node | None = None
        self._decision: Node | None = None
        self._states: dict[str, ActionState] = {}
        self._instant: dict[str, ActionState] = {}
        self._queue: list[Action] = []
        self._running: Running | None = None
        self._errors: list[VehicleError] = []
        self._is_cancelled = False
        self._is_blocked = False
        self._paused = False
        self._driving = False
        self._published_s = float("-inf")
        self._header = 0
        self._changed = True
        self.is_hibernating = False

    # What it tells

    def connect(self) -> None:
        self.publish(Topic.CONNECTION, Connection(connection_state=VehicleConnection.ONLINE))
        self._changed = True

    def factsheet(self) -> VehicleFactsheet:
        supported = [
            *(
                SupportedAction(action_type=kind, action_scopes=("NODE",), blocking_types=("HARD",))
                for kind in NODE_ACTIONS
            ),
            *(SupportedAction(action_type=kind, action_scopes=("INSTANT",)) for kind in INSTANT_ACTIONS),
        ]
        return VehicleFactsheet(
            type_specification=TypeSpecification(
                series_name="stepped",
                mobile_robot_kinematics="OMNIDIRECTIONAL",
                mobile_robot_kinematic="OMNIDIRECTIONAL",
                mobile_robot_class="CARRIER",
                maximum_load_mass=5.0,
                localization_types=("NATURAL",),
                navigation_types=("FREELY_NAVIGATING",),
            ),
            physical_parameters=PhysicalParameters(
                maximum_speed=self.speed_m_s,
                maximum_angular_speed=1.0,
                maximum_acceleration=1.0,
                maximum_deceleration=1.0,
                maximum_height=0.5,
                width=0.4,
                length=0.5,
            ),
            protocol_features=ProtocolFeatures(mobile_robot_actions=tuple(supported)),
        )

    def state(self) -> State:
        order = self._order
        return State(
            order_id=order.order_id if order else "",
            order_update_id=order.order_update_id if order else 0,
            last_node_id=self._last.node_id if self._last else "",
            last_node_sequence_id=self._last.sequence_id if self._last else 0,
            node_states=tuple(_node_state(one) for one in self._nodes),
            edge_states=tuple(_edge_state(one) for one in self._edges),
            mobile_robot_position=MobileRobotPosition(
                x=self.x, y=self.y, theta=self.theta, map_id=self.map_id
            ),
            loads=(self.load,) if self.load is not None else (),
            driving=self._driving,
            paused=self._paused,
            action_states=tuple(self._states.values()),
            instant_action_states=tuple(self._instant.values()),
            power_supply=PowerSupply(state_of_charge=self.battery, charging=self.charging),
            operating_mode=self.mode,
            errors=tuple(self._errors),
        )

    # What it is told

    def receive(self, message: Headed) -> None:
        if self.is_hibernating and not _wakes(message):
            return
        if self.is_hibernating:
            self.is_hibernating = False
            self.connect()
        if isinstance(message, Order):
            self._take_order(message)
        elif isinstance(message, InstantActions):
            for action in message.actions:
                self._take_instant(action)
        self._changed = True

    def _take_order(self, order: Order) -> None:
        """Accept an order or update, or say why not (figure 8 of the standard)."""
        current = self._order
        if (fault := self._fault(order)) is not None:
            self._reject(order, fault)
        elif current is None or current.order_id != order.order_id:
            if not self.is_idle:
                self._reject(order, "OTHER_ORDER_ACTIVE")
            elif order.order_update_id != 0:
                self._reject(order, "VALIDATION_FAILURE")
            elif not self._stands_on(order.nodes[0]):
                self._reject(order, "START_NODE_OUT_OF_RANGE")
            else:
                self._begin(order)
        elif order.order_update_id < current.order_update_id:
            self._reject(order, "OUTDATED_ORDER_UPDATE")
        elif order.order_update_id == current.order_update_id:
            pass  # a repetition
        elif self._is_cancelled:
            self._reject(order, "ORDER_UPDATE_FOLLOWING_CANCEL")
        elif self._decision is None or not _same_node(order.nodes[0], self._decision):
            self._reject(order, "VALIDATION_FAILURE")
        else:
            self._extend(order)

    def _fault(self, order: Order) -> str | None:
        numbers = [one.sequence_id for pair in _alternate(order) for one in pair]
        if (
            numbers != list(range(numbers[0], numbers[0] + len(numbers)))
            or len(order.edges) != len(order.nodes) - 1
        ):
            return "VALIDATION_FAILURE"
        released = [one.released for pair in _alternate(order) for one in pair]
        if not released[0] or sorted(released, reverse=True) != released:
            return "VALIDATION_FAILURE"
        if any(
            node.node_position is None or node.node_position.map_id != self.map_id for node in order.nodes
        ):
            return "UNKNOWN_MAP_ID"
        if any(action.action_type not in NODE_ACTIONS for node in order.nodes for action in node.actions):
            return "INVALID_ORDER_ACTION"
        return None if self.mode.takes_orders else "MOBILE_ROBOT_NOT_AVAILABLE"

    def _stands_on(self, node: Node) -> bool:
        at = node.node_position
        assert at is not None
        reach = at.allowed_deviation_xy.a if at.allowed_deviation_xy else 0.0
        return dist((self.x, self.y), (at.x, at.y)) <= reach

    def _begin(self, order: Order) -> None:
        self._is_cancelled = False
        self._is_blocked = False
        self._errors = []
        self._states = {}
        self._order = order
        self._nodes = list(order.nodes)
        self._edges = list(order.edges)
        self._add_actions(order.nodes)
        self._decide(order)
        self._arrive(self._nodes.pop(0))

    def _extend(self, order: Order) -> None:
        """Replace the horizon; the base stays."""
        gone = [one for one in self._nodes if not one.released]
        for action in (action for node in gone for action in node.actions):
            self._states.pop(action.action_id, None)
        self._nodes = [one for one in self._nodes if one.released] + list(order.nodes[1:])
        self._edges = [one for one in self._edges if one.released] + list(order.edges)
        self._add_actions(order.nodes[1:])
        self._order = order
        self._errors = []
        self._decide(order)

    def _decide(self, order: Order) -> None:
        self._decision = [one for one in order.nodes if one.released][-1]

    def _add_actions(self, nodes: Iterable[Node]) -> None:
        for action in (action for node in nodes for action in node.actions):
            self._set(action, ActionStatus.WAITING)

    def _reject(self, order: Order, kind: str) -> None:
        references = (
            Reference(reference_key="orderId", reference_value=order.order_id),
            Reference(reference_key="orderUpdateId", reference_value=str(order.order_update_id)),
        )
        error = VehicleError(error_type=kind, error_level=ErrorLevel.WARNING, error_references=references)
        if error not in self._errors:
            self._errors.append(error)

    def _take_instant(self, action: Action) -> None:
        if action.action_id in self._instant:
            return
        self._note_instant(action, ActionStatus.FINISHED)
        match action.action_type:
            case "startPause":
                self._paused = True
            case "stopPause":
                self._paused = False
            case "stopCharging":
                self.charging = False
            case "cancelOrder":
                self._cancel(action)
            case "factsheetRequest":
                self.publish(Topic.FACTSHEET, self.factsheet())
            case "clearInstantActions":
                self._instant = {}
            case "stateRequest" | "stopHibernation":
                pass
            case _:
                self._note_instant(action, ActionStatus.FAILED)
                reference = Reference(reference_key="actionId", reference_value=action.action_id)
                self._errors.append(
                    VehicleError(
                        error_type="INVALID_INSTANT_ACTION",
                        error_level=ErrorLevel.WARNING,
                        error_references=(reference,),
                    )
                )

    def _cancel(self, action: Action) -> None:
        wanted = action.parameter("orderId")
        if self._order is None or self.is_idle or wanted not in (None, self._order.order_id):
            self._note_instant(action, ActionStatus.FAILED)
            return
        for state in list(self._states.values()):
            if not state.action_status.has_ended:
                self._states[state.action_id] = state.model_copy(
                    update={"action_status": ActionStatus.FAILED}
                )
        self._nodes = []
        self._edges = []
        self._queue = []
        self._running = None
        self._driving = False
        self._is_cancelled = True

    def clear_order(self, mode: OperatingMode) -> None:
        """A person takes over: the order is cleared."""
        if not self.is_idle:
            self._cancel(Action(action_type="cancelOrder", action_id="by hand"))
            self._instant.pop("by hand", None)
        self.mode = mode
        self._changed = True

    def hibernate(self) -> None:
        """Clear the order, and say nothing more until it is woken (§6.2.3.1, startHibernation)."""
        self.clear_order(self.mode)
        self.publish(Topic.STATE, self.state())
        self.is_hibernating = True
        self.publish(Topic.CONNECTION, Connection(connection_state=VehicleConnection.HIBERNATING))

    def raise_error(self, error: VehicleError, *, stops: bool = True) -> None:
        """Show an error, and stand still if it is one with which no order goes on."""
        self._errors.append(error)
        self._is_blocked |= stops and error.error_level.stops_the_order
        self._changed = True

    def clear_errors(self) -> None:
        self._errors = []
        self._is_blocked = False
        self._changed = True

    def pause_by_hand(self) -> None:
        self._paused = True
        self._changed = True

    def forget_orders(self) -> None:
        """As after a restart of the vehicle."""
        self._order = None
        self._last = None
        self._decision = None
        self._nodes, self._edges, self._queue = [], [], []
        self._states, self._instant = {}, {}
        self._running = None
        self._changed = True

    # What it does

    @property
    def is_idle(self) -> bool:
        return (
            not self._nodes
            and not self._edges
            and all(one.action_status.has_ended for one in self._states.values())
        )

    def step(self, step_s: float) -> None:
        """Act for a while, and publish what has changed."""
        self.time_s += step_s
        if self.is_hibernating:
            return
        if not self._paused and self.mode.takes_orders:
            left_s = self._act(step_s)
            if left_s > 0 and not self._queue and self._running is None:
                self._drive(left_s)
        if self._changed or self.time_s - self._published_s >= STATE_S:
            self._changed = False
            self._published_s = self.time_s
            self.publish(Topic.STATE, self.state())

    def show(self) -> None:
        """Publish where it is."""
        at = MobileRobotPosition(x=self.x, y=self.y, theta=self.theta, map_id=self.map_id)
        self.publish(Topic.VISUALIZATION, Visualization(mobile_robot_position=at))

    def _act(self, step_s: float) -> float:
        """Carry out the actions of the node, one after the other; the time that is left."""
        left_s = step_s
        while left_s > 0 and (self._running is not None or self._queue):
            if self._running is None:
                action = self._queue.pop(0)
                self._running = Running(action, NODE_ACTIONS[action.action_type])
                self._set(action, ActionStatus.RUNNING)
            spent_s = min(left_s, self._running.left_s)
            left_s -= spent_s
            self._running.left_s -= spent_s
            if self._running.left_s <= 1e-9:
                self._end(self._running.action)
        return left_s

    def _end(self, action: Action) -> None:
        self._running = None
        if action.action_type in self.fails and self.holds_failed:
            self._set(action, ActionStatus.RETRIABLE)
            return
        if action.action_type in self.fails:
            self._set(action, ActionStatus.FAILED)
            reference = Reference(reference_key="actionId", reference_value=action.action_id)
            self.raise_error(
                VehicleError(
                    error_type=f"{action.action_type}Error",
                    error_level=ErrorLevel.CRITICAL,
                    error_references=(reference,),
                    error_description="as it was told to fail",
                )
            )
            return
        self.deeds[action.action_id] += 1
        self.history.append(action.action_type)
        match action.action_type:
            case "pick":
                self.load = Load(load_id=str(action.parameter("loadId") or "load"))
            case "drop":
                self.load = None
            case "startCharging":
                self.charging = True
            case "stopCharging":
                self.charging = False
        self._set(action, ActionStatus.FINISHED)

    def _drive(self, left_s: float) -> None:
        while (
            left_s > 0
            and self._nodes
            and self._nodes[0].released
            and not self._is_blocked
            and not self._queue
        ):
            at = self._nodes[0].node_position
            assert at is not None
            away_m = dist((self.x, self.y), (at.x, at.y))
            self._set_driving(away_m > 0)
            reach_m = self.speed_m_s * left_s
            if away_m > reach_m:
                self.theta = atan2(at.y - self.y, at.x - self.x)
                self.x += reach_m * cos(self.theta)
                self.y += reach_m * sin(self.theta)
                return
            left_s -= away_m / self.speed_m_s
            self.x, self.y = at.x, at.y
            self.theta = self.theta if at.theta is None else at.theta
            self._edges.pop(0)
            self._arrive(self._nodes.pop(0))
        self._set_driving(False)

    def _arrive(self, node: Node) -> None:
        assert self._order is not None
        self._last = node
        self._queue.extend(node.actions)
        if node.sequence_id:
            self.deeds[f"{self._order.order_id}#{node.sequence_id}"] += 1
            self.history.append(node.node_id)
        self._changed = True

    def _set_driving(self, driving: bool) -> None:
        self._changed |= driving is not self._driving
        self._driving = driving

    def _set(self, action: Action, status: ActionStatus) -> None:
        self._states[action.action_id] = _action_state(action, status)
        self._changed = True

    def _note_instant(self, action: Action, status: ActionStatus) -> None:
        self._instant[action.action_id] = _action_state(action, status)


def _wakes(message: Headed) -> bool:
    return isinstance(message, InstantActions) and any(
        action.action_type == "stopHibernation" for action in message.actions
    )


def _action_state(action: Action, status: ActionStatus) -> ActionState:
    return ActionState(action_id=action.action_id, action_type=action.action_type, action_status=status)


def _node_state(node: Node) -> NodeState:
    return NodeState(node_id=node.node_id, sequence_id=node.sequence_id, released=node.released)


def _edge_state(edge: Edge) -> EdgeState:
    return EdgeState(edge_id=edge.edge_id, sequence_id=edge.sequence_id, released=edge.released)


def _same_node(one: Node, other: Node) -> bool:
    """A decision point is resent with its contents as they were."""
    return (one.node_id, one.sequence_id, one.actions) == (other.node_id, other.sequence_id, other.actions)


def _alternate(order: Order) -> Iterator[tuple[Node | Edge, ...]]:
    """Nodes and edges in the order of traversal."""
    for index, node in enumerate(order.nodes):
        yield (node, *order.edges[index : index + 1])
