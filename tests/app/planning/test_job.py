"""A planning job's turn: its result is recorded, unless the record wants another one, or none, by then."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from contextvars import copy_context
from dataclasses import replace
from typing import Any

import pytest
from sqlalchemy import select
from sqlalchemy.orm import object_session

from app.domain.goal_language.constraints import AppliedConstraints
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.plan import PlanState
from app.domain.mission_organiser import Margin
from app.planning import progress_watch
from app.planning.alternatives import Alternatives, AlternativesJob, Search
from app.planning.approval import PlanApproval
from app.planning.goal_planning import GoalPlanningJob
from app.planning.job import permitted
from app.planning.limits import PlanningLimits
from app.planning.pool.pool import WorkerClosed
from app.planning.pool.process import Watch
from app.planning.pool.waiting_line import Job
from app.planning.pool.work import Answer, Solution, Work, WorkResult
from app.planning.proposals import Proposals, close_plans, open_plans
from app.planning.requests import PlanningRequests
from app.planning.waiting_goals import WaitingGoals
from app.store import Database, GoalRow, PlanRow, WorldRow
from app.store.migrate import migrate
from app.workflows import PLAN_WAITING
from app.workflows.steps import CURRENT_RUN, Interrupted, Run
from planner import PlanNet, PlanningResult, PlanningStatus
from tests.app.planning.record import STORE, WORLD, StoreRecord
from tests.app.planning.store_engine import StoreEngine
from tests.app.scripted import InProcessWorker

Meanwhile = Callable[[GoalRow], None]


class InterruptedWorker(InProcessWorker):
    """While it works, another process or an operator changes the goal."""

    def __init__(self, record: StoreRecord) -> None:
        super().__init__(StoreEngine())
        self._record = record
        self.goal_id = ""
        self.meanwhile: Meanwhile = lambda _: None
        self.result: WorkResult[Any] | None = None
        self.is_closed = False
        self.calls = 0
        self.was_cancelled: bool | None = None
        self.renews = False

    def do(
        self,
        work: Work[Answer],
        time_limit_s: float,
        watch: Watch | None = None,
        job: Job | None = None,
        *,
        renew: Callable[[], Work[Answer]] | None = None,
        conclude: Callable[[WorkResult[Answer]], None] = lambda _: None,
    ) -> WorkResult[Answer]:
        assert watch is not None
        self.calls += 1
        if self.is_closed:
            raise WorkerClosed
        with self._record.database.write() as session:
            self.meanwhile(session.get_one(GoalRow, self.goal_id))
        self.was_cancelled = watch.is_cancelled()
        if self.renews and renew is not None:
            work = renew()
        if self.result is None:
            return super().do(work, time_limit_s, watch, conclude=conclude)
        conclude(self.result)
        return self.result


@pytest.fixture(autouse=True)
def _orders_are_read_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress_watch, "READ_S", 0.0)


@pytest.fixture(scope="module")
def unavailable() -> dict[str, str]:
    return {}


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory, unavailable: dict[str, str]) -> Iterator[StoreRecord]:
    database = Database(f"sqlite:///{tmp_path_factory.mktemp('record') / 'record.sqlite'}")
    migrate(database)
    record = StoreRecord(database, unavailable=lambda _: unavailable)
    with database.write() as session:
        record.add_world(session)
    yield record
    database.close()


@pytest.fixture
def worker(record: StoreRecord) -> InterruptedWorker:
    return InterruptedWorker(record)


@pytest.fixture
def planning(record: StoreRecord, worker: InterruptedWorker) -> GoalPlanningJob:
    return GoalPlanningJob(
        record.core,
        problems=record.problems,
        proposals=Proposals(record.core, clocks=record.clocks),
        waiting=WaitingGoals(record.core, clocks=record.clocks),
        worker=worker,
        limits=PlanningLimits(),
        approval=None,  # type: ignore[arg-type]  # no goal here is approved
    )


@pytest.fixture
def searching(record: StoreRecord, worker: InterruptedWorker) -> AlternativesJob:
    return AlternativesJob(
        record.core,
        problems=record.problems,
        proposals=Proposals(record.core, clocks=record.clocks),
        worker=worker,
        limits=PlanningLimits(),
    )


def plans(record: StoreRecord, goal_id: str) -> dict[str, PlanRow]:
    with record.database.read() as session:
        rows = session.scalars(select(PlanRow).where(PlanRow.goal_id == goal_id)).all()
    return {row.id: row for row in rows}


def planned(record: StoreRecord, worker: InterruptedWorker, planning: GoalPlanningJob) -> GoalRow:
    worker.goal_id = record.add_goal()
    planning.plan_once(worker.goal_id)
    return record.goal(worker.goal_id)


def test_a_plan_that_was_found_is_proposed(
    record: StoreRecord, worker: InterruptedWorker, planning: GoalPlanningJob
) -> None:
    goal = planned(record, worker, planning)
    assert (goal.state, worker.was_cancelled) == (GoalState.PLANNED, False)
    assert goal.releases_seen >= 7
    assert {row.state for row in plans(record, goal.id).values()} == {PlanState.PROPOSED}
    planning.plan_once(goal.id)
    assert (worker.calls, record.goal(goal.id).plan_id) == (1, goal.plan_id)


def cancel(goal: GoalRow) -> None:
    goal_lifecycle.withdraw(goal, outcome="cancelled", reason="cancelled")


def plan_in_another_process(goal: GoalRow) -> None:
    """After something has become free."""
    goal.releases_seen += 1


def release_something(goal: GoalRow) -> None:
    session = object_session(goal)
    assert session is not None
    session.get_one(WorldRow, WORLD).releases += 1


def plan_another_time(goal: GoalRow) -> None:
    goal.attempts += 1


@pytest.mark.parametrize(
    ("meanwhile", "state"),
    [
        (cancel, GoalState.WITHDRAWN),
        (plan_in_another_process, GoalState.PLANNING),
        (plan_another_time, GoalState.PLANNING),
    ],
)
@pytest.mark.parametrize(
    "result", [None, WorkResult(status=PlanningStatus.UNSOLVABLE, reason="no robot reaches bay_7")]
)
def test_the_result_of_a_turn_that_is_over_does_not_count(
    record: StoreRecord,
    worker: InterruptedWorker,
    planning: GoalPlanningJob,
    meanwhile: Meanwhile,
    state: GoalState,
    result: WorkResult[Any] | None,
) -> None:
    worker.meanwhile = meanwhile
    worker.result = result
    goal = planned(record, worker, planning)
    assert (goal.state, goal.plan_id) == (state, None)
    assert plans(record, goal.id) == {}
    assert worker.was_cancelled


def test_a_goal_without_a_plan_says_why(
    record: StoreRecord, worker: InterruptedWorker, planning: GoalPlanningJob
) -> None:
    worker.result = WorkResult(status=PlanningStatus.TIMED_OUT, reason="no answer within 30 s")
    goal = planned(record, worker, planning)
    assert (goal.state, goal.outcome, goal.reason) == (
        GoalState.UNSOLVABLE,
        "timed_out",
        "no answer within 30 s",
    )


def test_a_goal_without_a_plan_says_under_which_constraints(
    record: StoreRecord, worker: InterruptedWorker, planning: GoalPlanningJob
) -> None:
    worker.result = WorkResult(status=PlanningStatus.UNSOLVABLE, reason="interchange_1 is not clear")
    worker.goal_id = record.add_goal(terms={"constraints": {"without": ["yard_2"]}})
    planning.plan_once(worker.goal_id)
    assert record.goal(worker.goal_id).reason == "interchange_1 is not clear, without yard_2"


def test_a_goal_that_makes_no_sense_any_more_is_not_planned(
    record: StoreRecord, worker: InterruptedWorker, planning: GoalPlanningJob
) -> None:
    worker.goal_id = record.add_goal("in(sample_1, bay_2)")
    planning.plan_once(worker.goal_id)
    goal = record.goal(worker.goal_id)
    assert (goal.state, goal.outcome, worker.calls) == (GoalState.UNSOLVABLE, "unsolvable", 0)
    assert "sample_2" in goal.reason


def test_a_goal_whose_robot_rests_waits_and_is_planned_at_once_if_something_became_free_meanwhile(
    record: StoreRecord, worker: InterruptedWorker, planning: GoalPlanningJob, unavailable: dict[str, str]
) -> None:
    unavailable["store_2"] = "which charges"
    try:
        goal = planned(record, worker, planning)
        assert (goal.state, goal.reason) == (GoalState.WAITING, "waits for store_2, which charges")
        assert record.workflows.started == []
        worker.meanwhile = release_something
        assert planned(record, worker, planning).state == GoalState.WAITING
        assert record.workflows.started == [(PLAN_WAITING, WORLD)]
    finally:
        unavailable.clear()


def test_work_that_has_waited_for_a_process_is_done_in_the_present_world(
    record: StoreRecord, worker: InterruptedWorker, planning: GoalPlanningJob, unavailable: dict[str, str]
) -> None:
    def rest_and_release(goal: GoalRow) -> None:
        unavailable["store_2"] = "which charges"
        release_something(goal)

    worker.meanwhile = rest_and_release
    worker.renews = True
    started = list(record.workflows.started)
    try:
        goal = planned(record, worker, planning)
        assert (goal.state, goal.reason) == (GoalState.WAITING, "waits for store_2, which charges")
        assert record.workflows.started == started  # the release is in the world that it was planned in
    finally:
        unavailable.clear()


def test_work_that_is_no_longer_wanted_is_not_renewed(
    record: StoreRecord, worker: InterruptedWorker, planning: GoalPlanningJob
) -> None:
    worker.meanwhile = cancel
    worker.renews = True
    goal = planned(record, worker, planning)
    assert (goal.state, goal.plan_id) == (GoalState.WITHDRAWN, None)


def test_nothing_is_recorded_when_the_service_ends(
    record: StoreRecord, worker: InterruptedWorker, planning: GoalPlanningJob
) -> None:
    worker.is_closed = True
    assert planned(record, worker, planning).state == GoalState.PLANNING


def plan_waiting_goals(record: StoreRecord, workflow: str, plan: Callable[[str], None]) -> None:
    """Run the workflow that plans the world's waiting goals, in a process that ends when `plan` says so."""

    def run() -> None:
        CURRENT_RUN.set(Run(workflow))
        WaitingGoals(record.core, clocks=record.clocks).run(WORLD, plan=plan)

    with suppress(Interrupted):
        copy_context().run(run)


