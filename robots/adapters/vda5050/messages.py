"""The messages of VDA 5050 3.0 (order, instantActions, state, visualization, connection, factsheet) as checked data.

Field names and enumerations are the standard's (VDA 5050 3.0.0, chapter 7, and its JSON schemas); Python names are in
snake case, `json_of` writes the standard's. Fields that are not known here are kept. Messages of 2.x are translated
(`robots.adapters.vda5050.version2`). Metres, radians, seconds; headings counter-clockwise from the map's x axis.
"""

from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field
from pydantic.alias_generators import to_camel

from robots.data import StrEnum

MAX_THETA_RAD = 3.14159265359
"""The greatest heading of the published schemas, a little more than pi."""


def standard_name(name: str) -> str:
    """The standard's name of a field."""
    return "allowedDeviationXY" if name == "allowed_deviation_xy" else to_camel(name)


class Part(BaseModel):
    """Base of messages and their parts."""

    model_config = ConfigDict(
        alias_generator=standard_name, populate_by_name=True, extra="allow", frozen=True, allow_inf_nan=False
    )


class Headed(Part):
    """Base of messages: the protocol header (§7.2). `header_id` counts the messages of a topic."""

    header_id: int = 0
    timestamp: str = ""
    version: str = "3.0.0"
    manufacturer: str = ""
    serial_number: str = ""


MessageT = TypeVar("MessageT", bound=Headed)


def json_of(part: Part) -> dict[str, Any]:
    """The standard's form; what is not set is left out."""
    return part.model_dump(mode="json", by_alias=True, exclude_none=True)


class BlockingType(StrEnum):
    """What may happen beside an action."""

    NONE = "NONE"
    """Driving and other actions."""
    SINGLE = "SINGLE"
    """Driving, but no other action (3.0)."""
    SOFT = "SOFT"
    """Other actions, but no driving."""
    HARD = "HARD"
    """Nothing."""


class ActionStatus(StrEnum):
    """The life of an action."""

    WAITING = "WAITING"
    """Its node is not yet traversed, or its edge not yet entered."""
    INITIALIZING = "INITIALIZING"
    """Triggered; it is being prepared."""
    RUNNING = "RUNNING"
    """Being carried out."""
    PAUSED = "PAUSED"
    """By an instant action or by hand."""
    RETRIABLE = "RETRIABLE"
    """Failed, but may be tried again (3.0)."""
    FINISHED = "FINISHED"
    """Ended with its result."""
    FAILED = "FAILED"
    """Ended without."""

    @property
    def has_ended(self) -> bool:
        return self in (ActionStatus.FINISHED, ActionStatus.FAILED)


class ErrorLevel(StrEnum):
    """How grave an error is (§6.6.5.1)."""

    WARNING = "WARNING"
    """The order goes on."""
    URGENT = "URGENT"
    """The order goes on, but somebody should look after the vehicle (3.0)."""
    CRITICAL = "CRITICAL"
    """The order cannot go on, another one can (3.0)."""
    FATAL = "FATAL"
    """No order can go on: somebody must intervene."""

    @property
    def stops_the_order(self) -> bool:
        return self in (ErrorLevel.CRITICAL, ErrorLevel.FATAL)


class OperatingMode(StrEnum):
    """Who controls the vehicle (§6.6.6)."""

    STARTUP = "STARTUP"
    """Nobody yet (3.0)."""
    AUTOMATIC = "AUTOMATIC"
    """The master control."""
    SEMIAUTOMATIC = "SEMIAUTOMATIC"
    """The master control; a person sets the speed."""
    INTERVENED = "INTERVENED"
    """A person, for a while; the order is kept (3.0)."""
    MANUAL = "MANUAL"
    """A person; the order is cleared."""
    SERVICE = "SERVICE"
    """Authorised personnel; the order is cleared."""
    TEACH_IN = "TEACH_IN"
    """A person who teaches it; the order is cleared."""

    @property
    def takes_orders(self) -> bool:
        return self in (OperatingMode.AUTOMATIC, OperatingMode.SEMIAUTOMATIC, OperatingMode.INTERVENED)


class VehicleConnection(StrEnum):
    """Whether a vehicle is connected to the broker."""

    ONLINE = "ONLINE"
    """It is."""
    OFFLINE = "OFFLINE"
    """It has taken its leave."""
    HIBERNATING = "HIBERNATING"
    """It is, but sends no states (3.0)."""
    CONNECTION_BROKEN = "CONNECTION_BROKEN"
    """Its last will."""


