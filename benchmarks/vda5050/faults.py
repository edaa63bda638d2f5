"""One random run: two missions' scripts for one vehicle, with faults of the link to it and restarts of the adapter.

The service's part is played by a stub that sends what a robot has not confirmed again and keeps what it reports.
"""

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from random import Random

from benchmarks.vda5050.channel import Channel, Faults
from benchmarks.vda5050.vehicle import SteppedVehicle
from robots.adapters.contract_robot import ContractRobot
from robots.adapters.vda5050.codec import Encoder, decode
from robots.adapters.vda5050.factsheets import packet_forms
from robots.adapters.vda5050.messages import Connection, Headed, VehicleConnection
from robots.adapters.vda5050.settings import PlaceSettings, Settings
from robots.adapters.vda5050.topics import Topic, VehicleId
from robots.adapters.vda5050.vehicle_driver import VehicleDriver
from robots.clock import ManualClock
from robots.link import InMemoryLink, Link
from robots.wire import (
    Acknowledgement,
    BehaviourPacket,
    BehaviourScript,
    Clearance,
    Control,
    ControlVerb,
    Message,
    PacketReport,
    PacketState,
    Performative,
    Receipt,
    Refusal,
    ScriptReport,
    ScriptRequest,
    ScriptState,
)

ROBOT = "agv"
VEHICLE = VehicleId(manufacturer="STEPPED", serial_number="AGV")
TICK_S = 0.1
RESEND_S = 2.0
LIMIT_S = 1200.0
"""A run that has not ended by then has lost something."""
TAGS = ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2")
START = datetime(2026, 1, 1, tzinfo=UTC)
PLACES = {
    "bay_1": PlaceSettings(x=2.0, y=0.0, heading_deg=180, dock=(2.4, 0.0, 180)),
    "bay_2": PlaceSettings(x=2.0, y=3.0, heading_deg=90, dock=(2.0, 3.4, 90)),
    "home": PlaceSettings(x=0.0, y=1.0),
}


class Crash(Exception):
    """Raised where the adapter's process ends."""


@dataclass
class Disk:
    """The memory that outlives the process. `fuse`: it ends at that many further writes, before or after the write."""

    random: Random
    text: str | None = None
    fuse: int | None = None

    def load(self) -> str | None:
        return self.text

    def save(self, text: str) -> None:
        if self.fuse is not None:
            self.fuse -= 1
            if self.fuse <= 0:
                self.fuse = None
                if self.random.random() < 0.5:
                    self.text = text
                raise Crash
        self.text = text


@dataclass
class Stub:
    """The service: sends each script and order until the robot answers, and confirms reports."""

    link: Link
    scripts: Sequence[BehaviourScript]
    cancelled: Mapping[str, float]
    """When a script is cancelled, by its id."""
    paused: Mapping[str, tuple[float, float]]
    cleared_s: float
    """When the actions that packets wait for have ended."""
    ended: dict[str, ScriptState] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    finished: Counter[str] = field(default_factory=Counter)
    """Reports that a packet has finished, counted once by their ids."""

    def __post_init__(self) -> None:
        self._seen: set[str] = set()
        self._answered: set[str] = set()
        self._sent_s: dict[str, float] = {}

    def step(self, now_s: float) -> None:
        for message in self.link.receive():
            self._take(message, now_s)
        current = next((one for one in self.scripts if one.id not in self.ended), None)
        if current is None:
            return
        self._ask(f"script {current.id}", ScriptRequest(script=current), now_s)
        if now_s >= self.cleared_s:
            self._ask(f"clearance {current.id}", Clearance(script_id=current.id, ended=("other",)), now_s)
        begins_s, ends_s = self.paused.get(current.id, (float("inf"), float("inf")))
        if now_s >= begins_s:
            self._ask(f"pause {current.id}", _order(current, ControlVerb.PAUSE, 1), now_s)
        if now_s >= ends_s:
            self._ask(f"resume {current.id}", _order(current, ControlVerb.RESUME, 2), now_s)
        if now_s >= self.cancelled.get(current.id, float("inf")):
            self._ask(f"cancel {current.id}", _order(current, ControlVerb.CANCEL, 3), now_s)

    def _ask(self, key: str, body: ScriptRequest | Clearance | Control, now_s: float) -> None:
        if key in self._answered or now_s - self._sent_s.get(key, float("-inf")) < RESEND_S:
            return
        self._sent_s[key] = now_s
        cancels = isinstance(body, Control) and body.verb is ControlVerb.CANCEL
        performative = Performative.CANCEL if cancels else Performative.REQUEST
        self.link.send(
            Message(
                id=key,
                performative=performative,
                sender="service",
                receiver=ROBOT,
                sent_at_s=now_s,
                body=body,
            )
        )

    def _take(self, message: Message, now_s: float) -> None:
        match message.body:
            case Acknowledgement():
                self._answered.add(message.in_reply_to or "")
            case Refusal(script_id=script_id, reason=reason):
                # NOTE: a clearance may come before its script; it is sent again.
                if (message.in_reply_to or "").startswith("script"):
                    self.ended[script_id] = ScriptState.FAILED
                    self.reasons[script_id] = reason
                elif script_id in self.ended:
                    self._answered.add(message.in_reply_to or "")
            case PacketReport() | ScriptReport() as report:
                self._keep(message.id, report)
                receipt = Message(
                    performative=Performative.CONFIRM,
                    sender="service",
                    receiver=ROBOT,
                    sent_at_s=now_s,
                    in_reply_to=message.id,
                    body=Receipt(),
                )
                self.link.send(receipt)

    def _keep(self, message_id: str, report: PacketReport | ScriptReport) -> None:
        if message_id in self._seen:
            return
        self._seen.add(message_id)
        if isinstance(report, ScriptReport):
            self.ended[report.script_id] = report.state
            self.reasons[report.script_id] = report.detail
        elif report.state is PacketState.FINISHED:
            self.finished[f"{report.script_id}/{report.packet_id}"] += 1


