"""A service that begins again meets its world: one of the recorded run goes on, another starts a new run."""

import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import update

from app.composition import RunningWorld, Service
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.plan import PlanState
from app.planning.goal_service import GoalRequest
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from app.store import Database, ExecutorRow
from app.workflows.leases import DEAD_AFTER_S
from robots.world import load_world
from tests.app.conftest import TOKEN
from tests.app.fake_robots import FakeTeam
from tests.databases import ON_BOTH
from tests.waiting import awaited

Begin = Callable[[RunningWorld], AbstractContextManager[Service]]
ROBOTS = {"yard_1", "yard_2", "store_1", "store_2"}


@pytest.fixture
def begin(tmp_path: Path, database_url: str, worker: PlanningWorker) -> Begin:
    """Services in turn on one record."""
    settings = Settings(data=tmp_path, token=TOKEN, database_url=database_url)
    return lambda world: Service(settings, [world], worker=worker)


@pytest.fixture
def world(team: FakeTeam) -> RunningWorld:
    file = load_world("sample_store")
    return RunningWorld(file=file, link=team.link, clock=team.clock, rate=None, run=team.run)


def goal(service: Service, text: str, *, auto_approve: bool, until: GoalState) -> str:
    request = GoalRequest(world="sample_store", text=text, auto_approve=auto_approve)
    goal_id = service.goals.submit(request, actor="test").id
    wait_for(service, goal_id, until)
    return goal_id


def wait_for(service: Service, goal_id: str, *states: GoalState) -> None:
    awaited(lambda: service.goals.get(goal_id), lambda found: found.state in states)


def facts(service: Service) -> set[tuple[str, str]]:
    """Every fact and its source."""
    return {(row.atom, row.source) for _, row in service.worlds.facts("sample_store")[0]}


def make_seem_killed(database_url: str) -> None:
    """The process that ended was heard of a moment ago, and the record still has it hold its world."""
    database = Database(database_url)
    with database.write() as session:
        session.execute(update(ExecutorRow).values(seen_at=time.time() - DEAD_AFTER_S / 2))
    database.close()


def under_way(service: Service, team: FakeTeam) -> tuple[str, str, str]:
    """A goal whose robots have not begun, a goal that waits for a decision, and its plan."""
    team.faults.stuck = set(ROBOTS)
    running = goal(service, "move sample_1 to bay_7", auto_approve=True, until=GoalState.COMMITTED)
    undecided = goal(service, "move sample_2 to bay_3", auto_approve=False, until=GoalState.PLANNED)
    return running, undecided, service.goals.get(undecided).plan_id or ""


def test_a_world_of_the_recorded_run_goes_on(begin: Begin, world: RunningWorld, team: FakeTeam) -> None:
    with begin(world) as first:
        running, undecided, plan = under_way(first, team)
    team.faults.stuck.clear()
    with begin(world) as second:
        assert second.goals.get(undecided).plan_id == plan
        assert second.plans.get(plan).state == PlanState.PROPOSED
        wait_for(second, running, GoalState.FINISHED)
        assert second.goals.get(running).outcome == MissionState.COMPLETED
        believed = facts(second)
    assert any(source != "world file sample_store" for _, source in believed)
    with begin(world) as third:
        assert facts(third) == believed


@ON_BOTH
def test_a_world_of_another_run_starts_a_new_run_and_says_why(
    begin: Begin, world: RunningWorld, team: FakeTeam, database_url: str
) -> None:
    with begin(world) as first:
        running, undecided, plan = under_way(first, team)
    make_seem_killed(database_url)
    with begin(replace(world, run="another", new_run_reason="its snapshot is torn")) as second:
        ended = second.goals.get(running)
        assert (ended.state, ended.outcome) == (GoalState.FINISHED, MissionState.FAILED)
        assert ended.reason == "the simulated world was started again: its snapshot is torn"
        assert second.plans.get(plan).state == PlanState.EXPIRED
        wait_for(second, undecided, GoalState.PLANNED)


def test_a_world_that_did_not_run_in_between_does_not_go_on(
    begin: Begin, world: RunningWorld, team: FakeTeam
) -> None:
    with begin(world) as first:
        running, undecided, _ = under_way(first, team)
    other = replace(world, file=load_world("relocation_lab"), run="of the laboratory")
    with begin(other) as second:
        ended = second.goals.get(running)
        assert ended.outcome == MissionState.FAILED
        assert ended.reason == "world sample_store no longer runs"
        assert second.goals.get(undecided).state == GoalState.WITHDRAWN
