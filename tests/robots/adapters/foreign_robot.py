"""A robot that is not ours, its driver, the service's end of a link, and power that fails: for tests of adapters."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Any

from robots.adapters import ContractRobot, PacketForm, Progress, ProgressState
from robots.clock import ManualClock
from robots.link import InMemoryLink, Link
from robots.wire import (
    BehaviourPacket,
    BehaviourScript,
    Body,
    Clearance,
    Factsheet,
    FailureCategory,
    Message,
    PacketReport,
    PacketResult,
    PacketState,
    Performative,
    Receipt,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    SymbolicFact,
    Telemetry,
)

STEP_S = 0.25
FORMS: Mapping[str, PacketForm] = {
    "NAVIGATE": PacketForm(arguments=("ref2",), choices={"ref2": frozenset({"bay_1", "bay_2", "yard"})}),
    "DOCK": PacketForm(arguments=("object",)),
    "RELEASE2": PacketForm(),
}


class PowerFailure(BaseException):
    """Raised at the operation at which the adapter's process dies."""


@dataclass
class Power:
    """Fails at the operations of these numbers, counted from 1; what reaches a disk, a robot or a link is one."""

    fails_at: set[int] = field(default_factory=set)
    used: int = 0

    def use(self) -> None:
        self.used += 1
        if self.used in self.fails_at:
            raise PowerFailure


@dataclass
class Machine:
    """The robot itself: it works on while its adapter is dead, and notes what it was made to do."""

    work_s: float = 3.0
    log: list[str] = field(default_factory=list)
    """Each packet that it has begun, by id."""
    done: list[str] = field(default_factory=list)
    current: str | None = None
    left_s: float = 0.0
    paused: bool = False
    cancelled: set[str] = field(default_factory=set)
    failing: dict[str, str] = field(default_factory=dict)
    """Why packets fail, by id."""
    stops_in_s: float = 0.0
    stopping_s: float | None = None
    refuses: str | None = None

    def begin(self, packet_id: str) -> None:
        self.log.append(packet_id)
        self.current = packet_id
        self.left_s = self.work_s

    def step(self, step_s: float) -> None:
        if self.current is None:
            return
        if self.stopping_s is not None and self.left_s > 0:
            self.stopping_s -= step_s
            if self.stopping_s < 0:
                self.cancelled.add(self.current)
                self.current = None
                self.stopping_s = None
            return
        if not self.paused:
            self.left_s -= step_s
        if self.left_s <= 0:
            self.done.append(self.current)
            self.current = None


class Driver:
    """Drives the machine; it knows packets by their ids, so it begins none twice."""

    def __init__(self, machine: Machine, power: Power | None = None) -> None:
        self._machine = machine
        self._power = power or Power()
        self._id = ""
        self.calls: list[str] = []
        self.perceived: tuple[SymbolicFact, ...] | None = None
        self.results: tuple[PacketResult, ...] = ()
        self.events: tuple[str, ...] = ()
        self.x_m = 0.0

    def start(self, packet: BehaviourPacket) -> str | None:
        self.calls.append("start")
        self._power.use()
        if self._machine.refuses is not None:
            return self._machine.refuses
        self._id = packet.id
        if packet.id not in self._machine.log:
            self._machine.begin(packet.id)
        self._power.use()
        return None

    def poll(self) -> Progress:
        self._power.use()
        events, self.events = self.events, ()
        if self._id in self._machine.failing:
            return Progress(state=ProgressState.FAILED, detail=self._machine.failing[self._id])
        if self._id in self._machine.done:
            return Progress(state=ProgressState.FINISHED, perceived=self.perceived, results=self.results)
        if self._id in self._machine.cancelled:
            return Progress(state=ProgressState.FAILED, detail="was cancelled", perceived=self.perceived)
        return Progress(events=events, perceived=self.perceived)

    def pause(self) -> None:
        self.calls.append("pause")
        self._machine.paused = True

    def resume(self) -> None:
        self.calls.append("resume")
        self._machine.paused = False

    def cancel(self) -> None:
        self.calls.append("cancel")
        if self._machine.current is not None and self._machine.stopping_s is None:
            self._machine.stopping_s = self._machine.stops_in_s

    def telemetry(self) -> Telemetry | None:
        return Telemetry(at_s=0.0, x_m=self.x_m, y_m=0.0, heading_rad=0.0, battery=0.75)