class Connection(Headed):
    """Vehicle to master, retained (§7.7)."""

    connection_state: VehicleConnection


class ActionParameter(Part):
    """A value for an action by its key."""

    key: str
    value: Any


class Action(Part):
    """What a vehicle is to do at a node, on an edge or at once."""

    action_type: str
    action_id: str
    action_descriptor: str | None = None
    blocking_type: BlockingType = BlockingType.HARD
    action_parameters: tuple[ActionParameter, ...] = ()
    retriable: bool | None = None

    def parameter(self, key: str) -> Any:
        """The value of a parameter; None without it."""
        return next((one.value for one in self.action_parameters if one.key == key), None)


class Deviation(Part):
    """How far from a node a vehicle may be to be on it: semi-axes in metres, the ellipse turned by `theta`."""

    a: float = Field(ge=0)
    b: float = Field(ge=0)
    theta: float = 0.0


class NodePosition(Part):
    """A pose on a map. Without `theta` any heading will do."""

    x: float
    y: float
    theta: float | None = Field(default=None, ge=-MAX_THETA_RAD, le=MAX_THETA_RAD)
    allowed_deviation_xy: Deviation | None = None
    allowed_deviation_theta: float | None = Field(default=None, ge=0, le=MAX_THETA_RAD)
    map_id: str


class Node(Part):
    """A point of an order's route, with what is to be done there."""

    node_id: str
    sequence_id: int = Field(ge=0)
    node_descriptor: str | None = None
    released: bool
    node_position: NodePosition | None = None
    actions: tuple[Action, ...] = ()


class Edge(Part):
    """The way between the nodes before and after it."""

    edge_id: str
    sequence_id: int = Field(ge=0)
    edge_descriptor: str | None = None
    released: bool
    maximum_speed: float | None = None
    start_node_id: str | None = None
    """2.x; 3.0 goes by the sequence."""
    end_node_id: str | None = None
    actions: tuple[Action, ...] = ()


class Order(Headed):
    """Master to vehicle: the released base of a route, and beyond it the horizon (§7.3)."""

    order_id: str
    order_update_id: int = Field(ge=0)
    order_description: str | None = None
    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...] = ()


class InstantActions(Headed):
    """Master to vehicle: to be done at once (§7.4)."""

    actions: tuple[Action, ...]


class NodeState(Part):
    """A node that is still ahead."""

    node_id: str
    sequence_id: int
    released: bool = True
    node_descriptor: str | None = None
    node_position: NodePosition | None = None


class EdgeState(Part):
    """An edge that is still ahead."""

    edge_id: str
    sequence_id: int
    released: bool = True
    edge_descriptor: str | None = None


class ActionState(Part):
    """What has become of an action."""

    action_id: str
    action_type: str | None = None
    action_descriptor: str | None = None
    action_status: ActionStatus
    action_result: str | None = None


class MobileRobotPosition(Part):
    """A vehicle's pose on a map; not to be trusted unless `localized`."""

    x: float
    y: float
    theta: float
    map_id: str = ""
    localized: bool = True
    localization_score: float | None = None
    deviation_range: float | None = None


class Velocity(Part):
    """In the vehicle's frame, m/s and rad/s."""

    vx: float | None = None
    vy: float | None = None
    omega: float | None = None


class Load(Part):
    """What a vehicle carries."""

    load_id: str | None = None
    load_type: str | None = None
    load_position: str | None = None


class PowerSupply(Part):
    """`state_of_charge` in per cent."""

    state_of_charge: float
    charging: bool = False


class Reference(Part):
    """What an error is about."""

    reference_key: str
    reference_value: str


class VehicleError(Part):
    """An active error of a vehicle."""

    error_type: str
    error_level: ErrorLevel
    error_references: tuple[Reference, ...] = ()
    error_description: str | None = None
    error_hint: str | None = None

    def reference(self, key: str) -> str | None:
        """The value of the first reference of that key; None without one."""
        return next((one.reference_value for one in self.error_references if one.reference_key == key), None)

    @property
    def words(self) -> str:
        return f"{self.error_type}: {self.error_description}" if self.error_description else self.error_type


class SafetyState(Part):
    """An emergency stop is MANUAL, REMOTE or NONE."""

    active_emergency_stop: str = "NONE"
    field_violation: bool = False