def test_a_waiting_goal_whose_planning_was_interrupted_is_planned_on_by_the_workflow_that_planned_it(
    record: StoreRecord, worker: InterruptedWorker, planning: GoalPlanningJob
) -> None:
    worker.goal_id = record.add_goal(state=GoalState.WAITING, reason="waits", priority=9, releases_seen=-1)

    def plan_until_the_process_ends(goal_id: str) -> None:
        planning.plan_once(goal_id)
        raise Interrupted

    worker.is_closed = True
    plan_waiting_goals(record, "waiting-1", plan_until_the_process_ends)
    assert record.goal(worker.goal_id).state == GoalState.PLANNING
    worker.is_closed = False
    plan_waiting_goals(record, "waiting-2", plan_until_the_process_ends)
    assert record.goal(worker.goal_id).state == GoalState.PLANNING
    plan_waiting_goals(record, "waiting-1", plan_until_the_process_ends)
    goal = record.goal(worker.goal_id)
    assert (goal.state, goal.planned_by) == (GoalState.PLANNED, None)


@pytest.fixture
def searched(
    record: StoreRecord, worker: InterruptedWorker, planning: GoalPlanningJob
) -> tuple[str, Alternatives]:
    """A planned goal whose alternatives are searched for."""
    goal = planned(record, worker, planning)
    alternatives = Alternatives(record.core, problems=record.problems)
    alternatives.search(goal.id, 4, actor="me")
    return goal.id, alternatives


