"""Which of the goals that wait is planned next."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing
from contextvars import copy_context
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import pytest
from dbos import DBOS
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.lifecycles.goal import GoalState
from app.planning.waiting_goals import GOALS_PER_WORKFLOW, LOOK_S, WaitingGoals, most_urgent
from app.store import Database, GoalRow, WorldRow
from app.store.event_log import EventLog
from app.store.facts import FactStore
from app.store.migrate import migrate
from app.store.plan_nets import PlanNets
from app.store.reservations import Reservations
from app.workflows import PLAN_WAITING, Workflows
from app.workflows.steps import CURRENT_RUN, Run
from planner import load_knowledge_base
from robots.clock import ManualClock
from tests.app.planning.record import RecordedWorkflows
from tests.app.stepped_clock import SteppedClock
from tests.waiting import until


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Database]:
    """A record with one world."""
    with closing(Database(f"sqlite:///{tmp_path / 'lab.sqlite'}")) as database:
        migrate(database)
        with database.write() as session:
            session.add(WorldRow(id="lab", title="Lab", layout={}, releases=0))
        yield database


@pytest.fixture
def workflows(lab: Database) -> Iterator[Workflows]:
    """Not launched."""
    with closing(Workflows(lab.url)) as workflows:
        yield workflows


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    database = Database(f"sqlite:///{tmp_path / 'record.sqlite'}")
    migrate(database)
    with database.write() as session:
        session.add(WorldRow(id="lab", title="Lab", layout={}, releases=1))
        session.flush()
        yield session
    database.close()


def waiting(session: Session, name: str, **more: Any) -> None:
    usual = {
        "id": name,
        "world": "lab",
        "text": name,
        "goal": [],
        "priority": 0,
        "auto_approve": False,
        "state": GoalState.WAITING,
        "reason": "waits for mission m",
        "created_by": "me",
    }
    session.add(GoalRow(**{**usual, **more}))
    session.flush()


def order(session: Session) -> list[str]:
    """The goals in the order they are planned in; none gets a plan."""
    planned = []
    while (name := most_urgent(session, "lab")) is not None:
        planned.append(name)
        session.get_one(GoalRow, name).releases_seen = session.get_one(WorldRow, "lab").releases
        session.flush()
    return planned


def test_priority_comes_before_deadline_and_deadline_before_age(session: Session) -> None:
    waiting(session, "old", created_at="2026-01-01T00:00:00Z")
    waiting(session, "new", created_at="2026-01-02T00:00:00Z")
    waiting(session, "late", deadline_at_s=900.0)
    waiting(session, "soon", deadline_at_s=100.0)
    waiting(session, "urgent", priority=5)
    waiting(session, "more urgent, soon", priority=5, deadline_at_s=100.0)
    assert order(session) == ["more urgent, soon", "urgent", "soon", "late", "old", "new"]


def test_a_goal_is_planned_once_for_all_that_became_free_until_then(session: Session) -> None:
    waiting(session, "one")
    assert order(session) == ["one"]
    assert order(session) == []
    session.get_one(WorldRow, "lab").releases += 3
    session.flush()
    assert order(session) == ["one"]


def test_many_goals_are_planned_by_several_workflows_one_after_the_other(
    lab: Database, workflows: Workflows
) -> None:
    goals, planned = WaitingGoals(core_of(lab, workflows), clocks={}), SimpleQueue[str]()

    def plan(goal_id: str) -> None:
        with lab.write() as session:
            session.get_one(GoalRow, goal_id).releases_seen = 1
        planned.put(goal_id)

    workflows.register(PLAN_WAITING, partial(goals.run, plan=plan))
    workflows.launch()
    names = [f"goal {number:03}" for number in range(2 * GOALS_PER_WORKFLOW + 1)]
    with lab.write() as session:
        for name in names:
            waiting(session, name, created_at=name, releases_seen=0)
        goals.release(session, "lab")
    assert [planned.get(timeout=30) for _ in names] == names
    until(lambda: [one.status for one in DBOS.list_workflows(name=PLAN_WAITING)] == ["SUCCESS"] * 3)


class Planner:
    """Plans waiting goals of the world `lab` with workflows that the test runs."""

    def __init__(self, lab: Database, *, wall_clock: SteppedClock) -> None:
        self.workflows = RecordedWorkflows()
        self.goals = WaitingGoals(
            core_of(lab, self.workflows),  # type: ignore[arg-type]
            clocks={"lab": ManualClock()},
            wall_clock=wall_clock,
        )
        self.planned: list[str] = []
        self.meanwhile: Callable[[], None] = lambda: None
        """Happens during the next planning."""
        self._lab = lab

    def release(self) -> str | None:
        """The workflow that is to begin after it."""
        with self._lab.write() as session:
            self.goals.release(session, "lab")
        return self.to_begin

    @property
    def to_begin(self) -> str | None:
        with self._lab.read() as session:
            return session.get_one(WorldRow, "lab").waiting_workflow

    def run(self, workflow: str | None, **more: Any) -> None:
        assert workflow is not None
        context = copy_context()
        context.run(CURRENT_RUN.set, Run(workflow))
        context.run(partial(self.goals.run, "lab", plan=self._plan, **more))

    def _plan(self, goal_id: str) -> None:
        self.planned.append(goal_id)
        with self._lab.write() as session:
            session.get_one(GoalRow, goal_id).releases_seen = session.get_one(WorldRow, "lab").releases
        meanwhile, self.meanwhile = self.meanwhile, lambda: None
        meanwhile()


@pytest.fixture
def wall_clock() -> SteppedClock:
    return SteppedClock()


@pytest.fixture
def planner(lab: Database, wall_clock: SteppedClock) -> Planner:
    with lab.write() as session:
        waiting(session, "one")
    return Planner(lab, wall_clock=wall_clock)


def test_releases_until_the_workflow_begins_start_one(planner: Planner) -> None:
    workflow = planner.release()
    assert planner.release() == workflow
    assert planner.workflows.started == [(PLAN_WAITING, "lab")]
    planner.run(workflow)
    assert planner.planned == ["one"]
    assert planner.to_begin is None


def test_a_release_after_the_workflow_has_begun_starts_another(planner: Planner) -> None:
    planner.meanwhile = lambda: assert_new(planner, workflow)
    workflow = planner.release()
    planner.run(workflow)
    assert planner.planned == ["one", "one"]  # it had not ended
    planner.run(planner.to_begin)
    assert planner.planned == ["one", "one"]
    assert planner.to_begin is None


def assert_new(planner: Planner, workflow: str | None) -> None:
    assert planner.release() not in (None, workflow)


def test_a_workflow_that_is_run_again_leaves_the_one_that_is_to_begin(planner: Planner) -> None:
    first = planner.release()
    planner.run(first)
    second = planner.release()
    planner.run(first)
    assert planner.to_begin == second


def test_a_workflow_that_failed_before_it_had_begun_is_started_again(
    planner: Planner, wall_clock: SteppedClock
) -> None:
    failed = planner.release()
    for has_ended, expected in ((False, 1), (True, 2)):
        planner.workflows.has_all_ended = has_ended
        wall_clock.advance(LOOK_S)
        planner.goals.handle_availability("lab")
        assert len(planner.workflows.started) == expected
    assert planner.to_begin not in (None, failed)


def seen(lab: Database, *names: str) -> None:
    """These goals have been planned, or are carried out."""
    with lab.write() as session:
        for name in names:
            session.get_one(GoalRow, name).releases_seen = session.get_one(WorldRow, "lab").releases


def test_goals_are_planned_together_until_nothing_comes_of_it(planner: Planner, lab: Database) -> None:
    with lab.write() as session:
        for number, name in enumerate(("two", "three", "four", "five"), start=2):
            waiting(session, name, created_at=f"2030-01-0{number}T00:00:00Z")
    rounds = iter((("one", "two"), ("three",), ()))
    asked = []

    def together(world: str) -> bool:
        asked.append(world)
        names = next(rounds)
        seen(lab, *names)
        return bool(names)

    planner.run(planner.release(), together=together)
    assert asked == ["lab"] * 3
    assert planner.planned == ["four", "five"]


def test_goals_are_planned_by_themselves_if_planning_them_together_fails(
    planner: Planner, lab: Database, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.workflows.steps.RETRY_S", 0.0)
    with lab.write() as session:
        waiting(session, "two", created_at="2030-01-02T00:00:00Z")

    def together(world: str) -> bool:
        raise RuntimeError("a defect")

    planner.run(planner.release(), together=together)
    assert planner.planned == ["one", "two"]


def test_a_goal_that_another_carries_out_is_planned_again_once_that_one_has_ended(
    planner: Planner, lab: Database, wall_clock: SteppedClock
) -> None:
    with lab.write() as session:
        waiting(session, "both", state=GoalState.COMMITTED)
        session.get_one(GoalRow, "one").joint_goal = "both"
    assert planner.release() is None, "nothing is to be planned"
    wall_clock.advance(LOOK_S)
    planner.goals.handle_availability("lab")
    assert planner.to_begin is None
    with lab.write() as session:
        session.get_one(GoalRow, "both").state = GoalState.WITHDRAWN  # nothing is released by that
    for _ in range(2):
        wall_clock.advance(LOOK_S)
        planner.goals.handle_availability("lab")
    assert planner.workflows.started == [(PLAN_WAITING, "lab")]
    planner.run(planner.to_begin)
    assert planner.planned == ["one"]
    wall_clock.advance(LOOK_S)
    planner.goals.handle_availability("lab")
    assert planner.to_begin is None


def test_an_available_robot_is_not_forgotten_while_the_database_is_away_or_another_comes(
    lab: Database, workflows: Workflows, monkeypatch: pytest.MonkeyPatch
) -> None:
    goals = WaitingGoals(core_of(lab, workflows), clocks={})
    write = lab.write

    def away() -> AbstractContextManager[Session]:
        raise ConnectionError("away")

    def another_comes() -> AbstractContextManager[Session]:
        goals.robot_available("lab")
        return write()

    goals.robot_available("lab")
    monkeypatch.setattr(lab, "write", away)
    with pytest.raises(ConnectionError):
        goals.handle_availability("lab")
    monkeypatch.setattr(lab, "write", another_comes)
    goals.handle_availability("lab")
    monkeypatch.setattr(lab, "write", write)
    for _ in range(2):
        goals.handle_availability("lab")
    with lab.read() as session:
        assert session.get_one(WorldRow, "lab").releases == 2


def core_of(database: Database, workflows: Workflows) -> Core:
    events, knowledge_base = EventLog(database), load_knowledge_base()
    return Core(
        database=database,
        events=events,
        facts=FactStore(events, knowledge_base),
        workflows=workflows,
        knowledge_base=knowledge_base,
        plan_nets=PlanNets(knowledge_base),
        reservations=Reservations(PlanNets(knowledge_base)),
    )


@pytest.mark.parametrize("state", [GoalState.SUBMITTED, GoalState.PLANNING, GoalState.WITHDRAWN])
def test_goals_that_do_not_wait_are_left_alone(session: Session, state: GoalState) -> None:
    waiting(session, "one", state=state)
    assert order(session) == []
