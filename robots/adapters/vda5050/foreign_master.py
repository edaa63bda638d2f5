"""Robots of a world as vehicles of another master control, which takes the place of Macta's service there."""

from collections import deque
from collections.abc import Sequence
from pathlib import Path

from robots.adapters.vda5050.codec import Encoder, Reader
from robots.adapters.vda5050.master import MAX_WAITING, WallClock
from robots.adapters.vda5050.messages import Connection, Headed, VehicleConnection
from robots.adapters.vda5050.robot_vehicle import RobotVehicle
from robots.adapters.vda5050.settings import Settings
from robots.adapters.vda5050.topics import OF_MASTERS, Topic, VehicleId
from robots.contract.memory_file import MemoryFile
from robots.link.mqtt import Broker, ConnectionState, ServiceLink
from robots.link.mqtt.reactor import Reactor
from robots.link.mqtt.session import Publication, Session
from robots.wire import Telemetry

MANUFACTURER = "macta"
SHOWN = {
    ConnectionState.ONLINE: VehicleConnection.ONLINE,
    ConnectionState.HIBERNATING: VehicleConnection.HIBERNATING,
    ConnectionState.OFFLINE: VehicleConnection.OFFLINE,
    ConnectionState.CONNECTION_BROKEN: VehicleConnection.CONNECTION_BROKEN,
}


class ForeignMaster:
    """`start`, then `tick` at 10 Hz from one thread, then `close`. A robot's name is its serial number."""

    def __init__(
        self,
        settings: Settings,
        robots: Sequence[str],
        *,
        world: str,
        vehicles_at: Broker,
        macta_at: Broker,
        folder: Path,
    ) -> None:
        """
        :param vehicles_at: the master control's broker, `macta_at` the robots'.
        :param folder: where the orders are kept over restarts.
        """
        self._settings = settings
        self._folder = folder
        self._encoder = Encoder()
        self._reader = Reader(self._drop)
        self._arrived: deque[Publication] = deque(maxlen=MAX_WAITING)
        self._heard: deque[tuple[str, Telemetry | ConnectionState]] = deque(maxlen=MAX_WAITING)
        self._link = ServiceLink(world, robots, macta_at)
        self._link.listen(self)
        clock = WallClock()
        major = max(settings.versions) if settings.states is None else int(settings.states[0])
        self._shown: dict[str, VehicleConnection] = {}
        self._ids = {
            name: VehicleId(manufacturer=MANUFACTURER, serial_number=name, major=major) for name in robots
        }
        if settings.states is not None:
            for vehicle in self._ids.values():
                self._encoder.speak(vehicle, settings.states)
        self._sessions = {name: self._session(name, vehicles_at) for name in robots}
        self._vehicles = {
            name: RobotVehicle(
                name,
                self._ids[name],
                settings,
                self._link,
                clock,
                lambda topic, message, name=name: self._publish(name, topic, message),  # type: ignore[misc]
                store=MemoryFile(folder / f"{name}.vehicle.json"),
            )
            for name in robots
        }
        self._reactor = Reactor(list(self._sessions.values()), broker=str(vehicles_at))

    @property
    def complaint(self) -> str:
        """Why the master control's broker is not connected, in words; empty if no failure is known."""
        return self._reactor.complaint

    def start(self) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)
        self._link.start()
        self._reactor.start()

    def heard(self, robot: str, telemetry: Telemetry) -> None:
        """Implements `robots.link.mqtt.service.Listener`."""
        self._heard.append((robot, telemetry))

    def connected(self, robot: str, state: ConnectionState, *, now: bool) -> None:
        """Implements `robots.link.mqtt.service.Listener`."""
        self._heard.append((robot, state))

    def tick(self) -> None:
        """Handle what has arrived from both sides, and follow every robot."""
        run = self._link.run
        if run is not None and run != self._link.taken_up:
            self._link.take_up(run)
            for vehicle in self._vehicles.values():
                vehicle.enter_run(run)
        while self._heard:
            robot, told = self._heard.popleft()
            if robot in self._vehicles and isinstance(told, Telemetry):
                self._vehicles[robot].told(told)
            elif robot in self._vehicles and isinstance(told, ConnectionState):
                self._show(robot, SHOWN[told])
        for message in self._link.receive():
            if message.sender in self._vehicles:
                self._vehicles[message.sender].receive(message)
        while self._arrived:
            self._take(self._arrived.popleft())
        for vehicle in self._vehicles.values():
            vehicle.tick()

    def close(self) -> None:
        for name in self._vehicles:
            self._show(name, VehicleConnection.OFFLINE)
        self._reactor.close()
        self._link.close()

    def _session(self, name: str, broker: Broker) -> Session:
        vehicle = self._ids[name]
        interface = self._settings.interface
        return Session(
            broker,
            f"macta-vehicle-{name}",
            subscriptions=[(vehicle.topic(interface, topic), topic.qos) for topic in OF_MASTERS],
            will=self._connection(name, VehicleConnection.CONNECTION_BROKEN),
            on_connected=lambda: self._connection(name, self._shown.get(name, VehicleConnection.OFFLINE)),
            on_arrival=self._arrived.append,
        )

    def _show(self, name: str, state: VehicleConnection) -> None:
        """Tell the master whether the robot is connected, if that has changed."""
        if self._shown.get(name) is not state:
            self._shown[name] = state
            self._sessions[name].publish(self._connection(name, state))

    def _connection(self, name: str, state: VehicleConnection) -> Publication:
        vehicle = self._ids[name]
        payload = self._encoder.encode(vehicle, Topic.CONNECTION, Connection(connection_state=state))
        address = vehicle.topic(self._settings.interface, Topic.CONNECTION)
        return Publication(topic=address, payload=payload, retain=True)

    def _take(self, publication: Publication) -> None:
        if (read := self._reader.read(publication)) is None:
            return
        vehicle, message = read
        if vehicle.serial_number in self._vehicles:
            self._vehicles[vehicle.serial_number].heard(message)

    def _drop(self, vehicle: VehicleId, topic: Topic) -> None:
        if vehicle.serial_number in self._vehicles:
            self._vehicles[vehicle.serial_number].heard_no_message(topic)

    def _publish(self, name: str, topic: Topic, message: Headed) -> None:
        vehicle = self._ids[name]
        payload = self._encoder.encode(vehicle, topic, message)
        address = vehicle.topic(self._settings.interface, topic)
        self._sessions[name].publish(
            Publication(topic=address, payload=payload, qos=topic.qos, waits=topic is not Topic.VISUALIZATION)
        )
