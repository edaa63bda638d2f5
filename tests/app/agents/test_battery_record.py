"""A robot's battery is recorded once it has moved by a step, or past a number that it is compared with."""

from typing import Any, cast

import pytest
from sqlalchemy import event
from sqlalchemy.orm import Session

from app.agents.battery_record import STEP, BatteryRecord
from app.agents.robot_board import RobotBoard
from app.core import Core
from app.missions.world_start import start_world_run
from app.store import Database, EventRow
from app.store.event_log import EventLog
from app.store.facts import FactStore
from robots.clock import ManualClock
from robots.wire import Telemetry
from tests.app.sample_store import Store

STORE = Store()
WORLD = "sample_store"
LOW, CHARGED_BELOW = 0.2, 0.3


class Recording:
    """The record of one world's batteries, and what robots tell."""

    def __init__(self, database: Database) -> None:
        self.database = database
        self.clock = ManualClock()
        self.board = RobotBoard.of({WORLD: STORE.world}, clocks={WORLD: self.clock}, low_battery=LOW)
        nothing = cast("Any", None)
        events = EventLog(database)
        self.core = Core(
            database=database,
            events=events,
            facts=FactStore(events, STORE.base),
            workflows=nothing,
            knowledge_base=STORE.base,
            plan_nets=nothing,
            reservations=nothing,
        )
        with database.write() as session:
            start_world_run(session, self.core, STORE.world, "run")
        self.releases = 0
        self.record = self.started()

    def started(self) -> BatteryRecord:
        """As in a process that starts."""
        return BatteryRecord(
            self.core,
            world=WORLD,
            board=self.board,
            clock=self.clock,
            low_battery=LOW,
            release=self._release,
            robots=lambda: STORE.world.robots_by_name,
            bounds=(LOW, CHARGED_BELOW),
        )

    def _release(self, session: Session, world: str) -> None:
        assert world == WORLD
        self.releases += 1

    def tell(self, *levels: float, robot: str = "yard_1") -> None:
        for level in levels:
            told = Telemetry(at_s=0, x_m=0, y_m=0, heading_rad=0, battery=level)
            self.board.heard(robot, told)
            self.record.record()

    @property
    def recorded(self) -> list[float]:
        """What yard_1's battery was recorded to be, in order, since it reports."""
        with self.database.read() as session:
            rows = session.query(EventRow).order_by(EventRow.seq).all()
        return [
            one["value"]
            for row in rows
            if row.type == "world.numbers_changed" and row.data["source"] == "report of yard_1"
            for one in row.data["changed"]
        ]


@pytest.fixture
def recording(database: Database) -> Recording:
    return Recording(database)


def test_it_is_recorded_step_by_step(recording: Recording) -> None:
    recording.tell(1.0, 1 - STEP / 2, 1 - STEP, 1 - STEP, 0.91, 0.5)
    assert recording.recorded == [1 - STEP, 0.5]


def test_less_than_a_step_is_recorded_if_it_passes_the_limit_of_recruiting(recording: Recording) -> None:
    recording.tell(0.21, 0.206, 0.198, 0.196, 0.201, 0.203)
    assert recording.recorded == [0.21, 0.198, 0.203]


def test_likewise_if_it_passes_another_level_that_batteries_are_compared_with(recording: Recording) -> None:
    recording.tell(0.31, 0.302, 0.297, 0.292)
    assert recording.recorded == [0.31, 0.297]


def test_a_reading_that_trembles_at_the_limit_is_recorded_once(recording: Recording) -> None:
    recording.tell(0.203, *[0.1995, 0.2005] * 20)
    assert recording.recorded == [0.203]


def test_nothing_is_written_or_read_while_no_robot_tells_of_another_battery(recording: Recording) -> None:
    recording.tell(0.7)
    statements: list[str] = []
    event.listen(
        recording.database.engine,
        "before_cursor_execute",
        lambda *said: statements.append(said[2]),
    )
    recording.record.record()
    assert statements == []
    recording.tell(0.69)
    assert [
        said for said in statements if not said.startswith(("SELECT", "BEGIN", "ROLLBACK", "PRAGMA"))
    ] == []


def test_goals_that_wait_are_planned_again_once_a_battery_is_no_longer_low(recording: Recording) -> None:
    recording.tell(0.1, 0.16, robot="yard_2")
    assert recording.releases == 0
    recording.tell(0.22, robot="yard_2")
    assert recording.releases == 1


def test_what_an_operator_has_stated_stands_until_the_robot_tells_again(recording: Recording) -> None:
    recording.tell(0.7)
    with recording.database.write() as session:
        numbers = recording.core.facts.numbers
        numbers.set(session, WORLD, {("battery", ("yard_1",)): 0.3}, source="operator x", at_s=1.0)
    recording.record.record()
    assert recording.recorded == [0.7]
    recording.tell(0.7)
    assert recording.recorded == [0.7, 0.7]


def test_a_process_that_starts_compares_with_what_is_recorded(recording: Recording) -> None:
    recording.tell(0.7)
    recording.record = recording.started()
    recording.tell(0.69)
    assert recording.recorded == [0.7]