def test_alternatives_are_proposed_beside_the_first_plan(
    record: StoreRecord, searching: AlternativesJob, searched: tuple[str, Alternatives]
) -> None:
    goal_id, alternatives = searched
    first = record.goal(goal_id).plan_id
    searching.plan_once(goal_id)
    goal = record.goal(goal_id)
    assert goal.plan_id == first
    assert (goal.alternatives or {})["state"] == Search.FOUND
    assert len(alternatives.plans(goal_id)) > 1


def approve_nothing_more(goal: GoalRow) -> None:
    goal.alternatives = None


def reject_the_first_plan(goal: GoalRow) -> None:
    goal.plan_id = "another"


@pytest.mark.parametrize("meanwhile", [cancel, approve_nothing_more, reject_the_first_plan])
def test_alternatives_to_a_plan_that_is_decided_on_meanwhile_are_not_proposed(
    record: StoreRecord,
    worker: InterruptedWorker,
    searching: AlternativesJob,
    searched: tuple[str, Alternatives],
    meanwhile: Meanwhile,
) -> None:
    goal_id, _ = searched
    worker.meanwhile = meanwhile
    searching.plan_once(goal_id)
    assert len(plans(record, goal_id)) == 1
    assert worker.was_cancelled


def test_rejecting_the_plan_that_alternatives_are_compared_with_ends_the_search(
    record: StoreRecord, searching: AlternativesJob, searched: tuple[str, Alternatives]
) -> None:
    goal_id, alternatives = searched
    first = record.goal(goal_id).plan_id
    assert first is not None
    searching.plan_once(goal_id)
    alternatives.search(goal_id, 4, actor="me")
    approval = PlanApproval(
        record.core,
        margin=Margin(relative=0.5, absolute_s=10.0, answers_s={}),
        requests=PlanningRequests(record.core, clocks=record.clocks),
        worlds={},
        clocks=record.clocks,
    )
    approval.reject(first, actor="me")
    goal = record.goal(goal_id)
    assert (goal.state, goal.alternatives) == (GoalState.PLANNED, None)
    assert goal.plan_id != first


