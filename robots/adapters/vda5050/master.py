"""The master control of all vehicles on a broker: finds them by their topics, and makes each a robot of the world."""

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

from robots.adapters.vda5050.codec import Encoder, Reader
from robots.adapters.vda5050.credentials import broker_of, key_of
from robots.adapters.vda5050.factsheets import robot_name
from robots.adapters.vda5050.fleet_member import FleetMember
from robots.adapters.vda5050.messages import Headed
from robots.adapters.vda5050.settings import Settings
from robots.adapters.vda5050.topics import OF_VEHICLES, Topic, VehicleId, subscription
from robots.clock import Clock
from robots.link.mqtt import Broker
from robots.link.mqtt.reactor import Reactor
from robots.link.mqtt.session import Publication, Session

TICK_S = 0.1
MAX_VEHICLES = 1000
MAX_WAITING = 10_000
"""Vehicles, and messages not handled yet; more are dropped."""

logger = logging.getLogger(__name__)


class WallClock:
    """Seconds since it was made."""

    def __init__(self, wall_s: Callable[[], float] = time.monotonic) -> None:
        self._wall_s = wall_s
        self._began_s = wall_s()

    def now_s(self) -> float:
        return self._wall_s() - self._began_s


class MasterControl:
    """`start`, then `tick` at 10 Hz from one thread, then `close`."""

    def __init__(
        self,
        settings: Settings,
        *,
        world: str,
        vehicles_at: Broker,
        macta_at: Broker,
        folder: Path,
        credentials: Path | None = None,
        clock: Clock | None = None,
    ) -> None:
        """
        :param vehicles_at: the vehicles' broker, `macta_at` the service's; often the same.
        :param folder: where robots' memories are kept.
        :param credentials: the folder with each robot's own at `macta_at`; None: all connect as `macta_at` says.
        """
        self._settings = settings
        self._world = world
        self._macta_at = macta_at
        self._folder = folder
        self._credentials = credentials
        self._clock = clock if clock is not None else WallClock()
        self._encoder = Encoder()
        self._members: dict[VehicleId, FleetMember] = {}
        self._passed_over: set[VehicleId] = set()
        self._arrived: deque[Publication] = deque(maxlen=MAX_WAITING)
        self._has_arrived = threading.Event()
        self._reader = Reader()
        self._session = Session(
            vehicles_at,
            _client_id(settings, world),
            subscriptions=[
                (subscription(settings.interface, version, topic), topic.qos)
                for version in settings.versions
                for topic in OF_VEHICLES
            ],
            on_arrival=self._arrive,
        )
        self._reactor = Reactor([self._session], broker=str(vehicles_at))

    @property
    def complaint(self) -> str:
        """Why the vehicles' broker is not connected, in words; empty if no failure is known."""
        return self._reactor.complaint

    @property
    def robots(self) -> dict[str, VehicleId]:
        """The vehicles that the world is told of, by robot name."""
        return {one.name: vehicle for vehicle, one in self._members.items() if one.is_robot}

    def start(self) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)
        self._reactor.start()

    def wait(self, timeout_s: float) -> None:
        """Until something has arrived."""
        self._has_arrived.wait(timeout_s)

    def tick(self) -> None:
        """Handle what has arrived, and follow every vehicle."""
        self._has_arrived.clear()
        while self._arrived:
            self._take(self._arrived.popleft())
        for member in self._members.values():
            member.tick()

    def run(self, ends: threading.Event) -> None:
        """Tick until `ends` is set."""
        while not ends.is_set():
            began_s = self._clock.now_s()
            self.tick()
            ends.wait(max(0.0, TICK_S - (self._clock.now_s() - began_s)))

    def close(self) -> None:
        for member in self._members.values():
            member.close()
        self._reactor.close()

    def _arrive(self, publication: Publication) -> None:
        self._arrived.append(publication)
        self._has_arrived.set()

    def _take(self, publication: Publication) -> None:
        if (read := self._reader.read(publication)) is None:
            return
        vehicle, message = read
        if (member := self._member(vehicle)) is not None:
            self._encoder.speak(vehicle, message.version)
            member.heard(message)

    def _member(self, vehicle: VehicleId) -> FleetMember | None:
        """The vehicle as a robot, known from now on; None if it is to be left alone."""
        known = self._members.get(vehicle)
        if known is not None or vehicle in self._passed_over:
            return known
        name = robot_name(vehicle, self._settings)
        if (why := self._why_pass_over(vehicle, name)) is not None:
            logger.warning("%s is left alone: %s", vehicle, why)
            if len(self._passed_over) < MAX_VEHICLES:
                self._passed_over.add(vehicle)
            return None
        member = self._members[vehicle] = FleetMember(
            name,
            vehicle,
            self._settings,
            self._clock,
            lambda topic, message: self._send(vehicle, topic, message),
            world=self._world,
            broker=lambda: self._broker_of(name),
            key=lambda: None if self._credentials is None else key_of(name, self._credentials),
            folder=self._folder,
        )
        return member

    def _broker_of(self, robot: str) -> Broker:
        if self._credentials is None:
            return self._macta_at
        return broker_of(robot, self._macta_at, self._credentials)

    def _why_pass_over(self, vehicle: VehicleId, name: str) -> str | None:
        if self._settings.only_listed and str(vehicle) not in self._settings.vehicles:
            return "the settings do not list it"
        if len(self._members) >= MAX_VEHICLES:
            return f"there are {MAX_VEHICLES} vehicles already"
        other = next((one for one in self._members.values() if one.name == name), None)
        if other is not None:
            return f"its name {name} is that of {other.vehicle}; give it another under `vehicles`"
        return None

    def _send(self, vehicle: VehicleId, topic: Topic, message: Headed) -> None:
        payload = self._encoder.encode(vehicle, topic, message)
        address = vehicle.topic(self._settings.interface, topic)
        self._session.publish(Publication(topic=address, payload=payload, qos=topic.qos, waits=True))


def _client_id(settings: Settings, world: str) -> str:
    """One for each set of vehicles: of two adapters that would drive the same ones the broker keeps the later."""
    listed = "-".join(sorted(settings.vehicles)) if settings.only_listed else "all"
    return f"macta-vda5050-{world}-{sha256(listed.encode()).hexdigest()[:12]}"
