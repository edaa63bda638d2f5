"""The planning problem that a goal poses: what was learned, what is urgent, who rests, what would never help."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.world_model import Reservation
from app.planning.problem_builder import GoalProblem, ProblemBuilder
from app.store import Database, DurationRow, GoalRow, WorldRow
from app.store.event_log import EventLog
from app.store.facts import FactStore
from app.store.migrate import migrate
from app.store.plan_nets import PlanNets
from app.store.reservations import MissionReservation, Reservations
from planner import Fact, FastDownwardEngine, PlanningRequest, scale_term
from robots.clock import ManualClock
from tests.app.sample_store import Store, said

STORE = Store()
STORED = STORE.fact("in(sample_1, bay_7)")


class Asker:
    """Poses goals of the sample store from a record of its own, at 100 s of the world's time."""

    def __init__(self, database: Database, session: Session, resting: dict[str, str]) -> None:
        self._session = session
        events, nets = EventLog(database), PlanNets(STORE.base)
        core = Core(
            database=database,
            events=events,
            facts=FactStore(events, STORE.base),
            workflows=None,  # type: ignore[arg-type]
            knowledge_base=STORE.base,
            plan_nets=nets,
            holdings=Reservations(nets),
        )
        clock = ManualClock()
        clock.advance(100.0)
        self._posing = ProblemBuilder(
            core,
            worlds={"sample_store": STORE.world},
            clocks={"sample_store": clock},
            points=lambda _: {},
            resting=lambda _: resting,
        )
        session.add(WorldRow(id="sample_store", title="Store", layout={}, releases=7))
        session.flush()
        core.facts.change(session, "sample_store", add=STORE.facts, source="file", at_s=0.0)

    def knows(self, action: str, *, samples: int, mean: float) -> None:
        row = DurationRow(
            world="sample_store", action=action, team=1, samples=samples, mean=mean, variance=0.0
        )
        self._session.add(row)
        self._session.flush()

    def pose(self, *texts: str, **more: Any) -> GoalProblem:
        goals = [said(text).model_dump() for text in texts or ("in(sample_1, bay_7)",)]
        goal = GoalRow(world="sample_store", goal=goals, priority=0, **more)
        posed = self._posing.pose(self._session, goal)
        assert posed.releases == 7
        return posed


@pytest.fixture
def resting() -> dict[str, str]:
    return {}


@pytest.fixture
def asker(tmp_path: Path, resting: dict[str, str]) -> Iterator[Asker]:
    database = Database(f"sqlite:///{tmp_path / 'record.sqlite'}")
    migrate(database)
    with database.write() as session:
        yield Asker(database, session, resting)
    database.close()


def test_a_deadline_counts_from_now_on(asker: Asker) -> None:
    assert asker.pose().problem.deadlines_s == {}
    assert asker.pose(deadline_at_s=130.0).problem.deadlines_s == {STORED: 30.0}
    assert asker.pose(deadline_at_s=90.0).problem.deadlines_s == {STORED: -10.0}
    assert asker.pose().problem.priorities == {STORED: 0}


def test_learned_durations_scale_the_plan(asker: Asker) -> None:
    asker.knows("DOCK", samples=97, mean=2.0)
    posed = asker.pose()
    assert posed.factors == {("DOCK", 1): 1.97}
    assert posed.problem.functions[scale_term("DOCK", 1)] == 1.97
    result = FastDownwardEngine(STORE.base).plan(posed.problem, PlanningRequest(time_limit_s=30))
    assert result.plan_net is not None
    docks = [action.duration_s for action in result.plan_net.actions if action.tag == "DOCK"]
    assert docks == [4.925] * len(docks)


def test_a_resting_robot_can_do_nothing_but_stays_where_it_is(asker: Asker, resting: dict[str, str]) -> None:
    resting["store_2"] = "which charges"
    posed = asker.pose()
    assert not any(f.predicate == "can" and f.args[0] == "store_2" for f in posed.problem.facts)
    assert Fact("in_area", ("store_2", "aisle_2")) in posed.problem.facts
    assert posed.waits_for == "store_2, which charges"


def test_waiting_is_in_vain_if_nobody_could_do_it_either_when_all_are_free(
    asker: Asker, resting: dict[str, str]
) -> None:
    asker.knows("DOCK", samples=5, mean=1.2)
    resting["store_2"] = "which charges"
    assert asker.pose().why_never(STORE.base) == ""
    assert "yard_1" in asker.pose("tracked(store_1, yard_1)").why_never(STORE.base)


def held(*robots: str) -> list[MissionReservation]:
    """Missions of a robot each."""
    return [
        MissionReservation(mission_id=robot, reservation=Reservation(robots=frozenset({robot})))
        for robot in robots
    ]


@pytest.mark.parametrize(
    ("busy", "waits_for"),
    [
        (("store_1", "store_2", "yard_1"), ["store_2"]),
        (("yard_1", "yard_2"), ["yard_1", "yard_2"]),  # either would do
    ],
)
def test_a_goal_waits_for_those_missions_that_stand_in_its_way(
    asker: Asker, busy: tuple[str, ...], waits_for: list[str]
) -> None:
    posed = replace(asker.pose(), held=held(*busy)).narrowed(STORE.base)
    assert [one.mission_id for one in posed.held] == waits_for


def test_a_goal_waits_for_no_mission_while_the_robot_it_needs_rests(
    asker: Asker, resting: dict[str, str]
) -> None:
    resting |= {"store_2": "which charges", "yard_1": "which charges"}
    posed = replace(asker.pose(), held=held("store_1")).narrowed(STORE.base)
    assert posed.waits_for == "store_2, which charges"


def test_goals_that_contradict_each_other_do_not_wait(asker: Asker) -> None:
    posed = asker.pose("near(yard_1, door_1)", "near(yard_2, door_1)")
    assert posed.why_never(STORE.base) == "yard_1 is near door_1 or yard_2 is near door_1, not both"
