"""Robots that speak with each other in stepped time, over a radio that loses, delays, reorders and repeats."""

import heapq
import random
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import count

from robots.clock import ManualClock
from robots.contract.memory import SocialMemory
from robots.executive.delegation import DelegatedLeg
from robots.executive.executive import Executive
from robots.executive.leg_cost import offer
from robots.executive.memory import ExecutiveMemory
from robots.executive.offer import Declined, Offer
from robots.executive.society import Clearing
from robots.perception.health import Defect
from robots.perception.percepts import Percepts
from robots.physical.body import Pose
from robots.physical.profile import RobotProfile
from robots.repertoire import load_repertoire
from robots.social import SocialLevel
from robots.wire import BehaviourPacket, BehaviourScript, DelegationReport, Message, ScriptState, SpeechReport
from tests.robots.stories import room

STEP_S = 0.5


@dataclass(kw_only=True)
class Air:
    """Carries messages between the robots, each with its own fate."""

    clock: ManualClock = field(default_factory=ManualClock)
    seed: int = 0
    loss: float = 0.0
    longest_s: float = 0.0
    repeats: float = 0.0
    talkers: "dict[str, Talker]" = field(default_factory=dict)
    sent: list[Message] = field(default_factory=list)
    cut: set[str] = field(default_factory=set)
    """Robots that neither send nor hear now."""

    def __post_init__(self) -> None:
        self._random = random.Random(self.seed)
        self._under_way: list[tuple[float, int, Message]] = []
        self._numbers = count()

    def add(self, name: str) -> "Talker":
        self.talkers[name] = Talker(self, name)
        return self.talkers[name]

    def send(self, message: Message) -> None:
        self.sent.append(message)
        for _ in range(2 if self._random.random() < self.repeats else 1):
            delay_s = self._random.uniform(0.0, self.longest_s)
            if self._random.random() >= self.loss and message.sender not in self.cut:
                wire = message.model_dump_json()
                arrives_s = self.clock.now_s() + delay_s
                heapq.heappush(
                    self._under_way, (arrives_s, next(self._numbers), Message.model_validate_json(wire))
                )

    def step(self) -> None:
        arrived: dict[str, list[Message]] = {name: [] for name in self.talkers}
        while self._under_way and self._under_way[0][0] <= self.clock.now_s():
            message = heapq.heappop(self._under_way)[2]
            if message.receiver in arrived and message.receiver not in self.cut:
                arrived[message.receiver].append(message)
        for name, talker in self.talkers.items():
            talker.step(arrived[name])
        self.clock.advance(STEP_S)

    def run_for(self, time_s: float) -> None:
        for _ in range(round(time_s / STEP_S)):
            self.step()


class Talker:
    """A robot's executive and social level, without a body. Implements `robots.executive.society.Situated`."""

    def __init__(self, air: Air, name: str) -> None:
        self.air = air
        self.name = name
        self.reports: list[SpeechReport] = []
        self.pose = Pose(x_m=0, y_m=0, heading_rad=0)
        self.battery = 1.0
        self.degraded: tuple[Defect, ...] = ()
        self.holding: str | None = None
        self.fault = ""
        self.driver: str | None = None
        self._profile = RobotProfile(
            name=name, start=Pose(x_m=0, y_m=0, heading_rad=0), beacons=room().beacons
        )
        self._make()

    def _make(self) -> None:
        self.executive = Executive(self._profile, load_repertoire())
        self.social = SocialLevel(self.name, self.air.clock, abilities=("DOCK", "NAVIGATE"))

    def accept(self, script: BehaviourScript) -> None:
        assert self.executive.accept(script) is None

    def restart(self) -> None:
        """The power fails: what is in flash memory is all that is left."""
        executive = self.executive.memory().model_dump_json()
        social = self.social.memory().model_dump_json()
        self._make()
        self.executive.recall(ExecutiveMemory.model_validate_json(executive), self.air.clock.now_s())
        self.social.recall(SocialMemory.model_validate_json(social))

    def hand_over(self) -> None:
        """Another program goes on with its mind."""
        executive = self.executive.hand_over().model_dump_json()
        social = self.social.hand_over().model_dump_json()
        self._make()
        self.executive.recall(ExecutiveMemory.model_validate_json(executive), self.air.clock.now_s())
        self.social.recall(SocialMemory.model_validate_json(social))

    def step(self, arrived: Sequence[Message]) -> None:
        self.social.step(arrived, self)

    def uncleared(self, packet: str) -> frozenset[str]:
        """The actions that a packet still waits for."""
        script = self.executive.memory().script
        assert script is not None
        packets = zip(script.script.packets, script.packets, strict=True)
        return next(memory.uncleared for one, memory in packets if one.id == packet)

    def clear_by(self, script_id: str, action: str, robot: str) -> Clearing:
        return self.executive.clear_by(script_id, action, robot)

    def offer(self, leg: BehaviourScript, *, promised_s: float) -> Offer | Declined:
        percepts = Percepts(
            profile=self._profile, time_s=self.air.clock.now_s(), pose=self.pose, odometry=self.pose
        )
        percepts.battery = self.battery
        percepts.degraded = self.degraded
        percepts.last_held = self.holding
        return offer(
            leg,
            profile=self._profile,
            executive=self.executive,
            percepts=percepts,
            fault=self.fault,
            driver=self.driver,
            promised_s=promised_s,
        )

    def state_of(self, script_id: str) -> ScriptState | None:
        return self.executive.state_of(script_id)

    def perform(self, script: BehaviourScript) -> str | None:
        return self.executive.accept(script)

    def halt(self, prefix: str) -> str | None:
        return f"{self.name} stands"

    @property
    def delegated(self) -> DelegatedLeg | None:
        return self.executive.delegated

    def make_way(self, own: BehaviourScript) -> str | None:
        return self.executive.make_way(own)

    def end_delegated(self, robot: str) -> None:
        self.executive.end_delegated(robot, None, self.air.clock.now_s())

    def take_back(self, reason: str) -> None:
        self.executive.take_back(reason, None, self.air.clock.now_s())

    def packets_ended(self, script_id: str) -> int | None:
        return self.executive.packets_ended(script_id)

    def moves_jaws(self, packet: BehaviourPacket) -> bool:
        return self.executive.moves_jaws(packet)

    @property
    def service_heard_s(self) -> float:
        return float("-inf")

    @property
    def service_answers_s(self) -> float:
        return 2.0

    def withdraw(self, script_id: str) -> None:
        self.executive.withdraw_own(script_id, None, self.air.clock.now_s())

    def why_ended(self, script_id: str) -> str:
        return self.executive.why_ended(script_id)

    @property
    def percepts(self) -> Percepts | None:
        return None

    @property
    def activity(self) -> tuple[str, ...]:
        return ()

    @property
    def beliefs(self) -> tuple[str, ...]:
        return ()

    def send(self, message: Message) -> None:
        self.air.send(message)

    def tell_service(self, report: SpeechReport | DelegationReport) -> None:
        if isinstance(report, SpeechReport):
            self.reports.append(report)
