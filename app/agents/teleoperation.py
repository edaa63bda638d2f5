"""Teleoperation: which operator drives a robot, and the newest set-point on its way to it.

Kept in memory: a set-point expires within seconds. The robot itself decides who drives it
(`robots.executive.teleoperation`) and reports when a drive began and ended; checks here only refuse sooner.
"""

import threading
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from app.agents.robot_directory import RobotDirectory, RobotReport
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.contact import Connection
from app.domain.errors import Conflict
from robots.wire import VALID_AT_MOST_S, Message, SetPoint, SetPointRefusal
from robots.wire.operator import MAX_SPEED_M_S, MAX_TURN_RAD_S, RELEASE_FACTOR

VALID_S = 0.5
"""How long a set-point is valid, in wall-clock seconds, because operators send them in real time; at least as long in
world seconds."""


@dataclass(slots=True, kw_only=True)
class _Hold:
    """A driver's control of a robot.

    :param heard_s: when the driver was last heard, monotonic; -inf once the driver has given it back.
    :param unsent: the set-point to be sent next.
    :param refusal: the reason that the robot gave for refusing the driver.
    """

    driver: str
    heard_s: float
    unsent: SetPoint | None = None
    refusal: str = ""

    @property
    def is_released(self) -> bool:
        return self.heard_s == float("-inf")

    def set(
        self,
        *,
        number: int,
        valid_s: float,
        speed_m_s: float = 0.0,
        turn_rad_s: float = 0.0,
        ends: bool = False,
    ) -> None:
        """Replace the unsent set-point."""
        self.unsent = SetPoint(
            driver=self.driver,
            number=number,
            speed_m_s=speed_m_s,
            turn_rad_s=turn_rad_s,
            valid_s=valid_s,
            ends=ends,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """The answer to a set-point.

    :param driving: the robot reports that it follows this driver.
    :param valid_s: how long the set-point is valid, in world seconds.
    """

    robot: str
    driver: str
    driving: bool
    last_heard_s: float | None
    valid_s: float
    most_m_s: float = MAX_SPEED_M_S
    most_rad_s: float = MAX_TURN_RAD_S


class Teleoperation:
    """Takes set-points from clients and passes them to the agent models. Thread-safe."""

    def __init__(
        self,
        robots: RobotDirectory,
        paces: Mapping[str, Callable[[], float | None]],
        *,
        wall: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """:param paces: world seconds per wall-clock second, by world; None: as fast as possible."""
        self._robots = robots
        self._paces = paces
        self._wall = wall
        self._lock = threading.Lock()
        self._holds: dict[str, _Hold] = {}
        self._released: dict[str, str] = {}
        self._number = 0

    def drive(self, robot: str, driver: str, *, speed_m_s: float, turn_rad_s: float) -> Drive:
        """Drive the robot at these speeds until the set-point expires.

        :raises Conflict: if it is lost, out of contact, on a mission, driven by another, released by this driver, or
            refuses.
        """
        report = self._robots.robot(robot)
        valid_s = self._valid_s(report.view.world)
        with self._lock:
            hold = self._hold(robot, driver)
            self._refuse(report, driver, hold)
            hold.heard_s = self._wall.monotonic_s()
            number = self._next_number()
            hold.set(number=number, speed_m_s=speed_m_s, turn_rad_s=turn_rad_s, valid_s=valid_s)
            self._holds[robot] = hold
        return self._drive(report, driver, valid_s)

    def release(self, robot: str, driver: str) -> Drive:
        """Stop driving the robot; without effect if another drives it."""
        report = self._robots.robot(robot)
        valid_s = self._valid_s(report.view.world)
        with self._lock:
            hold = self._holds.get(robot)
            here = hold is not None and hold.driver == driver
            if here or self._drives(report, driver):
                self._holds[robot] = hold = _Hold(driver=driver, heard_s=float("-inf"))
                hold.set(number=self._next_number(), valid_s=valid_s, ends=True)
                self._released[robot] = driver
        return self._drive(report, driver, valid_s)

    def to_send(self, robots: Collection[str]) -> list[tuple[str, SetPoint]]:
        """The newest set-point of each of these robots that is not sent yet."""
        with self._lock:
            unsent: list[tuple[str, SetPoint]] = []
            for robot, hold in self._holds.items():
                if robot in robots and hold.unsent is not None:
                    unsent.append((robot, hold.unsent))
                    hold.unsent = None
            return unsent

    def refused(self, message: Message) -> bool:
        """True if the message is a robot's refusal of a set-point; the driver's next set-point is refused with it."""
        body = message.body
        if not isinstance(body, SetPointRefusal):
            return False
        with self._lock:
            hold = self._holds.get(message.sender)
            if hold is not None and hold.driver == body.driver:
                hold.refusal = body.reason
        return True

    def _next_number(self) -> int:
        """A number greater than all before, also if the wall clock is set back.

        It starts at the wall clock's microseconds, so that it grows across restarts and processes, too.
        """
        self._number = max(self._number + 1, int(self._wall.epoch_s() * 1e6))
        return self._number

    def _hold(self, robot: str, driver: str) -> _Hold:
        """The driver's control of the robot, newly taken if it is free.

        :raises Conflict: if another has it, or the driver has released it.
        """
        hold = self._holds.get(robot)
        if hold is not None and hold.driver == driver:
            if hold.is_released:  # a set-point that the release has overtaken
                raise Conflict(
                    f"{driver} has released {robot}; take control with a new session", code="session-over"
                )
            return hold
        now_s = self._wall.monotonic_s()
        if hold is not None and now_s - hold.heard_s < RELEASE_FACTOR * VALID_S and not hold.refusal:
            raise Conflict(f"{hold.driver} drives {robot}", code="driven-by-another")
        return _Hold(driver=driver, heard_s=now_s)

    def _refuse(self, report: RobotReport, driver: str, hold: _Hold) -> None:
        """:raises Conflict: if the robot cannot be driven now; the message says why."""
        name = report.view.name
        telemetry = report.view.telemetry
        if report.lost is not None:
            raise Conflict(f"{name} was declared lost; declare it found first", code="robot-lost")
        if report.mission_id is not None:
            raise Conflict(f"{name} is on mission {report.mission_id}", code="on-mission")
        if report.connection is not Connection.ONLINE:
            raise Conflict(f"{name} is not in contact: {report.connection}", code="robot-out-of-contact")
        if telemetry is None:
            raise Conflict(f"{name} has sent no telemetry yet", code="robot-out-of-contact")
        if hold.refusal:
            raise Conflict(hold.refusal, code="robot-refuses")
        # NOTE: until its next telemetry, a robot that was released here still shows its former driver.
        if telemetry.driven_by not in (None, driver, self._released.get(name)):
            raise Conflict(f"{telemetry.driven_by} drives {name}", code="driven-by-another")

    def _valid_s(self, world: str) -> float:
        pace = self._paces[world]()
        return VALID_AT_MOST_S if pace is None else min(VALID_S * max(1.0, pace), VALID_AT_MOST_S)

    @staticmethod
    def _drives(report: RobotReport, driver: str) -> bool:
        telemetry = report.view.telemetry
        return telemetry is not None and telemetry.driven_by == driver

    def _drive(self, report: RobotReport, driver: str, valid_s: float) -> Drive:
        return Drive(
            robot=report.view.name,
            driver=driver,
            driving=self._drives(report, driver),
            last_heard_s=report.last_heard_s,
            valid_s=valid_s,
        )
