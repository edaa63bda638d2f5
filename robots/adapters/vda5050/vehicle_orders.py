"""The vehicle's side of orders, for a robot that another master control drives: accepts them, and makes steps of them.

By VDA 5050 3.0, §6.1 (orders), §6.2 (actions) and §6.6 (states). Pure: what a step is done with is told by its end.
The robot has one body, so of a node's actions only those that wait for a trigger go on beside others, or beside
driving, as their blocking types allow (§6.2.2).
"""

from collections.abc import Mapping
from math import dist
from typing import Literal

from pydantic import Field

from robots.adapters.vda5050.frame import Frame
from robots.adapters.vda5050.messages import (
    Action,
    ActionState,
    ActionStatus,
    BlockingType,
    Edge,
    EdgeState,
    ErrorLevel,
    InstantActions,
    Node,
    NodeState,
    Order,
    Reference,
    State,
    VehicleError,
)
from robots.adapters.vda5050.settings import Settings
from robots.adapters.vda5050.topics import Topic
from robots.data import Memory

ON_NODE_M = 0.6
"""Within this distance of a node's place, the robot stands on it."""
INSTANT = (
    "startPause",
    "stopPause",
    "cancelOrder",
    "stateRequest",
    "factsheetRequest",
    "trigger",
    "retry",
    "skipRetry",
    "clearInstantActions",
)
"""The instant actions that are supported."""
AT_NODES: Mapping[str, str] = {"pick": "DOCK", "drop": "RELEASE2", "waitForTrigger": ""}
"""The actions that are supported at nodes, with the packet that carries each out."""

ALONE = (BlockingType.SINGLE, BlockingType.HARD)
"""No other action goes on beside one of these."""
STANDING = (BlockingType.SOFT, BlockingType.HARD)
"""The robot does not drive during one of these."""

MAX_ERRORS = 32
"""As many errors are reported, the newest ones."""
MAX_ENDED = 100
"""As many instant actions that have ended are known, the newest ones; a copy of an older one is done again."""

Point = tuple[float, float]


class Step(Memory):
    """What the robot does now: drive to a node, or carry an action out."""

    number: int
    kind: Literal["drive", "act"]
    tag: str
    arguments: dict[str, str]
    action: Action | None = None


class OrdersMemory(Memory):
    """The whole state; it outlives restarts.

    `nodes` and `edges`: those ahead; `queue`: the actions of the last node that are still to be done; `waiting`: those
    that wait for a trigger; `retriable`: one that has failed and may be tried again; `cancel_id`: the cancelOrder that
    is under way; `paused`: what is asked for, `stands`: the robot does so, `pause_id`: the startPause or stopPause that
    has not ended; `place`: where the robot was driven last; `holding`: what it picked up.
    """

    order: Order | None = None
    nodes: list[Node] = Field(default_factory=list)
    edges: list[Edge] = Field(default_factory=list)
    decision: Node | None = None
    last_node_id: str = ""
    last_sequence: int = 0
    actions: dict[str, ActionState] = Field(default_factory=dict)
    instant: dict[str, ActionState] = Field(default_factory=dict)
    queue: list[Action] = Field(default_factory=list)
    waiting: list[Action] = Field(default_factory=list)
    retriable: Action | None = None
    step: Step | None = None
    steps: int = 0
    is_cancelled: bool = False
    cancel_id: str = ""
    paused: bool = False
    stands: bool = False
    pause_id: str = ""
    errors: list[VehicleError] = Field(default_factory=list)
    place: str | None = None
    holding: str | None = None


