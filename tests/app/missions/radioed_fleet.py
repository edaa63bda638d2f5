"""Robots that carry scripts out in stepped time, behind a radio that delays, loses and repeats messages.

With `peers` they also speak with each other, over a radio of their own that is as poor.
"""

import heapq
import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import count

from app.agents.agent_models import Reception
from app.domain.lifecycles.script import order_label, unanswered_order
from app.store import ScriptRow
from robots.clock import ManualClock
from robots.executive.offer import Declined, Declining, Offer
from robots.executive.society import Clearing
from robots.social import SocialLevel
from robots.wire import (
    Acknowledgement,
    BehaviourPacket,
    BehaviourScript,
    Body,
    Message,
    PacketReport,
    PacketState,
    Performative,
    ScriptReport,
    ScriptState,
    SpeechReport,
    StatusReport,
    SymbolicFact,
    Telemetry,
)
from tests.app.missions.mission_services import WORLD, MissionServices

LONGEST_DELAY_S = 4.0
LOST = 0.1
"""The share of messages that do not arrive."""
AGAIN_S = 6.0
"""A message is sent again after this time until it is answered."""
LOOK_S = 4.0
"""Time between two reviews of the mission, if no report arrives."""
LONGEST_CUT_S = 600.0
"""A radio to the service that is cut is back after this time at the latest."""
GIVEN_UP_S = 2000.0
"""A mission that has not ended by then never does."""


@dataclass(slots=True)
class Robot:
    """A robot with its script.

    :param obeys: it awaits what its packets await; one that does not begins each as soon as it can.
    """

    name: str
    obeys: bool = True
    script: BehaviourScript | None = None
    done: int = 0
    runs: bool = False
    state: ScriptState = ScriptState.ACCEPTED
    cleared: set[str] = field(default_factory=set)
    began_s: dict[str, float] = field(default_factory=dict)
    ended_s: dict[str, float] = field(default_factory=dict)
    place: str = ""
    holding: str | None = None
    said_by: dict[str, set[str]] = field(default_factory=dict)
    social: SocialLevel | None = None

    @property
    def next(self) -> BehaviourPacket | None:
        if self.script is None or self.state not in (ScriptState.ACCEPTED, ScriptState.RUNNING):
            return None
        return self.script.packets[self.done] if self.done < len(self.script.packets) else None


