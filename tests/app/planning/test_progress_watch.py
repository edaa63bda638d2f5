"""What the watch of a goal's planning records and reads, and how often."""

from collections.abc import Iterator

import pytest

from app.domain.lifecycles.goal import GoalState
from app.planning.progress_watch import READ_S, RECORD_S, ProgressWatch
from app.store import Database, GoalRow
from app.store.migrate import migrate
from planner import Progress
from tests.app.planning.record import StoreRecord
from tests.app.stepped_clock import SteppedClock


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Iterator[StoreRecord]:
    database = Database(f"sqlite:///{tmp_path_factory.mktemp('record') / 'record.sqlite'}")
    migrate(database)
    record = StoreRecord(database, unavailable=lambda _: {})
    with database.write() as session:
        record.add_world(session)
    yield record
    database.close()


class Watched:
    """A goal in planning, its watch, and the clock."""

    def __init__(self, record: StoreRecord) -> None:
        self._record = record
        self.goal_id = record.add_goal(state=GoalState.PLANNING)
        self.clock = SteppedClock()
        self.is_wanted = True
        self.watch = ProgressWatch(
            record.database,
            record.events,
            self.goal_id,
            is_wanted=lambda _: self.is_wanted,
            clock=self.clock,
        )

    def tell(self, makespan_s: float, elapsed_s: float = 0.0) -> None:
        self.watch.progress(Progress(engine="fake", elapsed_s=elapsed_s, makespan_s=makespan_s))

    @property
    def makespan_s(self) -> float | None:
        """As recorded."""
        planning = self._record.goal(self.goal_id).planning
        return planning and planning["makespan_s"]

    @property
    def events(self) -> list[float]:
        """The makespans that clients were told."""
        events = self._record.events.since(0)
        return [event.data["makespan_s"] for event in events if event.subject == self.goal_id]

    @property
    def waits_for(self) -> list[str]:
        """What clients were told that it waits for."""
        events = self._record.events.since(0)
        return [event.data["waits_for"] for event in events if event.subject == self.goal_id]

    def request_stop(self) -> None:
        with self._record.database.write() as session:
            session.get_one(GoalRow, self.goal_id).stop_requested = True


@pytest.fixture
def watched(record: StoreRecord) -> Watched:
    return Watched(record)


def test_the_newest_progress_is_recorded_at_a_bounded_rate(watched: Watched) -> None:
    watched.tell(90.0)
    assert watched.makespan_s is None, "a plan that is found at once needs no progress"
    watched.clock.advance(RECORD_S)
    watched.tell(80.0)
    assert watched.makespan_s == 80.0
    watched.tell(70.0)
    watched.tell(60.0)
    assert watched.makespan_s == 80.0
    watched.clock.advance(RECORD_S)
    assert not watched.watch.should_stop()
    assert watched.makespan_s == 60.0
    assert watched.events == [80.0, 60.0]


def test_clients_are_notified_only_if_more_than_the_time_has_changed(watched: Watched) -> None:
    for elapsed_s in (1.0, 2.0):
        watched.clock.advance(RECORD_S)
        watched.tell(80.0, elapsed_s)
    assert watched.events == [80.0]


def test_orders_are_read_at_a_bounded_rate(watched: Watched) -> None:
    assert (watched.watch.should_stop(), watched.watch.is_cancelled()) == (False, False)
    watched.request_stop()
    watched.is_wanted = False
    assert (watched.watch.should_stop(), watched.watch.is_cancelled()) == (False, False)
    watched.clock.advance(READ_S)
    assert (watched.watch.should_stop(), watched.watch.is_cancelled()) == (True, True)


def test_the_progress_of_a_plan_that_is_not_wanted_any_more_is_not_recorded(watched: Watched) -> None:
    watched.is_wanted = False
    watched.clock.advance(RECORD_S)
    watched.tell(80.0)
    assert (watched.makespan_s, watched.events) == (None, [])


def test_what_work_waits_for_is_recorded_once_it_waits_for_long(record: StoreRecord) -> None:
    watched = Watched(record)
    watched.watch.waits_for("a free planning process")
    assert watched.waits_for == []
    for _ in range(3):
        watched.clock.advance(RECORD_S)
        watched.watch.waits_for("a free planning process")
    assert watched.waits_for == ["a free planning process"]
    watched.clock.advance(RECORD_S)
    watched.tell(100.0)
    assert watched.waits_for == ["a free planning process", ""]
    assert watched.makespan_s == 100.0