def test_a_search_that_fails_leaves_the_plan_open(
    record: StoreRecord,
    worker: InterruptedWorker,
    searching: AlternativesJob,
    searched: tuple[str, Alternatives],
) -> None:
    goal_id, _ = searched
    worker.result = WorkResult(status=PlanningStatus.TIMED_OUT)
    searching.plan_once(goal_id)
    goal = record.goal(goal_id)
    assert goal.alternatives == {"state": "failed", "count": 4, "reason": "timed_out"}
    with record.database.write() as session:
        assert [plan.id for plan in open_plans(session, goal_id)] == [goal.plan_id]
        close_plans(session, record.events, session.get_one(GoalRow, goal_id), PlanState.EXPIRED, "over")
    assert record.goal(goal_id).alternatives is None


def test_a_plan_that_fills_what_is_to_stay_empty_is_not_proposed_and_waits_for_the_hold(
    record: StoreRecord,
) -> None:
    goal_id = record.add_goal()
    with record.database.read() as session:
        built = record.problems.build(session, session.get_one(GoalRow, goal_id))
    over_2 = solution(STORE.store_sample_1())
    empty = AppliedConstraints(kept_empty=frozenset({"interchange_2"}))
    held = replace(
        built,
        constraints=empty,
        withheld=replace(built.withheld, holds={"the end of hold h": empty}),
    )
    assert permitted(built, WorkResult.solved((over_2,))).answer == (over_2,)
    refused = permitted(held, WorkResult.solved((over_2,)))
    assert (refused.answer, refused.waits_for.holds) == (None, ("the end of hold h",))
    assert refused.reason.endswith("it puts a sample in interchange_2")
    idle = solution(STORE.plan([], "in(sample_2, bay_2)"))
    assert permitted(held, WorkResult.solved((over_2, idle))).answer == (idle,)


def solution(net: PlanNet) -> Solution:
    result = PlanningResult(status=PlanningStatus.SOLVED, engine="none", planning_s=0.0, plan_net=net)
    return Solution(result=result)
