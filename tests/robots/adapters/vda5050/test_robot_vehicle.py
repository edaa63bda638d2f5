"""A robot of Macta under another master control: our own driver plays the master, a stub the robot."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field

import pytest

from robots.adapters.driver import ProgressState
from robots.adapters.vda5050.codec import Encoder, decode
from robots.adapters.vda5050.messages import (
    Action,
    ActionParameter,
    ActionStatus,
    BlockingType,
    Edge,
    ErrorLevel,
    Headed,
    InstantActions,
    Node,
    NodePosition,
    Order,
    State,
)
from robots.adapters.vda5050.robot_vehicle import RobotVehicle
from robots.adapters.vda5050.topics import Topic, VehicleId
from robots.adapters.vda5050.vehicle_driver import VehicleDriver
from robots.adapters.vda5050.vehicle_orders import MAX_ERRORS
from robots.clock import ManualClock
from robots.link import InMemoryLink
from robots.physical.body import RADIUS_M
from robots.wire import (
    Acknowledgement,
    Body,
    Control,
    ControlVerb,
    Factsheet,
    FailureCategory,
    Message,
    Performative,
    Receipt,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    Telemetry,
)
from tests.robots.adapters.vda5050.driven import ERRAND, SETTINGS
from tests.robots.adapters.vda5050.published_schemas import MAJORS, faults

WORK_S = 3.0


@dataclass
class StubRobot:
    """Carries scripts of one packet out by letting time pass."""

    link: InMemoryLink
    done: list[tuple[str, Mapping[str, str]]] = field(default_factory=list)
    fails: frozenset[str] = frozenset()
    receipts: int = 0
    x: float = 0.0
    y: float = 0.0
    holding: str | None = None
    is_deaf: bool = False
    _script: ScriptRequest | None = None
    _left_s: float = 0.0
    _paused: bool = False
    seen: set[str] = field(default_factory=set)

    def say(self, body: Body, reply: str | None = None) -> None:
        message = Message(
            performative=Performative.INFORM,
            sender="rover",
            receiver="service",
            sent_at_s=0.0,
            in_reply_to=reply,
            body=body,
        )
        self.link.send(message)

    def step(self, step_s: float) -> None:
        for message in [] if self.is_deaf else self.link.receive():
            self._hear(message)
        if self._script is None or self._paused:
            return
        self._left_s -= step_s
        if self._left_s <= 0:
            self._end(None)

    def _hear(self, message: Message) -> None:
        match message.body:
            case ScriptRequest(script=script) as request:
                if script.id not in self.seen:
                    self.seen.add(script.id)
                    self._script = request
                    self._left_s = WORK_S
                    self._paused = False
                self.say(Acknowledgement(script_id=script.id), message.id)
            case Control(script_id=script_id, verb=verb):
                self.say(Acknowledgement(script_id=script_id), message.id)
                if verb is ControlVerb.CANCEL and self._script is not None:
                    self._end(ScriptState.CANCELLED)
                self._paused = verb is ControlVerb.PAUSE
            case Receipt():
                self.receipts += 1

    def _end(self, state: ScriptState | None) -> None:
        assert self._script is not None
        packet = self._script.script.packets[0]
        if state is None:
            state = ScriptState.FAILED if packet.tag in self.fails else ScriptState.FINISHED
        if state is ScriptState.FINISHED:
            self.done.append((packet.tag, packet.arguments))
            place = SETTINGS.places.get(packet.arguments.get("ref2", ""))
            if place is not None:
                self.x, self.y = place.x, place.y
            if packet.tag == "DOCK":
                self.holding = packet.arguments["object"]
            if packet.tag == "RELEASE2":
                self.holding = None
        category = FailureCategory.ROBOT if state is ScriptState.FAILED else None
        report = ScriptReport(
            script_id=self._script.script.id, state=state, at_s=0.0, category=category, detail="as told"
        )
        self.say(report)
        self._script = None


class Mastered:
    """The robot, its vehicle and a driver as its master, in stepped time."""

    def __init__(self, major: int = 3) -> None:
        self.clock = ManualClock()
        self.id = VehicleId(manufacturer="macta", serial_number="rover", major=major)
        service_end, robot_end = InMemoryLink.pair()
        self._service_end = service_end
        self.robot = StubRobot(robot_end)
        self.sent: list[tuple[Topic, bytes]] = []
        self._codec = Encoder()
        self.vehicle = RobotVehicle("rover", self.id, SETTINGS, service_end, self.clock, self._publish)
        self.vehicle.enter_run("run")
        self.master = VehicleDriver("agv", self.id, SETTINGS, self.clock, self._to_vehicle)

    def _publish(self, topic: Topic, message: Headed) -> None:
        payload = self._codec.encode(self.id, topic, message)
        self.sent.append((topic, payload))
        self.master.heard(decode(self.id, topic, payload))

    def _to_vehicle(self, topic: Topic, message: Headed) -> None:
        self.vehicle.heard(decode(self.id, topic, self._codec.encode(self.id, topic, message)))

    def step(self, seconds: float, *, masters: bool = True) -> None:
        for _ in range(round(seconds * 10)):
            self.clock.advance(0.1)
            self.robot.step(0.1)
            for message in self._service_end.receive():
                self.vehicle.receive(message)
            where = Telemetry(
                at_s=0.0, x_m=self.robot.x, y_m=self.robot.y, heading_rad=0.0, holding=self.robot.holding
            )
            self.vehicle.told(where)
            self.vehicle.tick()
            if masters:
                self.master.advance()
                self.master.memory()
                self.master.flush(is_saved=True)

    def order(self, *nodes: Node, update: int = 0) -> Order:
        edges = [
            Edge(edge_id=f"e{one.sequence_id}", sequence_id=one.sequence_id - 1, released=one.released)
            for one in nodes[1:]
        ]
        order = Order(order_id="o", order_update_id=update, nodes=nodes, edges=tuple(edges))
        self.vehicle.heard(order)
        return order

    @property
    def state(self) -> State:
        self.vehicle.heard(InstantActions(actions=(_instant("stateRequest", f"s{self.clock.now_s()}"),)))
        self.step(0.1, masters=False)
        payload = next(one for topic, one in reversed(self.sent) if topic is Topic.STATE)
        state = decode(self.id, Topic.STATE, payload)
        assert isinstance(state, State)
        return state


def _instant(kind: str, action_id: str) -> Action:
    return Action(action_type=kind, action_id=action_id, blocking_type=BlockingType.NONE)


def _node(number: int, name: str, *actions: Action, released: bool = True) -> Node:
    return Node(node_id=name, sequence_id=number, released=released, actions=actions)


def _start() -> Node:
    position = NodePosition(x=0.0, y=0.0, map_id="default")
    return Node(node_id="start", sequence_id=0, released=True, node_position=position)


def _action(kind: str, action_id: str, **parameters: str) -> Action:
    given = tuple(ActionParameter(key=key, value=value) for key, value in parameters.items())
    return Action(action_type=kind, action_id=action_id, action_parameters=given)


@pytest.mark.parametrize("major", [2, 3])
def test_a_master_has_the_robot_carry_an_errand_out(major: int) -> None:
    mastered = Mastered(major)
    mastered.step(1.0)
    assert mastered.master.objection(ERRAND) is None
    for packet in ERRAND.packets:
        assert mastered.master.start(packet.model_copy(update={"id": f"s1/{packet.id}"})) is None
        for _ in range(60):
            mastered.step(1.0)
            if mastered.master.poll().state is not ProgressState.RUNNING:
                break
        assert mastered.master.poll().state is ProgressState.FINISHED
    tags = [(tag, arguments.get("ref1") or arguments.get("ref2")) for tag, arguments in mastered.robot.done]
    assert tags == [("NAVIGATE", "bay"), ("DOCK", "bay"), ("TRANSPORT", "door"), ("RELEASE2", "door")]
    assert mastered.robot.receipts == 4


@pytest.mark.parametrize("major", MAJORS)
def test_all_that_the_vehicle_publishes_is_valid_by_the_published_schemas(major: int) -> None:
    mastered = Mastered(major)
    mastered.robot.say(Factsheet(repertoire=("NAVIGATE",), speed_m_s=0.4, turn_rad_s=1.0))
    mastered.step(1.0)
    mastered.master.objection(ERRAND)
    mastered.robot.fails = frozenset({"DOCK"})
    for packet in ERRAND.packets[:2]:
        mastered.master.start(packet.model_copy(update={"id": f"s1/{packet.id}"}))
        mastered.step(20.0)
    assert {topic for topic, _ in mastered.sent} == {Topic.STATE, Topic.VISUALIZATION, Topic.FACTSHEET}
    assert [fault for topic, payload in mastered.sent for fault in faults(major, topic, payload)] == []


def test_the_factsheet_tells_the_rovers_size_and_speeds() -> None:
    mastered = Mastered()
    body = {"kind": "velocity", "acceleration_m_s2": 0.5}
    mastered.robot.say(Factsheet(repertoire=("NAVIGATE",), speed_m_s=0.4, turn_rad_s=1.0, body=body))
    mastered.step(1.0)
    told = mastered.vehicle.factsheet().physical_parameters
    assert (told.maximum_speed, told.maximum_angular_speed, told.maximum_acceleration) == (0.4, 1.0, 0.5)
    assert told.width == told.length == 2 * RADIUS_M


def test_a_step_that_fails_is_an_error_and_a_failed_action() -> None:
    mastered = Mastered()
    mastered.robot.fails = frozenset({"DOCK"})
    mastered.step(1.0, masters=False)
    mastered.order(_start(), _node(2, "bay", _action("pick", "p", loadId="sample")))
    mastered.step(10.0, masters=False)
    state = mastered.state
    assert state.status_of("p") is ActionStatus.FAILED
    assert [(one.error_type, one.error_level, one.error_description) for one in state.errors] == [
        ("ACTION_FAILED", "CRITICAL", "as told")
    ]


def test_the_horizon_is_not_driven_and_an_update_releases_it() -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    mastered.order(_start(), _node(2, "bay"), _node(4, "door", released=False))
    mastered.step(20.0, masters=False)
    assert [arguments["ref2"] for _, arguments in mastered.robot.done] == ["bay"]
    mastered.order(_node(2, "bay"), _node(4, "door"), update=1)
    mastered.step(10.0, masters=False)
    assert [arguments["ref2"] for _, arguments in mastered.robot.done] == ["bay", "door"]
    assert {one.rpartition("-")[0] for one in mastered.robot.seen} == {"vda5050-o"}, (
        "scripts are named by the order"
    )
    assert mastered.state.is_idle


def test_the_actions_of_a_horizon_that_an_update_replaces_are_forgotten() -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    before = _action("drop", "before", stationName="door")
    after = _action("drop", "after", stationName="door")
    mastered.order(_start(), _node(2, "bay"), _node(4, "door", before, released=False))
    mastered.step(20.0, masters=False)
    assert [one.action_id for one in mastered.state.action_states] == ["before"]
    mastered.order(_node(2, "bay"), _node(4, "door", after, released=False), update=1)
    assert [one.action_id for one in mastered.state.action_states] == ["after"]


def test_an_order_can_be_paused_resumed_and_cancelled() -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    mastered.order(_start(), _node(2, "bay"), _node(4, "door"))
    mastered.step(1.0, masters=False)
    mastered.vehicle.heard(InstantActions(actions=(_instant("startPause", "1"),)))
    mastered.step(20.0, masters=False)
    assert not mastered.robot.done
    mastered.vehicle.heard(InstantActions(actions=(_instant("stopPause", "2"),)))
    mastered.step(4.0, masters=False)
    assert len(mastered.robot.done) == 1
    mastered.vehicle.heard(InstantActions(actions=(_instant("cancelOrder", "3"),)))
    mastered.step(10.0, masters=False)
    assert len(mastered.robot.done) == 1
    assert mastered.state.is_idle
    assert mastered.state.status_of("3") is ActionStatus.FINISHED


def test_a_pause_is_told_once_the_robot_has_confirmed_it() -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    mastered.order(_start(), _node(2, "bay"))
    mastered.step(1.0, masters=False)
    mastered.robot.is_deaf = True
    mastered.vehicle.heard(InstantActions(actions=(_instant("startPause", "1"),)))
    mastered.step(1.0, masters=False)
    state = mastered.state
    assert (state.paused, state.driving, state.status_of("1")) == (False, True, ActionStatus.RUNNING)
    mastered.robot.is_deaf = False
    mastered.step(3.0, masters=False)
    state = mastered.state
    assert (state.paused, state.driving, state.status_of("1")) == (True, False, ActionStatus.FINISHED)


def test_an_action_that_has_failed_can_be_tried_again_or_left_out() -> None:
    mastered = Mastered()
    mastered.robot.fails = frozenset({"DOCK"})
    mastered.step(1.0, masters=False)
    pick = _action("pick", "p", loadId="sample").model_copy(update={"retriable": True})
    mastered.order(_start(), _node(2, "bay", pick), _node(4, "door"))
    mastered.step(20.0, masters=False)
    state = mastered.state
    assert state.status_of("p") is ActionStatus.RETRIABLE
    assert [one.error_level for one in state.errors] == [ErrorLevel.URGENT]
    retry = _instant("retry", "r").model_copy(
        update={"action_parameters": (ActionParameter(key="actionId", value="p"),)}
    )
    mastered.vehicle.heard(InstantActions(actions=(retry,)))
    mastered.step(10.0, masters=False)
    assert mastered.state.status_of("p") is ActionStatus.RETRIABLE
    skip = retry.model_copy(update={"action_type": "skipRetry", "action_id": "s"})
    mastered.vehicle.heard(InstantActions(actions=(skip,)))
    mastered.step(10.0, masters=False)
    state = mastered.state
    assert (state.status_of("p"), state.status_of("s")) == (ActionStatus.FAILED, ActionStatus.FINISHED)
    assert state.is_idle
    assert state.last_node_id == "door"


def test_a_retry_of_what_has_not_failed_is_refused() -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    mastered.vehicle.heard(InstantActions(actions=(_instant("retry", "r"),)))
    state = mastered.state
    assert state.status_of("r") is ActionStatus.FAILED
    assert [one.error_type for one in state.errors] == ["INVALID_INSTANT_ACTION"]


@pytest.mark.parametrize(
    ("blocking", "drives"),
    [
        (BlockingType.NONE, True),
        (BlockingType.SINGLE, True),
        (BlockingType.SOFT, False),
        (BlockingType.HARD, False),
    ],
)
def test_a_robot_drives_while_it_waits_if_the_blocking_type_lets_it(
    blocking: BlockingType, drives: bool
) -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    wait = _action("waitForTrigger", "w").model_copy(update={"blocking_type": blocking})
    mastered.order(_start(), _node(2, "bay", wait), _node(4, "door"))
    mastered.step(10.0, masters=False)
    assert mastered.state.status_of("w") is ActionStatus.RUNNING
    assert (mastered.state.last_node_id == "door") is drives


@pytest.mark.parametrize(
    ("blocking", "acts"),
    [
        (BlockingType.NONE, True),
        (BlockingType.SOFT, True),
        (BlockingType.SINGLE, False),
        (BlockingType.HARD, False),
    ],
)
def test_a_robot_acts_while_it_waits_if_the_blocking_type_lets_it(blocking: BlockingType, acts: bool) -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    wait = _action("waitForTrigger", "w").model_copy(update={"blocking_type": blocking})
    pick = _action("pick", "p", loadId="sample").model_copy(update={"blocking_type": BlockingType.SOFT})
    mastered.order(_start(), _node(2, "bay", wait, pick))
    mastered.step(10.0, masters=False)
    assert (mastered.state.status_of("p") is ActionStatus.FINISHED) is acts
    mastered.vehicle.heard(InstantActions(actions=(_instant("trigger", "t"),)))
    mastered.step(10.0, masters=False)
    assert mastered.state.is_idle


def test_a_new_base_is_requested_on_the_way_to_the_last_released_node() -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    mastered.order(_start(), _node(2, "bay"), _node(4, "door"), _node(6, "bay", released=False))
    mastered.step(1.0, masters=False)
    assert mastered.state.new_base_request is False
    mastered.step(4.0, masters=False)
    assert mastered.state.new_base_request is True
    mastered.order(_node(4, "door"), _node(6, "bay"), update=1)
    assert mastered.state.new_base_request is False


@pytest.mark.parametrize(
    ("nodes", "update", "error"),
    [
        ((_node(2, "bay"), _node(4, "door")), 0, "SAME_ORDER_UPDATE_ID"),
        ((_node(4, "bay"), _node(6, "door")), 2, "VALIDATION_FAILURE"),
        ((_node(2, "door"), _node(4, "bay")), 2, "VALIDATION_FAILURE"),
    ],
)
def test_an_update_that_does_not_continue_the_order_is_rejected_and_the_order_goes_on(
    nodes: tuple[Node, ...], update: int, error: str
) -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    mastered.order(_start(), _node(2, "bay"))
    mastered.order(*nodes, update=update)
    mastered.step(10.0, masters=False)
    state = mastered.state
    assert [one.error_type for one in state.errors] == [error]
    assert (state.order_update_id, state.last_node_id, state.is_idle) == (0, "bay", True)


def test_an_outdated_update_and_one_of_a_cancelled_order_are_rejected() -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    mastered.order(_start(), _node(2, "bay"), _node(4, "door", released=False))
    mastered.order(_node(2, "bay"), _node(4, "door"), update=3)
    mastered.order(_node(2, "bay"), _node(4, "door"), update=2)
    assert [one.error_type for one in mastered.state.errors] == ["OUTDATED_ORDER_UPDATE"]
    mastered.vehicle.heard(InstantActions(actions=(_instant("cancelOrder", "c"),)))
    mastered.step(10.0, masters=False)
    mastered.order(_node(4, "door"), _node(6, "bay"), update=4)
    assert [one.error_type for one in mastered.state.errors][-1] == "ORDER_UPDATE_FOLLOWING_CANCEL"
    assert mastered.state.is_idle


def test_a_completed_order_can_be_continued() -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    mastered.order(_start(), _node(2, "bay"))
    mastered.step(10.0, masters=False)
    mastered.order(_node(2, "bay"), _node(4, "door"), update=1)
    mastered.step(10.0, masters=False)
    assert (mastered.state.last_node_id, mastered.state.is_idle) == ("door", True)


def test_what_is_no_order_is_a_validation_failure_and_errors_stay_few() -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    mastered.vehicle.heard_no_message(Topic.ORDER)
    assert [one.error_type for one in mastered.state.errors] == ["VALIDATION_FAILURE"]
    for number in range(100):
        order = Order(order_id=f"o{number}", order_update_id=1, nodes=(_start(),), edges=())
        mastered.vehicle.heard(order)
    assert len(mastered.state.errors) == MAX_ERRORS


def test_a_robot_waits_for_its_trigger() -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    mastered.order(_start(), _node(2, "bay", _action("waitForTrigger", "w")), _node(4, "door"))
    mastered.step(20.0, masters=False)
    assert mastered.state.status_of("w") is ActionStatus.RUNNING
    mastered.vehicle.heard(InstantActions(actions=(_instant("trigger", "t"),)))
    mastered.step(10.0, masters=False)
    assert [arguments["ref2"] for _, arguments in mastered.robot.done] == ["bay", "door"]


def test_a_node_that_is_no_place_is_a_way_point() -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    position = NodePosition(x=1.0, y=-2.0, map_id="default")
    mastered.order(_start(), Node(node_id="n7", sequence_id=2, released=True, node_position=position))
    mastered.step(10.0, masters=False)
    assert mastered.robot.done == [("MOVE_TO", {"x": "1.000", "y": "-2.000"})]


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"edges": ()}, "VALIDATION_FAILURE"),
        ({"order_update_id": 3}, "VALIDATION_FAILURE"),
        ({"nodes": (_start(), _node(2, "nowhere"))}, "NO_ROUTE_TO_TARGET"),
        ({"nodes": (_start(), _node(2, "bay", _action("fly", "f")))}, "INVALID_ORDER_ACTION"),
        ({"nodes": (_start(), _node(2, "bay", _action("pick", "p")))}, "INVALID_ORDER_ACTION"),
    ],
)
def test_an_order_that_cannot_be_taken_is_rejected_by_the_standards_error(
    change: dict[str, object], error: str
) -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    edge = Edge(edge_id="e", sequence_id=1, released=True)
    order = Order(order_id="o", order_update_id=0, nodes=(_start(), _node(2, "bay")), edges=(edge,))
    mastered.vehicle.heard(order.model_copy(update=change))
    mastered.step(5.0, masters=False)
    state = mastered.state
    assert [one.error_type for one in state.errors] == [error]
    assert state.order_id == ""
    assert not mastered.robot.done


def test_an_order_whose_first_node_has_no_position_begins_wherever_the_robot_stands() -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    mastered.order(_node(0, "anywhere"), _node(2, "bay"))
    mastered.step(10.0, masters=False)
    assert mastered.state.errors == ()
    assert len(mastered.robot.done) == 1


def test_a_repeated_order_is_ignored_and_another_is_refused_while_it_lasts() -> None:
    mastered = Mastered()
    mastered.step(1.0, masters=False)
    order = mastered.order(_start(), _node(2, "bay"))
    mastered.vehicle.heard(order.model_copy(update={"header_id": 9}))
    mastered.vehicle.heard(order.model_copy(update={"order_id": "other"}))
    mastered.step(10.0, masters=False)
    assert [one.error_type for one in mastered.state.errors] == ["OTHER_ORDER_ACTIVE"]
    assert len(mastered.robot.done) == 1
    assert json.loads(mastered.sent[0][1])["serialNumber"] == "rover"