class SensingRobot(Driver):
    """A driver whose robot senses some facts."""

    def __init__(self, machine: Machine, power: Power | None = None) -> None:
        super().__init__(machine, power)
        self.sensed: set[str] = set()

    @property
    def senses(self) -> frozenset[str]:
        return frozenset({"in"})

    def holds(self, fact: SymbolicFact) -> bool:
        return str(fact) in self.sensed


class Flash:
    """Persistent memory that a failing power leaves as it was, or as it was to be."""

    def __init__(self, power: Power | None = None) -> None:
        self.text: str | None = None
        self.full = False
        self._power = power or Power()

    def load(self) -> str | None:
        return self.text

    def save(self, text: str) -> None:
        if self.full:
            raise OSError("no space left on the device")
        self._power.use()
        self.text = text
        self._power.use()


class LossyLink:
    """A link that drops, repeats and delays messages in both directions, at random."""

    def __init__(self, link: Link, random: Random, power: Power, *, faults: float) -> None:
        self._link = link
        self._random = random
        self._power = power
        self._faults = faults
        self._delayed: list[Message] = []

    def send(self, message: Message) -> None:
        self._power.use()
        for one in self._disturbed([message]):
            self._link.send(one)

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        return self._disturbed(self._link.receive())

    def close(self) -> None: ...

    def _disturbed(self, messages: Sequence[Message]) -> list[Message]:
        passed = []
        for message in messages:
            if self._random.random() >= self._faults:
                passed.append(message)
            else:
                self._delayed += [message] * self._random.choice((0, 1, 2))
        late = [one for one in self._delayed if self._random.random() < 0.2]
        self._delayed = [one for one in self._delayed if one not in late]
        passed += late
        if self._random.random() < self._faults:
            self._random.shuffle(passed)
        return passed


class Service:
    """The service's end: it repeats requests until they are answered, and gives receipts."""

    def __init__(self, link: InMemoryLink, clock: ManualClock, *, receipts: bool = True) -> None:
        self._link = link
        self._clock = clock
        self.receipts = receipts
        self.heard: list[Message] = []
        self._open: dict[str, Message] = {}

    def send(
        self, body: Body, performative: Performative = Performative.REQUEST, *, repeat: bool = False
    ) -> Message:
        message = Message(
            performative=performative,
            sender="service",
            receiver="carl",
            sent_at_s=self._clock.now_s(),
            body=body,
        )
        if repeat:
            self._open[message.id] = message
        self._link.send(message)
        return message

    def step(self) -> None:
        """Read what has arrived; give receipts; send again what is not answered."""
        for message in self._link.receive():
            if message.in_reply_to is not None:
                self._open.pop(message.in_reply_to, None)
            if message.id not in {one.id for one in self.heard} or message.in_reply_to is not None:
                self.heard.append(message)
            if self.receipts and isinstance(message.body, PacketReport | ScriptReport | Factsheet):
                self._link.send(
                    Message(
                        performative=Performative.CONFIRM,
                        sender="service",
                        receiver="carl",
                        sent_at_s=self._clock.now_s(),
                        in_reply_to=message.id,
                        body=Receipt(),
                    )
                )
        for message in self._open.values():
            self._link.send(message)

    def answer(self, request: Message) -> Any:
        return next(message.body for message in self.heard if message.in_reply_to == request.id)

    @property
    def packets(self) -> list[tuple[str, PacketState]]:
        """The reports on packets, each once, in the order of arrival."""
        return [
            (one.body.packet_id, one.body.state) for one in self.heard if isinstance(one.body, PacketReport)
        ]

    @property
    def reports(self) -> list[PacketReport]:
        return [message.body for message in self.heard if isinstance(message.body, PacketReport)]

    @property
    def ends(self) -> list[ScriptReport]:
        return [message.body for message in self.heard if isinstance(message.body, ScriptReport)]

    @property
    def telemetry(self) -> list[Telemetry]:
        return [message.body for message in self.heard if isinstance(message.body, Telemetry)]


