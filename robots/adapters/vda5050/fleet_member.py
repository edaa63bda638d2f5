"""One vehicle as a robot of the world: its driver, and, once it is known well enough, the robot and its link."""

import logging
from collections.abc import Callable
from pathlib import Path

from robots.adapters.contract_robot import ContractRobot
from robots.adapters.vda5050.factsheets import packet_forms, repertoire, robot_factsheet
from robots.adapters.vda5050.messages import Headed, VehicleConnection, VehicleFactsheet
from robots.adapters.vda5050.settings import Settings
from robots.adapters.vda5050.topics import Topic, VehicleId
from robots.adapters.vda5050.vehicle_driver import AWAY, VehicleDriver
from robots.clock import Clock
from robots.contract.memory_file import MemoryFile, counter_file
from robots.errors import RobotError
from robots.link.mqtt import Broker, BrokerError, ConnectionState, RobotLink
from robots.wire import Factsheet

SHEET_S = 10.0
"""A vehicle that does not tell its factsheet within this time is taken as its settings say (wall clock)."""
SHOWN = {
    VehicleConnection.ONLINE: ConnectionState.ONLINE,
    VehicleConnection.HIBERNATING: ConnectionState.HIBERNATING,
    VehicleConnection.OFFLINE: ConnectionState.OFFLINE,
    VehicleConnection.CONNECTION_BROKEN: ConnectionState.CONNECTION_BROKEN,
}

logger = logging.getLogger(__name__)


class FleetMember:
    """Call `heard` with the vehicle's messages and `tick` at 10 Hz, from one thread."""

    def __init__(
        self,
        name: str,
        vehicle: VehicleId,
        settings: Settings,
        clock: Clock,
        send: Callable[[Topic, Headed], None],
        *,
        world: str,
        broker: Callable[[], Broker],
        key: Callable[[], str | None] = lambda: None,
        folder: Path,
    ) -> None:
        """
        :param clock: the wall clock.
        :param send: to the vehicle.
        :param broker: Macta's, for this robot; a `RobotError` is logged, and it is asked for again.
        :param key: with which this robot signs, and the service its orders to it; asked for after `broker`.
        :param folder: where the robot's memory is kept.
        """
        self.name = name
        self.vehicle = vehicle
        self._settings = settings
        self._clock = clock
        self._world = world
        self._broker = broker
        self._key = key
        memory = folder / f"{name}.json"
        self._store = MemoryFile(memory)
        self._counters = counter_file(memory)
        self._driver = VehicleDriver(name, vehicle, settings, clock, send)
        self._link: RobotLink | None = None
        self._robot: ContractRobot | None = None
        self._said: Factsheet | None = None
        self._read: VehicleFactsheet | None = None
        self._first_heard_s: float | None = None
        self._refused_s = float("-inf")
        self._refusal = ""

    @property
    def is_robot(self) -> bool:
        """True once the world is told of it."""
        return self._robot is not None

    def heard(self, message: Headed) -> None:
        """Take a message of the vehicle."""
        if self._first_heard_s is None:
            self._first_heard_s = self._clock.now_s()
        self._driver.heard(message)

    def tick(self) -> None:
        """Follow the vehicle and the service."""
        self._become_robot()
        self._driver.advance()
        if self._robot is None or self._link is None:
            self._driver.memory()
            self._driver.flush(is_saved=True)
            return
        if self._driver.connection is not None:
            self._link.show(self.name, SHOWN[self._driver.connection])
        if self._link.run is not None:
            self._robot.enter_run(self._link.run)
            if (faults := self._driver.changed_faults()) is not None:
                self._robot.report_faults(faults.model_copy(update={"at_s": self._link.clock.now_s()}))
            self._robot.tick()
            self._driver.flush(is_saved=not self._robot.complaint)
        else:
            self._driver.memory()
            self._driver.flush(is_saved=self._driver.is_at_rest)

    def close(self) -> None:
        if self._link is not None:
            self._link.close()

    def _become_robot(self) -> None:
        """Announce the vehicle as a robot once its state is known, and again if its factsheet has changed."""
        driver = self._driver
        first_s = self._first_heard_s
        if driver.pose is None or first_s is None or (driver.connection in AWAY and self._robot is None):
            return
        if driver.factsheet is None and self._clock.now_s() - first_s < SHEET_S:
            return
        if self._robot is not None and driver.factsheet is self._read:
            return
        if self._link is None and (link := self._own_link()) is not None:
            self._link = link
            self._link.start()
        if self._link is None:
            return
        self._read = driver.factsheet
        said = robot_factsheet(driver.factsheet, self.vehicle, driver.pose, self._settings)
        if self._said is not None and said.content == self._said.content:
            return
        is_new = self._said is None
        self._said = said
        if not is_new:
            self._driver.forget()
        self._robot = ContractRobot(
            self.name,
            driver=driver,
            packets=packet_forms(repertoire(driver.factsheet, self.vehicle, self._settings), self._settings),
            link=self._link,
            clock=self._link.clock,
            store=self._store,
            factsheet=said,
            objection=driver.objection,
        )
        logger.info("%s is the robot %s; it can %s", self.vehicle, self.name, ", ".join(said.repertoire))

    def _own_link(self) -> RobotLink | None:
        """With the credentials of this robot; None if they cannot be used, tried again every `SHEET_S`."""
        if self._clock.now_s() - self._refused_s < SHEET_S:
            return None
        try:
            broker = self._broker()
            key = self._key()
            return RobotLink(
                self._world,
                [self.name],
                broker,
                keys={} if key is None else {self.name: key},
                counters={self.name: self._counters},
            )
        except (RobotError, BrokerError, OSError, ValueError) as error:
            self._refused_s = self._clock.now_s()
            if str(error) != self._refusal:
                self._refusal = str(error)
                logger.warning("%s does not become the robot %s: %s", self.vehicle, self.name, error)
            return None
