"""A stepped vehicle driven by a `VehicleDriver`, without service and link, for tests."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta

from benchmarks.vda5050.vehicle import SteppedVehicle
from robots.adapters.driver import Progress, ProgressState
from robots.adapters.vda5050.codec import Encoder, decode
from robots.adapters.vda5050.messages import Headed, InstantActions, Order
from robots.adapters.vda5050.settings import PlaceSettings, Settings
from robots.adapters.vda5050.topics import Topic, VehicleId
from robots.adapters.vda5050.vehicle_driver import VehicleDriver
from robots.clock import ManualClock
from robots.wire import BehaviourPacket, BehaviourScript

START = datetime(2026, 1, 1, tzinfo=UTC)
SETTINGS = Settings(
    places={
        "bay": PlaceSettings(x=2.0, y=0.0, heading_deg=0, dock=(2.5, 0.0, 0.0)),
        "door": PlaceSettings(x=2.0, y=3.0, heading_deg=90),
    }
)


def packet(packet_id: str, tag: str, **arguments: str) -> BehaviourPacket:
    return BehaviourPacket(
        id=packet_id,
        tag=tag,
        arguments=arguments,
        expected_start_s=0.0,
        expected_duration_s=10.0,
        timeout_s=100.0,
        wait_timeout_s=100.0,
    )


ERRAND = BehaviourScript(
    id="s1",
    mission_id="m1",
    robot="agv",
    packets=(
        packet("a", "NAVIGATE", ref2="bay"),
        packet("b", "DOCK", object="sample", ref1="bay"),
        packet("c", "TRANSPORT", object="sample", ref1="bay", ref2="door"),
        packet("d", "RELEASE2", object="sample", ref2="door"),
    ),
)


@dataclass
class Driven:
    """Messages pass both ways as bytes, of 3.0 or 2.1, at once and safely."""

    major: int = 3
    settings: Settings = SETTINGS
    sent: list[tuple[Topic, bytes]] = field(default_factory=list)
    """What the master has sent."""
    told: list[tuple[Topic, bytes]] = field(default_factory=list)
    """What the vehicle has sent."""
    is_cut: bool = False
    """Nothing passes."""

    def __post_init__(self) -> None:
        self.id = VehicleId(manufacturer="STEPPED", serial_number="AGV", major=self.major)
        self.clock = ManualClock()
        self._codecs = Encoder(self._now), Encoder(self._now)
        self.vehicle = SteppedVehicle(self._from_vehicle)
        self.restart()
        self.vehicle.connect()

    def restart(self) -> None:
        """The adapter's process ends and starts again, with what it has saved."""
        saved = self.driver.memory() if hasattr(self, "driver") else None
        self.driver = VehicleDriver("agv", self.id, self.settings, self.clock, self._from_master)
        if saved is not None:
            self.driver.recall(saved)

    def begin(self, script: BehaviourScript, number: int) -> str | None:
        """Begin a packet of a script, as the robot that keeps the contract does."""
        assert self.driver.objection(script) is None
        one = script.packets[number]
        return self.driver.start(one.model_copy(update={"id": f"{script.id}/{one.id}"}))

    def step(self, seconds: float) -> Progress:
        for _ in range(round(seconds * 10)):
            self.clock.advance(0.1)
            self.vehicle.step(0.1)
            self.driver.advance()
            self.driver.memory()
            self.driver.flush(is_saved=True)
        return self.driver.poll()

    def until_ended(self, limit_s: float = 60.0) -> Progress:
        """Step until the packet has ended."""
        for _ in range(round(limit_s)):
            if self.step(1.0).state is not ProgressState.RUNNING:
                return self.driver.poll()
        raise AssertionError(f"still running: {self.driver.waits_for}")

    def carry_out(self, script: BehaviourScript) -> Sequence[Progress]:
        progresses = []
        for number in range(len(script.packets)):
            assert self.begin(script, number) is None
            progresses.append(self.until_ended())
        return progresses

    @property
    def orders(self) -> Sequence[Order]:
        found = [decode(self.id, topic, payload) for topic, payload in self.sent if topic is Topic.ORDER]
        return [one for one in found if isinstance(one, Order)]

    @property
    def instant(self) -> Sequence[str]:
        """The types of the instant actions sent."""
        found = [
            decode(self.id, topic, payload) for topic, payload in self.sent if topic is Topic.INSTANT_ACTIONS
        ]
        return [
            action.action_type for one in found if isinstance(one, InstantActions) for action in one.actions
        ]

    def _now(self) -> datetime:
        return START + timedelta(seconds=self.clock.now_s())

    def _from_master(self, topic: Topic, message: Headed) -> None:
        payload = self._codecs[0].encode(self.id, topic, message)
        self.sent.append((topic, payload))
        if self.is_cut:
            return
        self.vehicle.receive(decode(self.id, topic, payload))

    def _from_vehicle(self, topic: Topic, message: Headed) -> None:
        payload = self._codecs[1].encode(self.id, topic, message)
        self.told.append((topic, payload))
        if self.is_cut:
            return
        self.driver.heard(decode(self.id, topic, payload))
