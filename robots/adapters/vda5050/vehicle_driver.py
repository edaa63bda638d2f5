"""Carries packets out on one VDA 5050 vehicle. Holds no connection: messages come by `heard` and go by `send`.

What is ordered is remembered, and saved, before it is sent; and every message may be lost, so it is sent again until
the vehicle's state shows that it has arrived. Vehicles know orders, updates and instant actions by their ids, so a
repetition is not done twice; after a restart the driver goes on with the same ids.
"""

import logging
from collections.abc import Callable, Mapping
from typing import Any

from robots.adapters.driver import Progress, ProgressState
from robots.adapters.vda5050.frame import Pose
from robots.adapters.vda5050.instant_requests import RESEND_S, InstantRequests
from robots.adapters.vda5050.messages import (
    ActionStatus,
    Connection,
    ErrorLevel,
    Headed,
    State,
    VehicleConnection,
    VehicleFactsheet,
    Visualization,
)
from robots.adapters.vda5050.orders import ORDER_PREFIX, Leg, OrderError, Route, fit_id, route, why_not
from robots.adapters.vda5050.own_state import facts_of, faults_of, telemetry_of
from robots.adapters.vda5050.progress import Stage, Standing, leg_progress, standing, stopping_error
from robots.adapters.vda5050.settings import Settings
from robots.adapters.vda5050.topics import Topic, VehicleId
from robots.adapters.vda5050.vehicle_memory import VehicleMemory
from robots.clock import Clock
from robots.wire import BehaviourPacket, BehaviourScript, FaultReport, Telemetry

SILENCE_S = 35.0
"""A vehicle states itself every 30 s at least (§6.6); after this time it is asked to."""
BUSY_SILENCE_S = 5.0
"""Likewise while something is expected of it: the state that shows it may be lost."""
CLEARED_AT = 32
"""As many instant actions in a vehicle's state are cleared, if it can (3.0)."""
OUTDATED_STATES = 5
"""As many states in a row that count on among themselves, but are older than the newest known, are from a vehicle that
has started again with its clock set back."""
LATE_S = 15.0
"""A message that has not arrived by then is lost (our choice)."""
LOST_S = 8.0
"""A vehicle that does not show its order for so long has lost it (our choice)."""
FAULTS_S = 1.0
"""Changed faults are reported at most as often."""
KEPT_SCRIPTS = 4
AWAY = (VehicleConnection.OFFLINE, VehicleConnection.CONNECTION_BROKEN)

logger = logging.getLogger(__name__)