class VehicleOrders:
    """`take_order` and `take_instant` with what arrives, `next_step` often, `end_step` when one has ended."""

    def __init__(self, settings: Settings, frame: Frame, memory: OrdersMemory | None = None) -> None:
        self._settings = settings
        self._frame = frame
        self.memory = OrdersMemory() if memory is None else memory.saved()

    @property
    def is_idle(self) -> bool:
        memory = self.memory
        return not memory.nodes and all(one.action_status.has_ended for one in memory.actions.values())

    def state(self) -> State:
        """What of the state is about orders."""
        memory = self.memory
        return State(
            order_id=memory.order.order_id if memory.order else "",
            order_update_id=memory.order.order_update_id if memory.order else 0,
            last_node_id=memory.last_node_id,
            last_node_sequence_id=memory.last_sequence,
            node_states=tuple(
                NodeState(node_id=one.node_id, sequence_id=one.sequence_id, released=one.released)
                for one in memory.nodes
            ),
            edge_states=tuple(
                EdgeState(edge_id=one.edge_id, sequence_id=one.sequence_id, released=one.released)
                for one in memory.edges
            ),
            action_states=tuple(memory.actions.values()),
            instant_action_states=tuple(memory.instant.values()),
            driving=self.is_driving and not memory.stands,
            paused=memory.stands,
            new_base_request=self._needs_base,
            errors=tuple(memory.errors),
        )

    @property
    def is_driving(self) -> bool:
        return self.memory.step is not None and self.memory.step.kind == "drive"

    @property
    def _needs_base(self) -> bool:
        """The robot is on its way to the decision point, or there, and nodes beyond it are planned."""
        ahead = self.memory.nodes
        return any(not one.released for one in ahead) and sum(one.released for one in ahead) <= 1

    # Orders

    def take_order(self, order: Order, at: Point | None) -> None:
        """Accept an order or an update, or note the error that says why not (§6.1.2, figure 8).

        :param at: where the robot is on its map; None if that is not known.
        """
        current = self.memory.order
        fault = self._fault(order)
        if fault is None and (current is None or current.order_id != order.order_id):
            fault = self._fault_of_new(order, at)
            if fault is None:
                self._begin(order)
        elif fault is None and current is not None:
            if order.order_update_id == current.order_update_id and order == _as_headed(current, order):
                return
            fault = self._fault_of_update(order, current)
            if fault is None:
                self._extend(order)
        if fault is not None:
            self._note_error(
                fault, topic=Topic.ORDER, orderId=order.order_id, orderUpdateId=str(order.order_update_id)
            )

    def _fault(self, order: Order) -> str | None:
        """Why no vehicle of this kind can take the order."""
        numbers = [one.sequence_id for one in order.nodes]
        is_alternating = [one.sequence_id for one in order.edges] == [one + 1 for one in numbers[:-1]]
        is_in_sequence = (
            numbers == list(range(numbers[0], numbers[0] + 2 * len(numbers), 2)) if numbers else False
        )
        released = [one.released for one in order.nodes]
        is_base_first = bool(released) and released[0] and released == sorted(released, reverse=True)
        if not (is_alternating and is_in_sequence and is_base_first):
            return "VALIDATION_FAILURE"
        if any(edge.actions for edge in order.edges):
            return "INVALID_ORDER_ACTION"
        for action in (action for node in order.nodes for action in node.actions):
            lacks_load = action.action_type in ("pick", "drop") and action.parameter("loadId") is None
            if action.action_type not in AT_NODES or (lacks_load and action.action_type == "pick"):
                return "INVALID_ORDER_ACTION"
        positions = [node.node_position for node in order.nodes if node.node_position is not None]
        if any(one.map_id != self._frame.map_id for one in positions):
            return "UNKNOWN_MAP_ID"
        if any(self._goal(node) is None for node in order.nodes[1:]):
            return "NO_ROUTE_TO_TARGET"
        return None

    def _fault_of_new(self, order: Order, at: Point | None) -> str | None:
        if not self.is_idle:
            return "OTHER_ORDER_ACTIVE"
        if order.order_update_id != 0:
            return "VALIDATION_FAILURE"
        start = order.nodes[0].node_position
        if start is None or at is None:
            return None if at is not None else "START_NODE_OUT_OF_RANGE"
        permitted = start.allowed_deviation_xy
        reach_m = max(ON_NODE_M * self._frame.scale, max(permitted.a, permitted.b) if permitted else 0.0)
        return None if dist(at, (start.x, start.y)) <= reach_m else "START_NODE_OUT_OF_RANGE"

    def _fault_of_update(self, order: Order, current: Order) -> str | None:
        if order.order_update_id < current.order_update_id:
            return "OUTDATED_ORDER_UPDATE"
        if order.order_update_id == current.order_update_id:
            return "SAME_ORDER_UPDATE_ID"
        if self.memory.is_cancelled:
            return "ORDER_UPDATE_FOLLOWING_CANCEL"
        first = order.nodes[0]
        known = self.memory.decision
        is_stitched = known is not None and (first.node_id, first.sequence_id) == (
            known.node_id,
            known.sequence_id,
        )
        return None if is_stitched else "VALIDATION_FAILURE"

    def _begin(self, order: Order) -> None:
        memory = self.memory
        memory.is_cancelled = False
        memory.errors = []
        memory.actions = {}
        memory.order = order
        memory.nodes = list(order.nodes)
        memory.edges = list(order.edges)
        self._add_actions(memory.nodes)
        self._decide(order)
        self._arrive()

    def _extend(self, order: Order) -> None:
        memory = self.memory
        for action in (action for node in memory.nodes if not node.released for action in node.actions):
            memory.actions.pop(action.action_id, None)
        memory.nodes = [one for one in memory.nodes if one.released] + list(order.nodes[1:])
        memory.edges = [one for one in memory.edges if one.released] + list(order.edges)
        memory.order = order
        memory.errors = []
        self._add_actions(order.nodes[1:])
        self._decide(order)

    def _decide(self, order: Order) -> None:
        self.memory.decision = [one for one in order.nodes if one.released][-1]

    def _add_actions(self, nodes: list[Node] | tuple[Node, ...]) -> None:
        for action in (action for node in nodes for action in node.actions):
            self._set(action.action_id, action.action_type, ActionStatus.WAITING)

    def refuse_malformed(self) -> None:
        """Note that what came as an order is none (§6.1.4.1)."""
        self._note_error("VALIDATION_FAILURE", topic=Topic.ORDER)

    # Steps

    def next_step(self) -> Step | None:
        """What the robot is to do now; the same until it has ended. None if nothing, or paused."""
        memory = self.memory
        while memory.step is None and not self._is_held:
            if memory.queue and not self._must_wait(memory.queue[0]):
                self._begin_action(memory.queue.pop(0))
            elif not memory.queue and memory.nodes and memory.nodes[0].released and not self._must_stand:
                self._begin_drive(memory.nodes[0])
            else:
                break
        if memory.step is None:
            self.confirm_pause()
        return memory.step

    @property
    def _is_held(self) -> bool:
        memory = self.memory
        return memory.paused or memory.is_cancelled or memory.retriable is not None

    def _must_wait(self, action: Action) -> bool:
        """Whether an action must not be begun before those that wait for a trigger have ended."""
        going_on = [one.blocking_type for one in self.memory.waiting]
        return bool(going_on) and (action.blocking_type in ALONE or any(one in ALONE for one in going_on))

    @property
    def _must_stand(self) -> bool:
        return any(one.blocking_type in STANDING for one in self.memory.waiting)

    def confirm_pause(self) -> None:
        """The robot has been paused, or goes on, as it was asked to."""
        memory = self.memory
        memory.stands = memory.paused
        self._end_instant(memory.pause_id, ActionStatus.FINISHED)
        memory.pause_id = ""

    def end_step(self, failure: str | None) -> None:
        """:param failure: why the step has failed; None if it has been done."""
        memory = self.memory
        step = memory.step
        memory.step = None
        if step is None:
            return
        if failure is None and step.kind == "drive":
            self._arrive()
        elif failure is None:
            self._set_step(step, ActionStatus.FINISHED)
            memory.holding = step.arguments.get("object") if step.tag == "DOCK" else None
        elif memory.cancel_id:
            self._conclude_cancel()
        elif step.action is not None and step.action.retriable:
            memory.retriable = step.action
            self._set_step(step, ActionStatus.RETRIABLE)
            self._note_failure(step.action, failure, ErrorLevel.URGENT)
        else:
            self._set_step(step, ActionStatus.FAILED)
            if step.action is not None:
                self._note_failure(step.action, failure)
            else:
                node = memory.nodes[0].node_id
                self._note_error(
                    "NODE_UNREACHABLE", ErrorLevel.CRITICAL, failure, topic=Topic.ORDER, nodeId=node
                )
            self._give_up()
        if memory.cancel_id and memory.step is None:
            self._conclude_cancel()

    def _give_up(self) -> None:
        """Do nothing more of the order: only a cancelOrder helps."""
        self.memory.is_cancelled = True
        self._begin_pause(paused=False)

    def _note_failure(self, action: Action, words: str, level: ErrorLevel = ErrorLevel.CRITICAL) -> None:
        self._note_error("ACTION_FAILED", level, words, topic=Topic.ORDER, actionId=action.action_id)

    def _begin_action(self, action: Action) -> None:
        memory = self.memory
        tag = AT_NODES[action.action_type]
        self._set(action.action_id, action.action_type, ActionStatus.RUNNING)
        if not tag:
            memory.waiting.append(action)
            return
        thing = str(action.parameter("loadId") or memory.holding or "")
        place = str(action.parameter("stationName") or memory.place or "")
        where = "ref1" if tag == "DOCK" else "ref2"
        self._step("act", tag, {"object": thing, where: place}, action)

    def _begin_drive(self, node: Node) -> None:
        """Drive on, unless the robot is there: nodes may follow each other at the same place."""
        memory = self.memory
        goal = self._goal(node)
        assert goal is not None
        place = goal.get("ref2")
        if place is not None and place == memory.place:
            self._arrive()
            return
        memory.place = place
        if place is None:
            self._step("drive", "MOVE_TO", goal)
        elif memory.holding:
            self._step("drive", "TRANSPORT", {"object": memory.holding, **goal})
        else:
            self._step("drive", "NAVIGATE", goal)

    def _step(
        self,
        kind: Literal["drive", "act"],
        tag: str,
        arguments: dict[str, str],
        action: Action | None = None,
    ) -> None:
        memory = self.memory
        memory.steps += 1
        memory.step = Step(number=memory.steps, kind=kind, tag=tag, arguments=arguments, action=action)

    def _goal(self, node: Node) -> dict[str, str] | None:
        """The arguments of a packet that drives to a node: a place by name or position, else a point; None for none."""
        by_node = {known.node or name: name for name, known in self._settings.places.items()}
        if node.node_id in by_node:
            return {"ref2": by_node[node.node_id]}
        if node.node_position is None:
            return None
        x, y, _ = self._frame.in_world((node.node_position.x, node.node_position.y, 0.0))
        for name, known in self._settings.places.items():
            if dist((x, y), known.pose(near=(x, y))[:2]) <= ON_NODE_M / 2:
                return {"ref2": name}
        return {"x": f"{x:.3f}", "y": f"{y:.3f}"}

    def _arrive(self) -> None:
        memory = self.memory
        node = memory.nodes.pop(0)
        if node.sequence_id and memory.edges:
            memory.edges.pop(0)
        memory.last_node_id = node.node_id
        memory.last_sequence = node.sequence_id
        memory.queue = [*memory.queue, *node.actions]

    # Instant actions

    def take_instant(self, message: InstantActions) -> list[str]:
        """Carry out what can be done here; the types of all that were new, for what must be done elsewhere."""
        new = [one for one in message.actions if one.action_id not in self.memory.instant]
        for action in new:
            self._take_one(action)
        return [one.action_type for one in new]

    def _take_one(self, action: Action) -> None:
        memory = self.memory
        done = ActionStatus.FINISHED
        match action.action_type:
            case "startPause" | "stopPause":
                self._begin_pause(paused=action.action_type == "startPause")
                memory.pause_id = action.action_id
                done = ActionStatus.RUNNING
            case "cancelOrder":
                done = self._cancel(action)
            case "trigger":
                done = self._trigger()
            case "retry" | "skipRetry":
                done = self._retry(action, skips=action.action_type == "skipRetry")
            case "clearInstantActions":
                memory.instant = {k: v for k, v in memory.instant.items() if not v.action_status.has_ended}
            case "stateRequest" | "factsheetRequest":
                pass
            case _:
                done = ActionStatus.FAILED
                self._note_error(
                    "INVALID_INSTANT_ACTION", topic=Topic.INSTANT_ACTIONS, actionId=action.action_id
                )
        state = ActionState(action_id=action.action_id, action_type=action.action_type, action_status=done)
        memory.instant[action.action_id] = state
        ended = [key for key, one in memory.instant.items() if one.action_status.has_ended]
        for key in ended[:-MAX_ENDED]:
            del memory.instant[key]

    def _begin_pause(self, *, paused: bool) -> None:
        """Ask for a pause or its end; what was asked for before has failed if it has not ended."""
        self._end_instant(self.memory.pause_id, ActionStatus.FAILED)
        self.memory.pause_id = ""
        self.memory.paused = paused

    def _end_instant(self, action_id: str, status: ActionStatus) -> None:
        known = self.memory.instant.get(action_id)
        if known is not None:
            self.memory.instant[action_id] = known.model_copy(update={"action_status": status})

    def _trigger(self) -> ActionStatus:
        """What waits for a trigger has ended."""
        memory = self.memory
        if not memory.waiting:
            return ActionStatus.FAILED
        for action in memory.waiting:
            self._set(action.action_id, None, ActionStatus.FINISHED)
        memory.waiting = []
        return ActionStatus.FINISHED

    def _retry(self, action: Action, *, skips: bool) -> ActionStatus:
        """Do the failed action again, or go on without it."""
        memory = self.memory
        failed = memory.retriable
        if failed is None or action.parameter("actionId") != failed.action_id:
            self._note_error("INVALID_INSTANT_ACTION", topic=Topic.INSTANT_ACTIONS, actionId=action.action_id)
            return ActionStatus.FAILED
        memory.retriable = None
        memory.errors = [one for one in memory.errors if one.reference("actionId") != failed.action_id]
        if skips:
            self._set(failed.action_id, None, ActionStatus.FAILED)
        else:
            memory.queue.insert(0, failed)
        return ActionStatus.FINISHED

    def _cancel(self, action: Action) -> ActionStatus:
        memory = self.memory
        wanted = action.parameter("orderId")
        is_other = memory.order is None or wanted not in (None, memory.order.order_id)
        if is_other or self.is_idle or memory.cancel_id:
            self._note_error("NO_ORDER_TO_CANCEL", topic=Topic.INSTANT_ACTIONS, actionId=action.action_id)
            return ActionStatus.FAILED
        memory.is_cancelled = True
        self._begin_pause(paused=False)
        if memory.step is None:
            self._clear()
            return ActionStatus.FINISHED
        memory.cancel_id = action.action_id
        return ActionStatus.RUNNING

    def _conclude_cancel(self) -> None:
        """The robot stands: the order is given up."""
        memory = self.memory
        self._end_instant(memory.cancel_id, ActionStatus.FINISHED)
        memory.cancel_id = ""
        self._clear()

    def clear(self) -> None:
        """Give the order up at once: the robot has forgotten it."""
        self.memory.step = None
        self.memory.is_cancelled = True
        self._conclude_cancel()

    def _clear(self) -> None:
        memory = self.memory
        memory.nodes = []
        memory.edges = []
        memory.queue = []
        memory.waiting = []
        memory.retriable = None
        memory.place = None
        for one in list(memory.actions.values()):
            if not one.action_status.has_ended:
                self._set(one.action_id, None, ActionStatus.FAILED)

    def _set_step(self, step: Step, status: ActionStatus) -> None:
        if step.action is not None:
            self._set(step.action.action_id, None, status)

    def _set(self, action_id: str, kind: str | None, status: ActionStatus) -> None:
        known = self.memory.actions.get(action_id)
        kind = kind if kind is not None else known.action_type if known else None
        self.memory.actions[action_id] = ActionState(
            action_id=action_id, action_type=kind, action_status=status
        )

    def _note_error(
        self, kind: str, level: ErrorLevel = ErrorLevel.WARNING, words: str = "", **about: str
    ) -> None:
        references = tuple(
            Reference(reference_key=key, reference_value=value) for key, value in about.items()
        )
        error = VehicleError(
            error_type=kind,
            error_level=level,
            error_references=references,
            error_description=words or None,
        )
        if error not in self.memory.errors:
            self.memory.errors = [*self.memory.errors, error][-MAX_ERRORS:]


def _as_headed(order: Order, other: Order) -> Order:
    """The order with another's header, to compare what they say."""
    header = {
        name: getattr(other, name)
        for name in ("header_id", "timestamp", "version", "manufacturer", "serial_number")
    }
    return order.model_copy(update=header)
