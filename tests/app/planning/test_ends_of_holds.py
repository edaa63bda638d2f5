"""When holds end: by stepped clocks, after a restart, and in a new run of their world."""

from collections.abc import Sequence
from datetime import UTC, datetime

import pytest
from sqlalchemy import select

from app.domain.goal_language.stated_holds import HoldEnd, StatedHold
from app.domain.lifecycles.hold import HoldState
from app.missions.world_start import start_world_run
from app.planning.hold_service import HoldService
from app.planning.waiting_goals import WaitingGoals
from app.store import Database, GoalRow, HoldRow, WorldRow
from app.store.editions import WorldDirectory
from app.store.standing_holds import standing_holds
from tests.app.planning.record import STORE, WORLD, StoreRecord
from tests.app.stepped_clock import SteppedClock
from tests.databases import ON_BOTH

pytestmark = ON_BOTH
START_S = 1_800_000_000.0


class Holder:
    """The holds of the sample store, as one process of the service keeps them."""

    def __init__(self, database: Database, clock: SteppedClock) -> None:
        self.record = StoreRecord(database, unavailable=lambda _: {})
        self.world_clock = self.record.clocks[WORLD]
        self.waiting = WaitingGoals(self.record.core, clocks=self.record.clocks)
        self.holds = HoldService(
            self.record.core,
            worlds=WorldDirectory(database, {WORLD: STORE.world}),
            clocks=self.record.clocks,
            waiting=self.waiting,
            wall_clock=clock,
        )

    def hold(self, place: str, until: HoldEnd) -> None:
        goal_id = self.record.add_goal()
        with self.record.database.write() as session:
            goal = session.get_one(GoalRow, goal_id)
            stated = [StatedHold(places=(place,), until=until)]
            self.holds.begin(session, goal, stated, STORE.world, actor="ann")

    def standing(self) -> list[str]:
        """The places that are held, after a turn."""
        self.holds.follow(WORLD)
        with self.record.database.read() as session:
            return sorted(place for hold in standing_holds(session, WORLD) for place in hold.places)

    def endings(self) -> Sequence[str | None]:
        query = select(HoldRow).where(HoldRow.state == HoldState.ENDED).order_by(HoldRow.created_at)
        with self.record.database.read() as session:
            return [row.ending for row in session.scalars(query)]


@pytest.fixture
def clock() -> SteppedClock:
    return SteppedClock(epoch_s=START_S)


@pytest.fixture
def holder(database: Database, clock: SteppedClock) -> Holder:
    holder = Holder(database, clock)
    with database.write() as session:
        holder.record.add_world(session)
        session.get_one(WorldRow, WORLD).run = "run-1"
    return holder


def moment(epoch_s: float) -> HoldEnd:
    return HoldEnd(at=datetime.fromtimestamp(epoch_s, UTC))


def test_a_hold_ends_when_its_time_has_come_and_not_before(holder: Holder, clock: SteppedClock) -> None:
    holder.hold("bay_7", moment(START_S + 60))
    clock.advance(59)
    assert holder.standing() == ["bay_7"]
    clock.advance(1)
    assert holder.standing() == []
    assert holder.endings() == ["time"]


def test_the_end_of_one_hold_leaves_the_others(holder: Holder, clock: SteppedClock) -> None:
    holder.hold("bay_7", moment(START_S + 60))
    holder.hold("bay_8", HoldEnd(in_s=90))
    holder.hold("bay_9", HoldEnd())
    clock.advance(100)
    assert holder.standing() == ["bay_8", "bay_9"]
    holder.world_clock.advance(90)
    assert holder.standing() == ["bay_9"]
    clock.advance(1e9)
    assert holder.standing() == ["bay_9"]


def test_between_changes_and_times_the_record_is_not_read(
    holder: Holder, clock: SteppedClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    holder.hold("bay_7", moment(START_S + 60))
    holder.standing()
    database = holder.record.database

    def unread() -> None:
        raise AssertionError("the record was read")

    monkeypatch.setattr(database, "read", unread)
    clock.advance(59)
    holder.holds.follow(WORLD)
    clock.advance(1)
    with pytest.raises(AssertionError, match="was read"):
        holder.holds.follow(WORLD)


def test_a_turn_without_the_database_is_made_up_for_by_the_next(
    holder: Holder, clock: SteppedClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    holder.hold("bay_7", moment(START_S + 60))
    clock.advance(60)

    def away() -> None:
        raise ConnectionError("away")

    with monkeypatch.context() as patch:
        patch.setattr(holder.record.database, "write", away)
        with pytest.raises(ConnectionError):
            holder.holds.follow(WORLD)
    assert holder.standing() == []


def test_a_hold_survives_a_restart_and_one_whose_time_passed_meanwhile_ends_at_the_start(
    holder: Holder, clock: SteppedClock, database: Database
) -> None:
    holder.hold("bay_7", moment(START_S + 60))
    holder.hold("bay_8", moment(START_S + 6000))
    clock.advance(600)
    again = Holder(database, clock)
    assert again.standing() == ["bay_8"]
    assert again.endings() == ["time"]


def test_an_end_is_a_release_that_waiting_goals_see(holder: Holder, clock: SteppedClock) -> None:
    holder.hold("bay_7", moment(START_S + 60))
    with holder.record.database.read() as session:
        before = session.get_one(WorldRow, WORLD).releases
    clock.advance(60)
    holder.standing()
    with holder.record.database.read() as session:
        assert session.get_one(WorldRow, WORLD).releases == before + 1


def test_spans_end_with_the_run_whose_clock_they_count_on(holder: Holder) -> None:
    holder.hold("bay_7", HoldEnd(in_s=600))
    holder.hold("bay_8", HoldEnd())
    with holder.record.database.write() as session:
        assert start_world_run(session, holder.record.core, STORE.world, "run-1")
    assert holder.standing() == ["bay_7", "bay_8"]
    with holder.record.database.write() as session:
        assert not start_world_run(session, holder.record.core, STORE.world, "run-2")
    assert holder.standing() == ["bay_8"]
    assert holder.endings() == ["new_run"]


def test_a_hold_that_two_processes_end_at_once_ends_once(
    holder: Holder, clock: SteppedClock, database: Database
) -> None:
    other = Holder(database, clock)
    holder.hold("bay_7", moment(START_S + 60))
    clock.advance(60)
    assert (other.standing(), holder.standing()) == ([], [])
    types = [event.type for event in holder.record.events.since(0)]
    assert types.count("hold.ended") == 1


def test_an_unknown_name_in_a_fact_leaves_the_hold_to_an_operator(holder: Holder) -> None:
    fact = {"predicate": "in", "args": ["sample_9", "bay_1"]}
    holder.hold("bay_7", HoldEnd.model_validate({"fact": fact}))
    assert holder.standing() == ["bay_7"]