class RadioedFleet:
    """One mission and its robots: a queue of events, each at its time."""

    def __init__(
        self,
        services: MissionServices,
        clock: ManualClock,
        mission_id: str,
        seed: int,
        *,
        disobedient: tuple[str, ...] = (),
        peers: bool = False,
        is_cut: bool = False,
        paces: dict[str, tuple[float, float]] | None = None,
        ends_only: bool = False,
        beside: Callable[["Robot", BehaviourPacket], None] | None = None,
    ) -> None:
        """
        :param disobedient: robots that do not wait.
        :param ends_only: no robot reports that a packet has begun.
        :param beside: called when a robot begins a packet.
        :param peers: the robots speak with each other.
        :param is_cut: there is no radio to the service from when all robots have their scripts until all have ended
            them, or can get no further.
        :param paces: by robot, the least and the greatest share of its packets' expected durations that they take.
        """
        self._services = services
        self._clock = clock
        self._mission_id = mission_id
        self._random = random.Random(seed)
        self._peer_random = random.Random(-seed - 1) if peers else None
        self._is_cut = is_cut
        self._cut_s: float | None = None
        self._paces = paces or {}
        self._disobedient = disobedient
        self._ends_only = ends_only
        self._beside = beside
        self._queue: list[tuple[float, int, Callable[[], None]]] = []
        self._numbers = count()
        self._began_s = clock.now_s()
        self._receipted: set[str] = set()
        self._true: set[SymbolicFact] = set()
        self.robots: dict[str, Robot] = {}
        self._has_ended = False
        self.states: list[str] = []
        """The states of the mission, one after the other."""
        self.reasons: list[str] = []

    def run(self) -> str:
        """Carry the mission out to its end; its last state."""
        self._look()
        while self._queue and not self._has_ended:
            at_s, _, act = heapq.heappop(self._queue)
            self._clock.advance(max(0.0, at_s - self._clock.now_s()))
            if self._clock.now_s() - self._began_s > GIVEN_UP_S:
                break
            act()
        return self._services.mission(self._mission_id).state

    def after(self, delay_s: float, act: Callable[[], None]) -> None:
        """Have something happen beside the mission."""
        self._after(delay_s, act)

    def go_on(self, time_s: float) -> None:
        """Let the robots' last reports arrive, once the mission has ended."""
        end_s = self._clock.now_s() + time_s
        while self._queue and self._queue[0][0] <= end_s:
            at_s, _, act = heapq.heappop(self._queue)
            self._clock.advance(max(0.0, at_s - self._clock.now_s()))
            act()

    def _after(self, delay_s: float, act: Callable[[], None]) -> None:
        heapq.heappush(self._queue, (self._clock.now_s() + delay_s, next(self._numbers), act))

    def _radio(self, act: Callable[[], None]) -> None:
        if not self._has_contact():
            return
        if self._random.random() >= LOST:
            self._after(self._random.uniform(0.05, LONGEST_DELAY_S), act)

    def _has_contact(self) -> bool:
        robots = self.robots.values()
        if not self._is_cut or not robots or any(one.script is None for one in robots):
            return True
        now_s = self._clock.now_s()
        self._cut_s = now_s if self._cut_s is None else self._cut_s
        is_over = all(one.state in (ScriptState.FINISHED, ScriptState.CANCELLED) for one in robots)
        return is_over or now_s - self._cut_s > LONGEST_CUT_S

    # What robots say to each other

    def _talk(self, robot: Robot, arrived: Sequence[Message] = ()) -> None:
        assert robot.social is not None
        robot.social.step(arrived, Speaking(self, robot))

    def _keep_talking(self, robot: Robot) -> None:
        self._talk(robot)
        self._after(1.0, lambda: self._keep_talking(robot))

    def pass_on(self, message: Message) -> None:
        """Carry what one robot says to another."""
        draw = self._peer_random
        assert draw is not None
        other = self.robots[message.receiver]
        for _ in range(2 if draw.random() < LOST else 1):
            if draw.random() >= LOST:
                self._after(draw.uniform(0.05, LONGEST_DELAY_S), lambda: self._talk(other, [message]))

    def clear_by(self, robot: Robot, script_id: str, action: str, speaker: str) -> Clearing:
        if robot.script is None or robot.script.id != script_id:
            return Clearing.UNKNOWN_SCRIPT
        named = {one: names for packet in robot.script.packets for one, names in packet.told_by.items()}
        if speaker not in named.get(action, ()):
            return Clearing.NOT_NAMED
        said = robot.said_by.setdefault(action, set())
        said.add(speaker)
        if said >= set(named[action]):
            robot.cleared.add(action)
            self._begin_if_it_may(robot)
        return Clearing.NOTED

    # The service

    def _look(self) -> None:
        """The service reviews the mission and sends what its robots have not answered."""
        for robot in self.robots.values():
            self._show(robot)
        self._review()
        if not self._has_ended:
            for script in self._services.scripts(self._mission_id):
                for send in self._due(script):
                    self._radio(send)
            self._after(LOOK_S, self._look)

    def _review(self) -> None:
        self._services.life.monitor(self._mission_id)
        mission = self._services.mission(self._mission_id)
        if mission.state == "recovering":
            self._services.repair(self._mission_id, None)
        self._has_ended = mission.ended_at_s is not None
        if [mission.state] != self.states[-1:]:
            self.states.append(mission.state)
        if mission.reason and [mission.reason] != self.reasons[-1:]:
            self.reasons.append(mission.reason)

    def _due(self, script: ScriptRow) -> Iterator[Callable[[], None]]:
        robot = self.robots.setdefault(
            script.robot, Robot(name=script.robot, obeys=script.robot not in self._disobedient)
        )
        if self._peer_random is not None and robot.social is None:
            robot.social = SocialLevel(robot.name, self._clock)
            self._keep_talking(robot)
        agreed = Acknowledgement(script_id=script.id)
        if script.delivery == "pending":
            yield lambda: self._take(robot, BehaviourScript.model_validate(script.body))
        if script.clearance is not None:
            name = f"{script.id}:{script.clearance}"
            yield lambda: self._clear(robot, set(script.cleared), agreed, name)
        if script.question is not None:
            question = script.question
            yield lambda: self._answer(robot, script.id, question)
        if (order := unanswered_order(script)) is not None:
            name = f"{script.id}:{order_label(order)}"
            yield lambda: self._cancel(robot, agreed, name)

    def hear(self, robot: str, body: Body, in_reply_to: str | None = None) -> Reception:
        """A message of a robot arrives at once."""
        message = self._message(Robot(name=robot), body, in_reply_to)
        return self._services.reports.record(message, WORLD)

    def _receive(self, message: Message) -> None:
        reception = self._services.reports.record(message, WORLD)
        if reception is not Reception.HELD_BACK:
            self._radio(lambda: self._receipted.add(message.id))
        if reception is Reception.HELD_BACK or isinstance(message.body, ScriptReport):
            self._review()

    # The robots

    def _take(self, robot: Robot, script: BehaviourScript) -> None:
        if robot.script is None or robot.script.id != script.id:
            robot.script = script
            self._begin_if_it_may(robot)
        self._say(robot, Acknowledgement(script_id=script.id), f"{script.id}:request")

    def _clear(self, robot: Robot, ended: set[str], answer: Body, name: str) -> None:
        robot.cleared |= ended
        self._say(robot, answer, name)
        self._begin_if_it_may(robot)

    def _cancel(self, robot: Robot, answer: Body, name: str) -> None:
        self._say(robot, answer, name)
        if robot.state in (ScriptState.ACCEPTED, ScriptState.RUNNING) and robot.script is not None:
            robot.state = ScriptState.CANCELLED
            at_s = self._clock.now_s()
            self._tell(robot, ScriptReport(script_id=robot.script.id, state=ScriptState.CANCELLED, at_s=at_s))

    def _answer(self, robot: Robot, script_id: str, question: str) -> None:
        following = robot.next
        status = StatusReport(
            script_id=script_id,
            state=robot.state,
            at_s=self._clock.now_s(),
            packet_id=following.id if following else None,
            packet_state=PacketState.RUNNING if robot.runs else PacketState.INITIALIZING,
        )
        self._say(robot, status, question)

    def _begin_if_it_may(self, robot: Robot) -> None:
        packet = robot.next
        if packet is None or robot.runs:
            return
        if robot.obeys and not (set(packet.awaits) <= self._true and set(packet.after) <= robot.cleared):
            return
        robot.runs = True
        robot.state = ScriptState.RUNNING
        robot.began_s[packet.id] = self._clock.now_s()
        if self._beside is not None:
            self._beside(robot, packet)
        if not self._ends_only:
            self._report(robot, packet, PacketState.RUNNING)
        self._show(robot)
        low, high = self._paces.get(robot.name, (0.6, 1.8))
        self._after(
            packet.expected_duration_s * self._random.uniform(low, high), lambda: self._end(robot, packet)
        )

    def _end(self, robot: Robot, packet: BehaviourPacket) -> None:
        robot.runs = False
        if robot.state is not ScriptState.RUNNING or robot.script is None:
            return
        robot.ended_s[packet.id] = self._clock.now_s()
        robot.done += 1
        self._true |= set(packet.achieves)
        robot.holding = {"DOCK": packet.arguments.get("object"), "RELEASE2": None}.get(
            packet.tag, robot.holding
        )
        robot.place = packet.arguments.get("ref2", packet.arguments.get("ref1", robot.place))
        self._show(robot)
        self._report(robot, packet, PacketState.FINISHED)
        if robot.social is not None:
            robot.social.packet_ended(packet)
        if robot.done == len(robot.script.packets):
            robot.state = ScriptState.FINISHED
            at_s = self._clock.now_s()
            self._tell(robot, ScriptReport(script_id=robot.script.id, state=ScriptState.FINISHED, at_s=at_s))
        for one in self.robots.values():
            self._begin_if_it_may(one)

    def _show(self, robot: Robot) -> None:
        """The robot's telemetry, which arrives at once, before its reports."""
        if robot.place:
            self.show(robot.name, robot.place, holding=robot.holding)

    def show(self, robot: str, place: str, *, holding: str | None = None) -> None:
        """Telemetry of a robot that stands at a place."""
        x_m, y_m = self._services.store.world.location(place).at
        told = Telemetry(at_s=self._clock.now_s(), x_m=x_m, y_m=y_m, heading_rad=0.0, holding=holding)
        self._services.board.heard(robot, told)

    def _report(self, robot: Robot, packet: BehaviourPacket, state: PacketState) -> None:
        assert robot.script is not None
        self._tell(
            robot,
            PacketReport(
                script_id=robot.script.id,
                packet_id=packet.id,
                state=state,
                at_s=self._clock.now_s(),
                cleared_by=_cleared_by(robot, packet) if state is PacketState.RUNNING else {},
            ),
        )

    def tell(self, robot: Robot, body: Body) -> None:
        self._tell(robot, body)

    def _tell(self, robot: Robot, body: Body) -> None:
        """A report, which is sent again until there is a receipt."""
        message = self._message(robot, body, None)

        def send() -> None:
            if message.id not in self._receipted:
                self._radio(lambda: self._receive(message))
                self._after(AGAIN_S, send)

        send()

    def _say(self, robot: Robot, body: Body, in_reply_to: str) -> None:
        """An answer: sent once, for the question is repeated."""
        message = self._message(robot, body, in_reply_to)
        self._radio(lambda: self._receive(message))

    def _message(self, robot: Robot, body: Body, in_reply_to: str | None) -> Message:
        return Message(
            performative=Performative.INFORM,
            sender=robot.name,
            receiver="service",
            sent_at_s=self._clock.now_s(),
            in_reply_to=in_reply_to,
            body=body,
        )


def _cleared_by(robot: Robot, packet: BehaviourPacket) -> dict[str, tuple[str, ...]]:
    return {
        action: tuple(sorted(robot.said_by[action]))
        for action, named in packet.told_by.items()
        if named and robot.said_by.get(action, set()) >= set(named)
    }


@dataclass(frozen=True, slots=True)
class Speaking:
    """A robot of the fleet as its social level finds it. Implements `robots.executive.society.Situated`."""

    fleet: RadioedFleet
    robot: Robot

    def clear_by(self, script_id: str, action: str, robot: str) -> Clearing:
        return self.fleet.clear_by(self.robot, script_id, action, robot)

    def send(self, message: Message) -> None:
        self.fleet.pass_on(message)

    def tell_service(self, report: SpeechReport) -> None:
        self.fleet.tell(self.robot, report)

    @property
    def delegated(self) -> None:
        """It puts no leg to others."""

    def offer(self, leg: BehaviourScript, *, promised_s: float) -> Offer | Declined:
        return Declined(reason=Declining.FAULT, words=f"{self.robot.name} has no body for {leg.id}")

    def state_of(self, script_id: str) -> ScriptState | None:
        return None