def _order(script: BehaviourScript, verb: ControlVerb, number: int) -> Control:
    return Control(script_id=script.id, verb=verb, number=number)


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """What a run came to. `faults`: what must never be, in words; `failed`: scripts that ended with a reason."""

    seed: int
    faults: tuple[str, ...]
    failed: tuple[str, ...]
    restarts: int
    messages: int
    time_s: float
    history: tuple[str, ...]


class Run:
    """A run of one seed."""

    def __init__(self, seed: int, faults: Faults) -> None:
        self.seed = seed
        self.random = Random(seed)
        self.faults = faults
        self.clock = ManualClock()
        self.settings = Settings(places=PLACES, horizon=self.random.random() < 0.8)
        self.disk = Disk(self.random)
        self.restarts = 0
        self.to_vehicle = Channel(self.random, faults, self._at_vehicle)
        self.to_master = Channel(self.random, faults, self._at_master)
        self.vehicle = SteppedVehicle(self._from_vehicle, x=0.5, y=0.5)
        self._vehicle_codec = Encoder(self._now)
        self._cut_until_s = 0.0
        scripts = [self._script(number) for number in (1, 2)]
        service_end, self._robot_end = InMemoryLink.pair()
        self.stub = Stub(
            service_end,
            scripts,
            cancelled={"s1": self.random.uniform(5, 40)} if self.random.random() < 0.3 else {},
            paused=self._pauses(),
            cleared_s=self.random.uniform(0, 60),
        )
        self._boot()

    def _pauses(self) -> dict[str, tuple[float, float]]:
        begins_s = self.random.uniform(3, 40)
        pause = (begins_s, begins_s + self.random.uniform(2, 20))
        return {"s1": pause} if self.random.random() < 0.3 else {}

    def _script(self, number: int) -> BehaviourScript:
        source, target = ("bay_1", "bay_2") if number % 2 else ("bay_2", "bay_1")
        packets = [
            _packet("a", "NAVIGATE", ref2=source),
            _packet("b", "DOCK", object="sample", ref1=source),
            _packet("c", "TRANSPORT", object="sample", ref1=source, ref2=target),
            _packet("d", "RELEASE2", object="sample", ref2=target),
            _packet("e", "NAVIGATE", ref2="home"),
        ]
        waiting = self.random.randrange(len(packets))
        packets[waiting] = packets[waiting].model_copy(update={"after": ("other",)})
        return BehaviourScript(id=f"s{number}", mission_id=f"m{number}", robot=ROBOT, packets=tuple(packets))

    def __call__(self) -> Result:
        self.vehicle.connect()
        while len(self.stub.ended) < len(self.stub.scripts) and self.clock.now_s() < LIMIT_S:
            self._step()
        for _ in range(200):  # late copies still arrive
            self._step()
        return Result(
            seed=self.seed,
            faults=tuple(self.wrong()),
            failed=tuple(f"{one}: {why}" for one, why in self.stub.reasons.items() if self._has_failed(one)),
            restarts=self.restarts,
            messages=self.to_vehicle.sent + self.to_master.sent,
            time_s=self.clock.now_s(),
            history=tuple(self.vehicle.history),
        )

    def _has_failed(self, script_id: str) -> bool:
        return self.stub.ended[script_id] is ScriptState.FAILED

    def _step(self) -> None:
        self.clock.advance(TICK_S)
        now_s = self.clock.now_s()
        self._maybe_cut(now_s)
        if self.disk.fuse is None and self.random.random() < self.faults.restarts_per_s * TICK_S:
            self.disk.fuse = self.random.randrange(1, 4)
        self.stub.step(now_s)
        self.to_vehicle.step(TICK_S)
        self.vehicle.step(TICK_S)
        self.to_master.step(TICK_S)
        try:
            self.driver.advance()
            self.robot.tick()
            self.driver.flush(is_saved=not self.robot.complaint)
        except Crash:
            self.restarts += 1
            self._boot()

    def _maybe_cut(self, now_s: float) -> None:
        is_cut = now_s < self._cut_until_s
        if not is_cut and self.random.random() < self.faults.outages_per_s * TICK_S:
            self._cut_until_s = now_s + self.random.random() * self.faults.outage_s
            is_cut = True
        if is_cut is self.to_master.is_cut:
            return
        self.to_master.is_cut = self.to_vehicle.is_cut = is_cut
        state = VehicleConnection.CONNECTION_BROKEN if is_cut else VehicleConnection.ONLINE
        self.driver.heard(Connection(connection_state=state))

    def _boot(self) -> None:
        """Start the adapter's process, with what is on the disk."""
        self._codec = Encoder(self._now)
        self.driver = VehicleDriver(ROBOT, VEHICLE, self.settings, self.clock, self._from_master)
        self.robot = ContractRobot(
            ROBOT,
            driver=self.driver,
            packets=packet_forms(TAGS, self.settings),
            link=self._robot_end,
            clock=self.clock,
            store=self.disk,
            objection=self.driver.objection,
            run=None if self.disk.text is not None else "run",
        )

    def _now(self) -> datetime:
        return START + timedelta(seconds=self.clock.now_s())

    def _from_master(self, topic: Topic, message: Headed) -> None:
        self.to_vehicle.send(str(topic), self._codec.encode(VEHICLE, topic, message))

    def _from_vehicle(self, topic: Topic, message: Headed) -> None:
        self.to_master.send(str(topic), self._vehicle_codec.encode(VEHICLE, topic, message))

    def _at_vehicle(self, address: str, payload: bytes) -> None:
        self.vehicle.receive(decode(VEHICLE, Topic(address), payload))

    def _at_master(self, address: str, payload: bytes) -> None:
        topic = Topic(address)
        if topic is not Topic.CONNECTION:  # of which `_maybe_cut` tells
            self.driver.heard(decode(VEHICLE, topic, payload))

    def wrong(self) -> Iterator[str]:
        """What must never be."""
        done = Counter[str]()
        for action, times in self.vehicle.deeds.items():
            if "#" not in action:
                order, packet, _ = action.split(":")
                done[f"{order.split('.')[1]}/{packet}"] += times
        for packet, times in done.items():
            if times > 1:
                yield f"{packet} was done {times} times"
        for script in self.stub.scripts:
            yield from self._wrong_with(script, done)

    def _wrong_with(self, script: BehaviourScript, done: Mapping[str, int]) -> Iterator[str]:
        state = self.stub.ended.get(script.id)
        if state is None:
            with suppress(AttributeError):
                yield f"{script.id} has not ended: {self.driver.waits_for}; {json.dumps(self.driver.memory())[:300]}"
            return
        if state is ScriptState.CANCELLED and script.id not in self.stub.cancelled:
            yield f"{script.id} was cancelled, which nobody asked for"
        for packet in script.packets:
            key = f"{script.id}/{packet.id}"
            told = self.stub.finished[key]
            if told > 1:
                yield f"{key} was reported as finished {told} times"
            if state is ScriptState.FINISHED and not told:
                yield f"{key} was not reported as finished"
            if packet.tag in ("DOCK", "RELEASE2") and bool(told) is not bool(done.get(key, 0)):
                has_failed = state is not ScriptState.FINISHED
                if told or not has_failed:
                    yield f"{key} was {'reported' if told else 'done'} only"


def _packet(packet_id: str, tag: str, **arguments: str) -> BehaviourPacket:
    return BehaviourPacket(
        id=packet_id,
        tag=tag,
        arguments=arguments,
        expected_start_s=0.0,
        expected_duration_s=10.0,
        timeout_s=600.0,
        wait_timeout_s=600.0,
    )
