"""Robots that carry scripts out in stepped time, behind a radio that delays, loses and repeats messages."""

import heapq
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import count

from app.agents.agent_models import Reception
from app.domain.lifecycles.script import order_label, unanswered_order
from app.store import ScriptRow
from robots.clock import ManualClock
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
    StatusReport,
    SymbolicFact,
)
from tests.app.missions.mission_services import WORLD, MissionServices

LONGEST_DELAY_S = 4.0
LOST = 0.1
"""The share of messages that do not arrive."""
AGAIN_S = 6.0
"""A message is sent again after this time until it is answered."""
LOOK_S = 4.0
"""Time between two reviews of the mission, if no report arrives."""
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
        paces: dict[str, tuple[float, float]] | None = None,
    ) -> None:
        """
        :param disobedient: robots that do not wait.
        :param paces: by robot, the least and the greatest share of its packets' expected durations that they take.
        """
        self._services = services
        self._clock = clock
        self._mission_id = mission_id
        self._random = random.Random(seed)
        self._paces = paces or {}
        self._disobedient = disobedient
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

    def _after(self, delay_s: float, act: Callable[[], None]) -> None:
        heapq.heappush(self._queue, (self._clock.now_s() + delay_s, next(self._numbers), act))

    def _radio(self, act: Callable[[], None]) -> None:
        if self._random.random() >= LOST:
            self._after(self._random.uniform(0.05, LONGEST_DELAY_S), act)

    # The service

    def _look(self) -> None:
        """The service reviews the mission and sends what its robots have not answered."""
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
        self._report(robot, packet, PacketState.RUNNING)
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
        self._report(robot, packet, PacketState.FINISHED)
        if robot.done == len(robot.script.packets):
            robot.state = ScriptState.FINISHED
            at_s = self._clock.now_s()
            self._tell(robot, ScriptReport(script_id=robot.script.id, state=ScriptState.FINISHED, at_s=at_s))
        for one in self.robots.values():
            self._begin_if_it_may(one)

    def _report(self, robot: Robot, packet: BehaviourPacket, state: PacketState) -> None:
        assert robot.script is not None
        self._tell(
            robot,
            PacketReport(
                script_id=robot.script.id, packet_id=packet.id, state=state, at_s=self._clock.now_s()
            ),
        )

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