class Stage:
    """The robot "carl" with its adapter, the service, and time."""

    def __init__(
        self,
        *,
        driver: Callable[[Machine, Power], Driver] = Driver,
        seed: int = 0,
        faults: float = 0.0,
        fails_at: Sequence[int] = (),
        receipts: bool = True,
        factsheet: Factsheet | None = None,
        objection: Callable[[BehaviourScript], str | None] = lambda script: None,
    ) -> None:
        self.clock = ManualClock()
        self.machine = Machine()
        self.power = Power(set(fails_at))
        self.flash = Flash(self.power)
        self.run_name = "run-1"
        self._make_driver = driver
        self._random = Random(seed)
        self._faults = faults
        self.factsheet = factsheet
        self._objection = objection
        ours, self._theirs = InMemoryLink.pair()
        self.service = Service(ours, self.clock, receipts=receipts)
        self.restarts = 0
        self.restart()

    def restart(self) -> None:
        """The adapter's process starts; the link's buffers and the driver's knowledge are gone."""
        self.driver = self._make_driver(self.machine, self.power)
        link = LossyLink(self._theirs, self._random, self.power, faults=self._faults)
        self.robot = ContractRobot(
            "carl",
            driver=self.driver,
            packets=FORMS,
            link=link,
            clock=self.clock,
            store=self.flash,
            factsheet=self.factsheet,
            objection=self._objection,
            run=self.run_name,
        )

    def step(self) -> None:
        try:
            self.robot.tick()
        except PowerFailure:
            self.restarts += 1
            self.restart()
        self.machine.step(STEP_S)
        self.service.step()
        self.clock.advance(STEP_S)

    def run_for(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP_S)):
            self.step()

    def run_until(self, holds: Callable[[], bool], limit_s: float = 600.0) -> bool:
        for _ in range(round(limit_s / STEP_S)):
            if holds():
                return True
            self.step()
        return holds()

    def order(self, script: BehaviourScript) -> Message:
        return self.service.send(ScriptRequest(script=script), repeat=True)

    def clear(self, script: BehaviourScript, *ended: str) -> Message:
        return self.service.send(Clearance(script_id=script.id, ended=ended), repeat=True)


def fact(text: str) -> SymbolicFact:
    predicate, _, rest = text.partition("(")
    return SymbolicFact(predicate=predicate, args=tuple(rest.rstrip(")").split(", ")))


def packet(
    packet_id: str,
    tag: str,
    *,
    achieves: Sequence[str] = (),
    awaits: Sequence[str] = (),
    after: Sequence[str] = (),
    timeout_s: float = 60.0,
    wait_timeout_s: float = 120.0,
    **arguments: str,
) -> BehaviourPacket:
    return BehaviourPacket(
        id=packet_id,
        tag=tag,
        arguments=arguments,
        achieves=tuple(map(fact, achieves)),
        awaits=tuple(map(fact, awaits)),
        after=tuple(after),
        expected_start_s=0,
        expected_duration_s=3,
        timeout_s=timeout_s,
        wait_timeout_s=wait_timeout_s,
    )


def script(
    *packets: BehaviourPacket, name: str = "s1", mission: str = "m1", revision: int = 1, robot: str = "carl"
) -> BehaviourScript:
    return BehaviourScript(id=name, mission_id=mission, robot=robot, revision=revision, packets=packets)


def fetch(**slots: Any) -> BehaviourScript:
    """Three packets; the second waits for another robot's action a9."""
    return script(
        packet("a1", "NAVIGATE", ref2="bay_1", achieves=("near(carl, bay_1)",)),
        packet("a2", "DOCK", object="sample_1", after=("a9",), achieves=("in(sample_1, carl)",)),
        packet("a3", "RELEASE2", achieves=("in(sample_1, bay_1)",)),
        **slots,
    )


STATES = (PacketState.INITIALIZING, PacketState.RUNNING, PacketState.FINISHED)
ALL_DONE = [(one, state) for one in ("a1", "a2", "a3") for state in STATES]
CANCELLED = (ScriptState.CANCELLED, FailureCategory.CANCELLED)
