"""A robot of Macta as a vehicle of another master control, which takes the place of Macta's service.

Each step of an order is a script of one packet. Call `tick` at 10 Hz; messages of the master come by `heard`.
"""

import logging
from collections.abc import Callable
from math import degrees
from typing import Any

from pydantic import ValidationError

from robots.adapters.vda5050.frame import Pose
from robots.adapters.vda5050.messages import (
    MAX_THETA_RAD,
    Headed,
    InstantActions,
    Load,
    MobileRobotPosition,
    Order,
    PhysicalParameters,
    PowerSupply,
    ProtocolFeatures,
    ProtocolLimits,
    State,
    SupportedAction,
    Timing,
    TypeSpecification,
    VehicleFactsheet,
    Visualization,
)
from robots.adapters.vda5050.orders import fit_id
from robots.adapters.vda5050.settings import Settings
from robots.adapters.vda5050.topics import Topic, VehicleId
from robots.adapters.vda5050.vehicle_orders import AT_NODES, INSTANT, OrdersMemory, Step, VehicleOrders
from robots.clock import Clock
from robots.contract.memory_file import MemoryStore
from robots.data import Checked
from robots.link import Link
from robots.wire import (
    Acknowledgement,
    BehaviourPacket,
    BehaviourScript,
    Body,
    Control,
    ControlVerb,
    Factsheet,
    Message,
    PacketReport,
    Performative,
    Receipt,
    Refusal,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    StatusReport,
    Telemetry,
    UpkeepReport,
)

SERVICE = "service"
ACCELERATION_M_S2 = 1.0
"""Of a robot that does not state its own."""
BODY_M = 0.44
"""Diameter of a rover's round body."""
RESEND_S = 2.0
STATE_S = 15.0
"""A state is published at least this often; the standard asks for 30 s."""
VISUALIZATION_S = 0.5
MAX_EARLY = 8
"""Orders that are kept until it is known where the robot is, the newest ones."""
STEP_S = 3600.0
"""The time limit of a step: the master control has none (§6.2.3, waitForTrigger), so it cancels what takes too long."""

logger = logging.getLogger(__name__)


class SavedVehicle(Checked):
    """What outlives a restart: the orders, and the number of controls of the present script."""

    orders: OrdersMemory
    controls: int = 0
    run: str = ""


