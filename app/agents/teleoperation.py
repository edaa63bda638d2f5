"""Operators who drive robots: who may, and the newest set-point of each, on its way to the robot.

Kept in memory, for a set-point is worth nothing a second later. The robot itself decides who drives it
(`robots.executive.teleoperation`) and reports when a drive began and ended, so the record holds whoever sent the
set-points; what is known here beforehand spares the operator a wait.
"""

import threading
import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from app.agents.world_service import RobotReport, WorldService
from app.domain.errors import Conflict
from app.domain.states import Connection
from robots.wire import VALID_AT_MOST_S, Message, SetPoint, SetPointRefusal
from robots.wire.operator import MAX_SPEED_M_S, MAX_TURN_RAD_S, RELEASE_FACTOR

VALID_S = 0.5
"""For so long a set-point holds: wall-clock seconds, for it is an operator's hand that the next comes from; of the
world's time at least as much."""


@dataclass(slots=True, kw_only=True)
class _Hold:
    """A driver's hold on a robot. `unsent` is what the robot is to be told next, `refusal` why it will not."""

    driver: str
    heard_at: float
    unsent: SetPoint | None = None
    refusal: str = ""

    def tell(
        self, *, valid_s: float, speed_m_s: float = 0.0, turn_rad_s: float = 0.0, ends: bool = False
    ) -> None:
        """Have the robot told this next. Numbers grow whichever process tells it, and over a restart."""
        self.unsent = SetPoint(
            driver=self.driver,
            number=time.time_ns() // 1000,
            speed_m_s=speed_m_s,
            turn_rad_s=turn_rad_s,
            valid_s=valid_s,
            ends=ends,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """What a driver is told with each set-point. `driving`: the robot says that it goes by him; `valid_s` of the
    world's time.
    """

    robot: str
    driver: str
    driving: bool
    last_heard_s: float | None
    valid_s: float
    most_m_s: float = MAX_SPEED_M_S
    most_rad_s: float = MAX_TURN_RAD_S


class Teleoperation:
    """Takes set-points from clients and hands them to the agent models. Thread-safe."""

    def __init__(
        self,
        worlds: WorldService,
        paces: Mapping[str, Callable[[], float | None]],
        *,
        wall: Callable[[], float] = time.monotonic,
    ) -> None:
        """:param paces: world seconds a wall-clock second, by world; None flat out."""
        self._worlds, self._paces, self._wall = worlds, paces, wall
        self._lock = threading.Lock()
        self._holds: dict[str, _Hold] = {}
        self._let_go: dict[str, str] = {}

    def drive(self, robot: str, driver: str, *, speed_m_s: float, turn_rad_s: float) -> Drive:
        """Have the robot go like this, for a moment.

        :raises Conflict: if it is given up, out of contact, on a mission or another's, or will not, saying why.
        """
        report = self._worlds.robot(robot)
        valid_s = self._valid_s(report.view.world)
        with self._lock:
            hold = self._hold(robot, driver)
            self._refuse(report, driver, hold)
            hold.heard_at = self._wall()
            hold.tell(speed_m_s=speed_m_s, turn_rad_s=turn_rad_s, valid_s=valid_s)
            self._holds[robot] = hold
        return self._drive(report, driver, valid_s)

    def let_go(self, robot: str, driver: str) -> Drive:
        """Drive it no more; of a robot that the driver does not hold nothing changes."""
        report = self._worlds.robot(robot)
        valid_s = self._valid_s(report.view.world)
        with self._lock:
            hold = self._holds.get(robot)
            here = hold is not None and hold.driver == driver
            if here or self._drives(report, driver):
                self._holds[robot] = hold = _Hold(driver=driver, heard_at=float("-inf"))
                hold.tell(valid_s=valid_s, ends=True)
                self._let_go[robot] = driver
        return self._drive(report, driver, valid_s)

    def to_send(self, robots: Collection[str]) -> list[tuple[str, SetPoint]]:
        """What these robots are to be told now, each the newest."""
        with self._lock:
            due = [(robot, hold) for robot, hold in self._holds.items() if robot in robots and hold.unsent]
            told = [(robot, hold.unsent) for robot, hold in due if hold.unsent is not None]
            for _, hold in due:
                hold.unsent = None
            return told

    def refused(self, message: Message) -> bool:
        """True if the message says that a robot will not be driven; its driver learns that with his next set-point."""
        body = message.body
        if not isinstance(body, SetPointRefusal):
            return False
        with self._lock:
            hold = self._holds.get(message.sender)
            if hold is not None and hold.driver == body.driver:
                hold.refusal = body.reason
        return True

    def _hold(self, robot: str, driver: str) -> _Hold:
        """The driver's hold on the robot, a new one if it is free.

        :raises Conflict: if another has it.
        """
        hold = self._holds.get(robot)
        if hold is not None and hold.driver == driver:
            return hold
        if hold is not None and self._wall() - hold.heard_at < RELEASE_FACTOR * VALID_S and not hold.refusal:
            raise Conflict(f"{hold.driver} drives {robot}", code="driven-by-another")
        return _Hold(driver=driver, heard_at=self._wall())

    def _refuse(self, report: RobotReport, driver: str, hold: _Hold) -> None:
        """:raises Conflict: if the robot is not to be driven now, saying why."""
        name, told = report.view.name, report.view.telemetry
        if report.lost is not None:
            raise Conflict(f"{name} was declared lost; declare it found first", code="robot-lost")
        if report.mission_id is not None:
            raise Conflict(f"{name} is on mission {report.mission_id}", code="on-mission")
        if report.connection is not Connection.ONLINE:
            raise Conflict(f"{name} is not in contact: {report.connection}", code="robot-out-of-contact")
        if told is None:
            raise Conflict(f"{name} has not yet said where it is", code="robot-out-of-contact")
        if hold.refusal:
            raise Conflict(hold.refusal, code="robot-refuses")
        # NOTE: a robot that was let go of here is not known to be free before its next telemetry.
        if told.driven_by not in (None, driver, self._let_go.get(name)):
            raise Conflict(f"{told.driven_by} drives {name}", code="driven-by-another")

    def _valid_s(self, world: str) -> float:
        pace = self._paces[world]()
        return VALID_AT_MOST_S if pace is None else min(VALID_S * max(1.0, pace), VALID_AT_MOST_S)

    @staticmethod
    def _drives(report: RobotReport, driver: str) -> bool:
        told = report.view.telemetry
        return told is not None and told.driven_by == driver

    def _drive(self, report: RobotReport, driver: str, valid_s: float) -> Drive:
        return Drive(
            robot=report.view.name,
            driver=driver,
            driving=self._drives(report, driver),
            last_heard_s=report.last_heard_s,
            valid_s=valid_s,
        )