class State(Headed):
    """Vehicle to master (§7.8). `loads` is None if the vehicle cannot tell."""

    order_id: str = ""
    order_update_id: int = 0
    last_node_id: str = ""
    last_node_sequence_id: int = 0
    node_states: tuple[NodeState, ...] = ()
    edge_states: tuple[EdgeState, ...] = ()
    mobile_robot_position: MobileRobotPosition | None = None
    velocity: Velocity | None = None
    loads: tuple[Load, ...] | None = None
    driving: bool = False
    paused: bool | None = None
    new_base_request: bool | None = None
    action_states: tuple[ActionState, ...] = ()
    instant_action_states: tuple[ActionState, ...] = ()
    power_supply: PowerSupply = PowerSupply(state_of_charge=100.0)
    operating_mode: OperatingMode = OperatingMode.AUTOMATIC
    errors: tuple[VehicleError, ...] = ()
    safety_state: SafetyState = SafetyState()

    @property
    def is_idle(self) -> bool:
        """Nothing of an order is left to be done (§6.6.8)."""
        has_ended = all(one.action_status.has_ended for one in self.action_states)
        return has_ended and not self.node_states and not self.edge_states

    def status_of(self, action_id: str) -> ActionStatus | None:
        """The state of an action, of the order or instant; None if the vehicle does not have it."""
        for one in (*self.action_states, *self.instant_action_states):
            if one.action_id == action_id:
                return one.action_status
        return None


class Visualization(Headed):
    """Vehicle to master, often (§7.9)."""

    reference_state_header_id: int = 0
    mobile_robot_position: MobileRobotPosition | None = None
    velocity: Velocity | None = None


class TypeSpecification(Part):
    """A vehicle's kind. The schema of 3.0.0 requires `mobileRobotKinematic` and describes `mobileRobotKinematics`."""

    series_name: str = ""
    series_description: str | None = None
    mobile_robot_kinematics: str | None = None
    mobile_robot_kinematic: str | None = None
    mobile_robot_class: str = ""
    maximum_load_mass: float = 0.0
    localization_types: tuple[str, ...] = ()
    navigation_types: tuple[str, ...] = ()


class PhysicalParameters(Part):
    """Limits and measures of a vehicle."""

    minimum_speed: float = 0.0
    maximum_speed: float = 0.0
    minimum_angular_speed: float | None = None
    maximum_angular_speed: float | None = None
    maximum_acceleration: float = 0.0
    maximum_deceleration: float = 0.0
    minimum_height: float = 0.0
    maximum_height: float = 0.0
    width: float = 0.0
    length: float = 0.0


class SupportedAction(Part):
    """An action that a vehicle can do. The schema of 3.0.0 has the last two as text, "true" or "false"."""

    action_type: str
    action_scopes: tuple[str, ...] = ()
    blocking_types: tuple[str, ...] | None = None
    pause_allowed: str | bool = "true"
    cancel_allowed: str | bool = "true"


class ProtocolFeatures(Part):
    """What of the protocol a vehicle supports."""

    optional_parameters: tuple[dict[str, Any], ...] = ()
    mobile_robot_actions: tuple[SupportedAction, ...] = ()


class Timing(Part):
    """Intervals between messages, seconds."""

    minimum_order_interval: float = 0.0
    minimum_state_interval: float = 0.0
    default_state_interval: float | None = None
    visualization_interval: float | None = None


class ProtocolLimits(Part):
    """Limits of messages."""

    maximum_string_lengths: dict[str, Any] = Field(default_factory=dict)
    maximum_array_lengths: dict[str, Any] = Field(default_factory=dict)
    timing: Timing = Timing()


class VehicleFactsheet(Headed):
    """Vehicle to master: what the vehicle is (§7.10)."""

    type_specification: TypeSpecification = TypeSpecification()
    physical_parameters: PhysicalParameters = PhysicalParameters()
    protocol_limits: ProtocolLimits = ProtocolLimits()
    protocol_features: ProtocolFeatures = ProtocolFeatures()
    mobile_robot_geometry: dict[str, Any] = Field(default_factory=dict)
    load_specification: dict[str, Any] = Field(default_factory=dict)

    @property
    def says_something(self) -> bool:
        """False for one that has neither a speed nor actions, as of a vehicle that is still starting."""
        has_actions = bool(self.protocol_features.mobile_robot_actions)
        return has_actions or self.physical_parameters.maximum_speed > 0