class RobotVehicle:
    """One robot. `link` is the service's end of its world's link, or a part of it that holds this robot's messages."""

    def __init__(
        self,
        robot: str,
        vehicle: VehicleId,
        settings: Settings,
        link: Link,
        clock: Clock,
        publish: Callable[[Topic, Headed], None],
        *,
        store: MemoryStore | None = None,
    ) -> None:
        """
        :param clock: the wall clock.
        :param publish: to the master control; headers are filled in there.
        """
        self.robot = robot
        self.vehicle = vehicle
        self._settings = settings
        self._frame = settings.frame_of(vehicle)
        self._link = link
        self._clock = clock
        self._publish = publish
        self._store = store
        self._telemetry: Telemetry | None = None
        self._sheet: Factsheet | None = None
        self._run = ""
        self._controls = 0
        self._answered: set[str] = set()
        self._sent_s: dict[str, float] = {}
        self._told_paused = False
        self._published: State | None = None
        self._published_s = float("-inf")
        self._shown_s = float("-inf")
        self._asked: list[str] = []
        self._early: list[Order] = []
        self._saved = ""
        self._orders = VehicleOrders(settings, self._frame, self._load())

    @property
    def pose(self) -> Pose | None:
        """Where the robot is on the map; None before its first telemetry."""
        told = self._telemetry
        return None if told is None else self._frame.on_map((told.x_m, told.y_m, told.heading_rad))

    def enter_run(self, run: str) -> None:
        """The world's run; in another one the robot has forgotten its order."""
        if self._run and run != self._run:
            self._orders.clear()
            self._sent_s = {}
            self._answered = set()
        self._run = run

    def heard(self, message: Headed) -> None:
        """Take a message of the master control."""
        if isinstance(message, Order) and self.pose is None:
            self._early = [*self._early, message][-MAX_EARLY:]
        elif isinstance(message, Order):
            self._orders.take_order(message, self.pose[:2] if self.pose is not None else None)
        elif isinstance(message, InstantActions):
            self._asked += self._orders.take_instant(message)

    def heard_no_message(self, topic: Topic) -> None:
        """Note that what the master has sent is no message of its topic."""
        if topic is Topic.ORDER:
            self._orders.refuse_malformed()

    def told(self, telemetry: Telemetry) -> None:
        """Take the robot's telemetry, and orders that came before the first one."""
        self._telemetry = telemetry
        early, self._early = self._early, []
        for order in early:
            self.heard(order)

    def receive(self, message: Message) -> None:
        """Take a message of the robot, and confirm its reports."""
        match message.body:
            case Acknowledgement():
                self._answered.add(message.in_reply_to or "")
            case Refusal(script_id=script_id, reason=reason):
                self._answered.add(message.in_reply_to or "")
                if script_id == self._script_id and (message.in_reply_to or "").startswith("script"):
                    self._end_step(reason)
            case ScriptReport() as report:
                self._take_end(report)
                self._confirm(message)
            case Factsheet() as sheet:
                self._sheet = sheet
                self._confirm(message)
            case PacketReport() | UpkeepReport() | StatusReport():
                self._confirm(message)

    def tick(self) -> None:
        """Send what is due to the robot and to the master."""
        step = self._orders.next_step()
        if not self._save():
            return
        if step is not None:
            self._drive(step)
        self._tell_master()

    # The robot

    @property
    def _script_id(self) -> str:
        step = self._orders.memory.step
        order = self._orders.memory.order
        number = step.number if step is not None else 0
        return f"vda5050-{fit_id(order.order_id if order else '')}-{number}"

    def _drive(self, step: Step) -> None:
        """Give the robot the step's script, and have it paused or cancelled as the master wants."""
        memory = self._orders.memory
        script_id = self._script_id
        self._ask(f"script {script_id}", Performative.REQUEST, ScriptRequest(script=self._script(step)))
        if memory.paused is not self._told_paused:
            self._told_paused = memory.paused
            self._controls += 1
        if self._controls:
            verb = ControlVerb.PAUSE if memory.paused else ControlVerb.RESUME
            key = f"{verb} {script_id} {self._controls}"
            self._ask(key, Performative.REQUEST, self._control(verb))
            if key in self._answered:
                self._orders.confirm_pause()
        else:
            self._orders.confirm_pause()
        if memory.cancel_id:
            self._ask(f"cancel {script_id}", Performative.CANCEL, self._control(ControlVerb.CANCEL))

    def _control(self, verb: ControlVerb) -> Control:
        number = self._controls + (verb is ControlVerb.CANCEL)
        return Control(script_id=self._script_id, verb=verb, number=number)

    def _script(self, step: Step) -> BehaviourScript:
        packet = BehaviourPacket(
            id="1",
            tag=step.tag,
            arguments=step.arguments,
            expected_start_s=0.0,
            expected_duration_s=30.0,
            timeout_s=STEP_S,
            wait_timeout_s=STEP_S,
        )
        return BehaviourScript(
            id=self._script_id, mission_id=self._script_id, robot=self.robot, packets=(packet,)
        )

    def _ask(self, key: str, performative: Performative, body: Body) -> None:
        """Send a request until the robot has answered it."""
        now_s = self._clock.now_s()
        if key in self._answered or now_s - self._sent_s.get(key, float("-inf")) < RESEND_S:
            return
        self._sent_s[key] = now_s
        self._link.send(
            Message(
                id=key,
                performative=performative,
                sender=SERVICE,
                receiver=self.robot,
                sent_at_s=now_s,
                body=body,
            )
        )

    def _confirm(self, report: Message) -> None:
        self._link.send(
            Message(
                performative=Performative.CONFIRM,
                sender=SERVICE,
                receiver=self.robot,
                sent_at_s=self._clock.now_s(),
                in_reply_to=report.id,
                body=Receipt(),
            )
        )

    def _take_end(self, report: ScriptReport) -> None:
        if report.script_id == self._script_id and self._orders.memory.step is not None:
            is_done = report.state is ScriptState.FINISHED
            self._end_step(None if is_done else report.detail or str(report.state))

    def _end_step(self, failure: str | None) -> None:
        self._orders.end_step(failure)
        self._controls = 0
        self._told_paused = False
        self._sent_s = {}
        self._answered = set()

    # The master control

    def _tell_master(self) -> None:
        now_s = self._clock.now_s()
        asked, self._asked = self._asked, []
        if "factsheetRequest" in asked:
            self._publish(Topic.FACTSHEET, self.factsheet())
        if self._telemetry is None:
            return
        state = self._state(self._telemetry)
        is_asked = "stateRequest" in asked or now_s - self._published_s >= STATE_S
        if is_asked or _told(state) != _told(self._published):
            self._published = state
            self._published_s = now_s
            self._publish(Topic.STATE, state)
        if now_s - self._shown_s >= VISUALIZATION_S:
            self._shown_s = now_s
            self._publish(Topic.VISUALIZATION, Visualization(mobile_robot_position=self._position()))

    def _position(self) -> MobileRobotPosition | None:
        if self.pose is None:
            return None
        x, y, theta = self.pose
        bounded = max(-MAX_THETA_RAD, min(MAX_THETA_RAD, theta))
        return MobileRobotPosition(x=x, y=y, theta=bounded, map_id=self._frame.map_id)

    def _state(self, told: Telemetry) -> State:
        loads = (Load(load_id=told.holding),) if told.holding else ()
        update: dict[str, Any] = {
            "mobile_robot_position": self._position(),
            "loads": loads,
            "power_supply": PowerSupply(
                state_of_charge=round(100.0 * max(0.0, min(1.0, told.battery)), 1), charging=told.charging
            ),
        }
        return self._orders.state().model_copy(update=update)

    def factsheet(self) -> VehicleFactsheet:
        """What the robot is, by its own factsheet as far as it has told one."""
        sheet = self._sheet
        speed = sheet.speed_m_s if sheet is not None else self._settings.speed_m_s
        turn = sheet.turn_rad_s if sheet is not None else self._settings.turn_rad_s
        ramps = sheet.body if sheet is not None and isinstance(sheet.body, dict) else {}
        nodes = [_supported(kind, "NODE") for kind in AT_NODES]
        return VehicleFactsheet(
            type_specification=TypeSpecification(
                series_name="Macta robot",
                series_description=f"{self.robot}, which turns at {degrees(turn):.0f} degrees a second",
                mobile_robot_kinematics="DIFFERENTIAL",
                mobile_robot_kinematic="DIFFERENTIAL",
                mobile_robot_class="CARRIER",
                maximum_load_mass=0.0,
                localization_types=("NATURAL",),
                navigation_types=("FREELY_NAVIGATING",),
            ),
            physical_parameters=PhysicalParameters(
                maximum_speed=speed * self._frame.scale,
                maximum_angular_speed=turn,
                maximum_acceleration=ramps.get("acceleration_m_s2", ACCELERATION_M_S2) * self._frame.scale,
                maximum_deceleration=ramps.get("acceleration_m_s2", ACCELERATION_M_S2) * self._frame.scale,
                width=BODY_M * self._frame.scale,
                length=BODY_M * self._frame.scale,
            ),
            protocol_limits=ProtocolLimits(timing=Timing(default_state_interval=STATE_S)),
            protocol_features=ProtocolFeatures(
                mobile_robot_actions=(*nodes, *(_supported(kind, "INSTANT") for kind in INSTANT))
            ),
        )

    # Memory

    def _load(self) -> OrdersMemory | None:
        text = self._store.load() if self._store is not None else None
        if text is None:
            return None
        try:
            saved = SavedVehicle.model_validate_json(text)
        except ValidationError as error:
            logger.warning("%s: its memory %s is not used: %s", self.robot, self._store, error)
            return None
        self._controls = saved.controls
        self._run = saved.run
        self._told_paused = saved.controls % 2 == 1  # the first control of a script is a pause
        return saved.orders

    def _save(self) -> bool:
        """True if the memory is on the disk as it is."""
        if self._store is None:
            return True
        saved = SavedVehicle(orders=self._orders.memory, controls=self._controls, run=self._run)
        text = saved.model_dump_json(exclude_defaults=True)
        if text == self._saved:
            return True
        try:
            self._store.save(text)
        except OSError as error:
            logger.error("%s: its memory %s cannot be saved: %s", self.robot, self._store, error)
            return False
        self._saved = text
        return True


def _supported(kind: str, scope: str) -> SupportedAction:
    return SupportedAction(action_type=kind, action_scopes=(scope,))


def _told(state: State | None) -> State | None:
    """What of a state makes it worth publishing at once (§6.6): all but where the robot is, and the charge."""
    if state is None:
        return None
    charging = PowerSupply(state_of_charge=0.0, charging=state.power_supply.charging)
    return state.model_copy(update={"mobile_robot_position": None, "power_supply": charging})