class VehicleDriver:
    """A `PacketDriver` with memory. One thread calls `heard`, `advance`, the robot's tick and `flush` in turn."""

    def __init__(
        self,
        robot: str,
        vehicle: VehicleId,
        settings: Settings,
        clock: Clock,
        send: Callable[[Topic, Headed], None],
    ) -> None:
        """
        :param robot: its name in the world.
        :param send: sends a message to the vehicle; its header is filled in there.
        """
        self.robot = robot
        self.vehicle = vehicle
        self.factsheet: VehicleFactsheet | None = None
        self.connection: VehicleConnection | None = None
        self.state: State | None = None
        self.pose: Pose | None = None
        """Where the vehicle is in the world; None if that is not known."""
        self._settings = settings
        self._frame = settings.frame_of(vehicle)
        self._clock = clock
        self._send = send
        self._memory = VehicleMemory()
        self._saved: Mapping[str, Any] = self._memory.model_dump(mode="json")
        self._has_changed = False
        self._outbox: list[tuple[Topic, Headed]] = []
        self._ready = 0
        self._heard_s = float("-inf")
        self._connection_s = float("-inf")
        self._outdated: list[int] = []
        self._order_sent_s = float("-inf")
        self._faults_s = float("-inf")
        self._unknown_s: float | None = None
        """Since when the vehicle's states do not show the order that it has confirmed."""
        self._resumed_s = clock.now_s()
        self._requests = InstantRequests(vehicle, clock, self._post)

    # What the vehicle says

    def heard(self, message: Headed) -> None:
        """Take a message of the vehicle."""
        match message:
            case State():
                self._take_state(message)
            case Visualization():
                self._take_pose(message)
            case Connection(connection_state=connection):
                if connection is not self.connection:
                    if self.connection is VehicleConnection.HIBERNATING:
                        self.state = None  # its order is cleared
                    self._outdated = []
                    self._requests.ask_anew()
                self.connection = connection
                self._connection_s = self._clock.now_s()
            case VehicleFactsheet():
                if message.says_something:
                    self.factsheet = message

    def _take_state(self, state: State) -> None:
        if self._is_outdated(state):
            return
        self._outdated = []
        self.state = state
        self._heard_s = self._clock.now_s()
        self._take_pose(state)
        # NOTE: the last will of a connection that was lost may come after the new connection's first message.
        if self.connection in AWAY and self._heard_s - self._connection_s >= RESEND_S:
            self.connection = VehicleConnection.ONLINE
        if len(state.instant_action_states) >= CLEARED_AT and self._can("clearInstantActions"):
            self._requests.once("clearInstantActions")

    def _can(self, action: str) -> bool:
        known = self.factsheet.protocol_features.mobile_robot_actions if self.factsheet is not None else ()
        return any(one.action_type == action for one in known)

    def _is_outdated(self, state: State) -> bool:
        """True for a state that was overtaken by a newer one."""
        known = self.state
        if known is None or state.header_id > known.header_id or state.timestamp > known.timestamp:
            return False
        self._outdated = [*self._outdated, state.header_id][-OUTDATED_STATES:]
        pairs = zip(self._outdated, self._outdated[1:], strict=False)
        return len(self._outdated) < OUTDATED_STATES or any(one >= other for one, other in pairs)

    def _take_pose(self, message: State | Visualization) -> None:
        at = message.mobile_robot_position
        if at is not None and at.localized:
            self.pose = self._frame.in_world((at.x, at.y, at.theta))

    # What is asked of it

    def objection(self, script: BehaviourScript) -> str | None:
        """Why the vehicle cannot carry a script out; None if it can. It is remembered, to tell what lies ahead."""
        for packet in script.packets:
            if (reason := why_not(packet, self._settings)) is not None:
                return reason
        kept = list(self._memory.scripts.items())[-KEPT_SCRIPTS + 1 :]
        self._memory.scripts = dict(kept) | {script.id: script}
        self._touch()
        return None

    def start(self, packet: BehaviourPacket) -> str | None:
        memory = self._memory
        if memory.packet is not None and memory.packet.id == packet.id:
            self.resume()  # a pause is told again after a restart
            return None
        if (reason := why_not(packet, self._settings)) is not None:
            return reason
        if memory.route is not None:
            index = memory.route.index(packet.id)
            if index is None or index > memory.released:
                self._drop_route()
        memory.packet = packet
        memory.outcome = None
        memory.detail = ""
        memory.stop = None
        self._touch()
        return None

    def poll(self) -> Progress:
        memory = self._memory
        perceived = self._perceived()
        if memory.outcome == "finished":
            return Progress(state=ProgressState.FINISHED)
        if memory.outcome == "failed":
            return Progress(state=ProgressState.FAILED, detail=memory.detail, perceived=perceived)
        return Progress(detail=self.waits_for, perceived=perceived)

    def pause(self) -> None:
        if self._memory.paused is not True:
            self._memory.paused = True
            self._memory.requests += 1
            self._memory.pause_id = self._requests.id_of("startPause", self._memory.requests)
            self._touch()

    def resume(self) -> None:
        if self._memory.paused:
            self._memory.paused = False
            self._memory.requests += 1
            self._resumed_s = self._clock.now_s()
            self._touch()

    def cancel(self) -> None:
        self.resume()
        self._stop("was cancelled")

    def telemetry(self) -> Telemetry | None:
        is_away = self.connection in AWAY or self._clock.now_s() - self._heard_s > 2 * SILENCE_S
        if self.state is None or self.pose is None or is_away:
            return None
        goal = self.leg.nodes[0].node_position if self.leg is not None else None
        goal_pose = None if goal is None else self._frame.in_world((goal.x, goal.y, 0.0))
        return telemetry_of(
            self.state, self.pose, at_s=self._clock.now_s(), holding=self.holding, goal=goal_pose
        )

    def changed_faults(self) -> FaultReport | None:
        """The vehicle's faults if they are others than those reported before, at most once in `FAULTS_S`."""
        now_s = self._clock.now_s()
        if self.state is None or now_s - self._faults_s < FAULTS_S:
            return None
        faults = faults_of(self.state)
        if faults == self._memory.faults:
            return None
        self._faults_s = now_s
        self._memory.faults = faults
        self._touch()
        return FaultReport(at_s=now_s, faults=faults)

    @property
    def holding(self) -> str | None:
        """What the vehicle holds: by what it says, else by the packets that are done."""
        loads = self.state.loads if self.state is not None else None
        if loads is None:
            return self._memory.holding
        if not loads:
            return None
        return self._memory.holding or loads[0].load_id or "load"

    @property
    def leg(self) -> Leg | None:
        """The part of the order that carries out the packet begun last; None if there is none."""
        memory = self._memory
        if memory.route is None or memory.packet is None:
            return None
        index = memory.route.index(memory.packet.id)
        return None if index is None else memory.route.legs[index]

    @property
    def waits_for(self) -> str:
        """Why the vehicle has not begun the packet, in words; empty if it has."""
        memory = self._memory
        state = self.state
        if state is None:
            return "the vehicle has not told its state"
        if memory.cancelling is not None:
            return "the vehicle gives up an earlier order"
        if state.safety_state.active_emergency_stop != "NONE":
            return "the vehicle's emergency stop is active"
        if state.power_supply.charging:
            return "the vehicle charges"
        leg = self.leg
        if leg is None or memory.route is None:
            return "the vehicle has no order yet"
        how, _ = standing(state, memory.route.order_id, memory.released)
        return "" if how is Standing.ACCEPTED else "the vehicle has not confirmed its order"

    # Memory

    def memory(self) -> Mapping[str, Any]:
        """As of now. What was sent with it may go out once it is saved, by `flush`."""
        if self._has_changed:
            self._has_changed = False
            self._saved = self._memory.model_dump(mode="json", exclude_defaults=True)
        self._ready = len(self._outbox)
        return self._saved

    def recall(self, memory: Mapping[str, Any]) -> None:
        self._memory = VehicleMemory.model_validate(memory)
        self._touch()

    def forget(self) -> None:
        """Be as after a restart, before `recall`; what the vehicle has said is kept."""
        self._memory = VehicleMemory()
        self._requests.forget_all()
        self._order_sent_s = float("-inf")
        self._outbox = []
        self._touch()

    @property
    def is_at_rest(self) -> bool:
        """True if what is to be sent depends on no memory."""
        return self._active is None and self._memory.cancelling is None and self._memory.paused is None

    def flush(self, *, is_saved: bool) -> None:
        """Send what depends on nothing that is not saved.

        :param is_saved: the memory was saved as `memory` last gave it; else nothing is sent, and it is decided again.
        """
        ready, self._outbox = self._outbox[: self._ready], self._outbox[self._ready :]
        self._ready = 0
        if is_saved:
            for topic, message in ready:
                self._send(topic, message)

    def _touch(self) -> None:
        self._has_changed = True

    # What is sent

    def advance(self) -> None:
        """Decide what to send; call it often."""
        if self.connection is VehicleConnection.HIBERNATING:
            if self._active is not None:  # it takes nothing else (§6.2.3.1)
                self._request("stopHibernation")
            return
        if self.factsheet is None:
            self._requests.ask_for_factsheet()
        if self.state is None or self._is_silent():
            self._requests.ask_for_state()
        if self.state is None or self.connection in AWAY:
            return
        self._keep_paused_or_not(self.state)
        if self._gives_up_orders(self.state):
            return
        if self._active is not None and self._memory.stop is not None:
            self._conclude_stop(self._memory.stop, self.state)
        elif self._active is not None:
            self._carry_out(self._active, self.state)

    @property
    def _active(self) -> BehaviourPacket | None:
        """The packet that was begun and has not ended."""
        return self._memory.packet if self._memory.outcome is None else None

    def _carry_out(self, packet: BehaviourPacket, state: State) -> None:
        memory = self._memory
        if memory.route is None and not self._make_route(packet, state):
            return
        assert memory.route is not None
        wanted = memory.route.index(packet.id)
        assert wanted is not None
        how, reason = standing(state, memory.route.order_id, memory.released)
        if how is not Standing.UNKNOWN:
            self._unknown_s = None
        if how is Standing.REJECTED:
            self._stop(f"was not taken by the vehicle: {reason}")
        elif how is Standing.UNKNOWN and memory.confirmed:
            self._take_up_lost(packet, memory.route, wanted, state)
        elif how is not Standing.ACCEPTED:
            self._send_order()
        else:
            self._follow(packet, memory.route, wanted, state)

    def _follow(self, packet: BehaviourPacket, current: Route, wanted: int, state: State) -> None:
        """The vehicle has what was ordered: release the packet, or see how far it has come."""
        memory = self._memory
        if not memory.confirmed:
            memory.confirmed = True
            self._touch()
        if memory.released <= wanted:
            if self._has_cleared_horizon(state):
                logger.warning(
                    "%s has cleared the order %s; it is given a new one", self.vehicle, current.order_id
                )
                memory.route = None
                self._touch()
            elif self._may_go(packet, state):
                memory.released = wanted + 1
                self._touch()
                self._order_sent_s = float("-inf")
                self._send_order()
            return
        progress = leg_progress(state, current.legs[wanted])
        if progress.stage is Stage.DONE:
            self._finish(packet, wanted)
        elif progress.stage is Stage.FAILED:
            self._stop(progress.reason)

    def _has_cleared_horizon(self, state: State) -> bool:
        """True if the vehicle has cleared what is still ahead of its order, as it does before it hibernates."""
        return self._settings.horizon and self._memory.released > 0 and state.is_idle

    def _make_route(self, packet: BehaviourPacket, state: State) -> bool:
        """Plan the order for this packet and those after it; False if that must wait, or failed."""
        memory = self._memory
        if not state.is_idle:
            self._stop(f"cannot begin: the vehicle carries out {state.order_id} of another master control")
            return False
        if not self._may_go(packet, state):
            return False
        at = state.mobile_robot_position
        if at is None or not at.localized:
            self._stop("cannot begin: the vehicle does not know where it is")
            return False
        script_id = packet.id.rpartition("/")[0]
        script = memory.scripts.get(script_id)
        packets = [packet]
        if script is not None:
            given = [one.model_copy(update={"id": f"{script_id}/{one.id}"}) for one in script.packets]
            ids = [one.id for one in given]
            packets = given[ids.index(packet.id) :] if packet.id in ids else packets
        attempts = memory.attempts.get(script_id, 0) + 1
        memory.attempts = {script_id: attempts}
        order_id = f"{ORDER_PREFIX}{fit_id(script_id or packet.id)}.{attempts}"
        try:
            memory.route = route(order_id, packets, (at.x, at.y, at.theta), self._settings, self._frame)
        except OrderError as error:
            self._stop(str(error))
            return False
        memory.released = 0
        memory.finished = 0
        memory.confirmed = False
        self._touch()
        self._order_sent_s = float("-inf")
        return True

    def _may_go(self, packet: BehaviourPacket, state: State) -> bool:
        """Whether the vehicle takes orders now: it has a mode that does, no grave error, and does not charge."""
        if not state.operating_mode.takes_orders:
            self._stop(f"cannot begin: the vehicle's operating mode is {state.operating_mode}")
            return False
        if (error := stopping_error(state)) is not None and error.error_level is ErrorLevel.FATAL:
            self._stop(f"cannot begin: {error.words}")
            return False
        if state.safety_state.active_emergency_stop != "NONE":
            return False
        acts = {action.type for action in self._settings.all_packets[packet.tag].actions}
        if state.power_supply.charging and not acts & {"startCharging", "stopCharging"}:
            self._request("stopCharging")
            return False
        return True

    def _take_up_lost(self, packet: BehaviourPacket, lost: Route, index: int, state: State) -> None:
        """The vehicle no longer has the order: begin a new one, unless it may have done what must not be done twice."""
        memory = self._memory
        now_s = self._clock.now_s()
        self._unknown_s = now_s if self._unknown_s is None else self._unknown_s
        if now_s - self._unknown_s < LOST_S or self._heard_s - self._unknown_s < LOST_S - RESEND_S:
            self._requests.ask_for_state()  # the state may be an old one that was on its way for long
            return
        self._unknown_s = None
        if not state.is_idle:
            self._stop(f"cannot go on: the vehicle carries out {state.order_id} of another master control")
        elif memory.released > index and lost.legs[index].actions:
            what = " and ".join(action.action_type for action in lost.legs[index].actions)
            self._stop(f"is uncertain: the vehicle has lost its order and may have done {what}")
        else:
            logger.warning("%s has lost the order %s; it is given a new one", self.vehicle, lost.order_id)
            memory.route = None
            self._touch()

    def _send_order(self) -> None:
        now_s = self._clock.now_s()
        memory = self._memory
        if memory.route is None or now_s - self._order_sent_s < RESEND_S:
            return
        self._order_sent_s = now_s
        self._post(Topic.ORDER, memory.route.update(memory.released, horizon=self._settings.horizon))

    def _finish(self, packet: BehaviourPacket, index: int) -> None:
        memory = self._memory
        rule = self._settings.all_packets[packet.tag]
        memory.outcome = "finished"
        memory.stop = None
        memory.finished = index + 1
        if rule.grips is not None:
            memory.holding = packet.arguments.get(rule.grips)
        if rule.releases is not None:
            memory.holding = None
        self._touch()

    # Ends before time

    def _stop(self, reason: str) -> None:
        """End the packet: the vehicle gives its order up, and once it stands, the packet has ended."""
        memory = self._memory
        if self._active is None or memory.stop is not None:
            return
        memory.stop = reason
        if memory.route is not None:
            memory.cancelling = memory.route.order_id
            memory.requests += 1
        self._touch()

    def _conclude_stop(self, reason: str, state: State) -> None:
        """The vehicle has nothing more to do: the packet has failed, if it was not done before."""
        memory = self._memory
        packet = memory.packet
        assert packet is not None
        if memory.route is not None:
            how, _ = standing(state, memory.route.order_id, memory.released)
            is_on_its_way = how in (Standing.UNKNOWN, Standing.OUTDATED)
            if is_on_its_way and self._heard_s < self._order_sent_s + RESEND_S:
                self._requests.ask_for_state()
                return
            leg = self.leg if how is Standing.ACCEPTED else None
            if leg is not None and leg_progress(state, leg).stage is Stage.DONE:
                self._finish(packet, memory.route.legs.index(leg))
                self._drop_route()
                return
        memory.outcome = "failed"
        memory.detail = reason
        memory.stop = None
        self._drop_route()

    def _drop_route(self) -> None:
        """Forget the order; if the vehicle may still have something of it to do, it must give it up."""
        memory = self._memory
        if memory.route is not None and memory.finished < len(memory.route.legs):
            memory.cancelling = memory.route.order_id
            memory.requests += 1
        memory.route = None
        memory.released = 0
        memory.finished = 0
        memory.confirmed = False
        self._touch()

    def _gives_up_orders(self, state: State) -> bool:
        """True while the vehicle must give up an order of ours that is not wanted any longer, however it came by it."""
        memory = self._memory
        current = memory.route.order_id if memory.route is not None else None
        is_stray = state.order_id.startswith(ORDER_PREFIX) and state.order_id != current and not state.is_idle
        if is_stray and memory.cancelling != state.order_id:
            memory.cancelling = state.order_id
            memory.requests += 1
            self._touch()
        if memory.cancelling is None:
            return False
        if state.order_id != memory.cancelling or state.is_idle:
            memory.cancelling = None
            self._touch()
            self._requests.forget("cancelOrder")
            return False
        self._request("cancelOrder", orderId=memory.cancelling)
        return True

    # Instant actions

    def _keep_paused_or_not(self, state: State) -> None:
        """Have the vehicle paused or go on as asked. A pause by hand is left alone."""
        wanted = self._memory.paused
        if wanted is None:
            return
        if wanted:
            is_resumed_by_hand = state.status_of(self._memory.pause_id) is ActionStatus.FINISHED
            if not state.paused and not is_resumed_by_hand:
                self._request("startPause", action_id=self._memory.pause_id)
        elif state.paused:
            self._request("stopPause")
        elif self._pause_is_over(state):
            self._memory.paused = None
            self._touch()
            self._requests.forget("startPause")
            self._requests.forget("stopPause")

    def _pause_is_over(self, state: State) -> bool:
        """True if the startPause that was sent last is not still on its way."""
        was_received = state.status_of(self._memory.pause_id) is not None
        return was_received or self._clock.now_s() - self._resumed_s >= LATE_S

    def _request(self, kind: str, *, action_id: str = "", **parameters: str) -> None:
        """Ask for an instant action: again and again, with the same id until it has ended without effect.

        :param action_id: if it is another than that of the newest request.
        """
        if not self._requests.is_due(kind):
            return
        newest = self._requests.id_of(kind, self._memory.requests)
        status = self.state.status_of(newest) if self.state is not None else None
        if not action_id and status is not None and status.has_ended:
            self._memory.requests += 1
            self._touch()
        known = action_id or self._requests.id_of(kind, self._memory.requests)
        self._requests.send(kind, known, **parameters)

    def _post(self, topic: Topic, message: Headed) -> None:
        self._outbox.append((topic, message))

    def _is_silent(self) -> bool:
        """True if a state is overdue."""
        memory = self._memory
        is_expected = self._active is not None or memory.cancelling is not None or memory.paused is False
        return self._clock.now_s() - self._heard_s >= (BUSY_SILENCE_S if is_expected else SILENCE_S)

    def _perceived(self) -> tuple[Any, ...]:
        return facts_of(self.robot, self.pose, self.holding, self._settings)
