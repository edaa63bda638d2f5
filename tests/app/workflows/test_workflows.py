"""Durable workflows: begun when the transaction that starts them commits."""

import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from queue import Empty, Queue

import psycopg
import pytest
from sqlalchemy import text

from app.store import Database, announce
from app.store.engine import CHANNEL
from app.workflows import MISSIONS, PLANNING, QUEUES, Workflows, or_give_up, sleep_until_woken, step
from app.workflows import Queue as WorkflowQueue
from app.workflows.engine import WAKE
from app.workflows.notifications import NotificationListener
from tests.app.stepped_clock import HeldClock
from tests.databases import ON_BOTH
from tests.waiting import until

pytestmark = ON_BOTH
HARDLY_EVER_S = 3600.0


class StandingClock(HeldClock):
    """Counts the waits of each thread."""

    def __init__(self) -> None:
        super().__init__()
        self.waits = Counter[str]()
        """By the thread's name."""

    def wait(self, event: threading.Event, timeout_s: float) -> bool:
        self.waits[threading.current_thread().name] += 1
        return super().wait(event, timeout_s)

    def wait_twice(self, thread: str) -> None:
        """Return once the thread has begun two more waits: whatever it did after the first is over."""
        begun = self.waits[thread]
        until(lambda: self.waits[thread] >= begun + 2)


@pytest.fixture
def carried_out() -> Queue[str]:
    return Queue()


def fail_for_good() -> None:
    raise LookupError


@pytest.fixture
def workflows(database: Database, carried_out: Queue[str]) -> Iterator[Workflows]:
    """Workflows that are hardly ever looked for."""
    workflows = Workflows(database.url, queue_polling_s=HARDLY_EVER_S)
    workflows.register("note", carried_out.put)
    workflows.register(
        "fail", lambda subject: or_give_up(partial(step, "try", fail_for_good), carried_out.put)
    )
    workflows.launch()
    yield workflows
    workflows.close()


@pytest.mark.parametrize("queue", [PLANNING, MISSIONS])
def test_a_workflow_begins_when_its_transaction_commits_and_not_with_the_next_look(
    database: Database, workflows: Workflows, carried_out: Queue[str], queue: WorkflowQueue
) -> None:
    with database.write() as session:
        workflows.start(session, queue, "note", "first", "one")
    assert carried_out.get(timeout=30) == "one"
    with database.write() as session:
        workflows.start(session, queue, "note", "second", "another")
    assert carried_out.get(timeout=30) == "another"


def test_workflows_that_found_no_place_begin_when_others_end_and_not_with_the_next_look(
    database: Database, workflows: Workflows, carried_out: Queue[str]
) -> None:
    subjects = [f"{n}" for n in range(10 * PLANNING.at_once)]
    for each in subjects:
        with database.write() as session:
            workflows.start(session, PLANNING, "note", f"note-{each}", each)
    assert sorted(carried_out.get(timeout=30) for _ in subjects) == sorted(subjects)


def test_a_workflow_has_ended_once_its_end_is_recorded(
    database: Database, workflows: Workflows, carried_out: Queue[str]
) -> None:
    assert workflows.has_ended("unknown")
    over = threading.Event()
    workflows.register("wait", lambda _: step("wait", lambda: not carried_out.put("begun") and over.wait()))
    with database.write() as session:
        workflows.start(session, MISSIONS, "wait", "first", "one")
    assert not workflows.has_ended("first")
    assert carried_out.get(timeout=30) == "begun"
    assert not workflows.has_ended("first")
    over.set()
    until(lambda: workflows.has_ended("first"))


def test_a_process_that_others_take_for_dead_dequeues_nothing(
    database: Database, carried_out: Queue[str]
) -> None:
    clock, thread = StandingClock(), f"queue {MISSIONS.name}"
    with closing(Workflows(database.url, queue_polling_s=0.02, clock=clock)) as workflows:
        workflows.register("note", carried_out.put)
        workflows.launch()
        workflows.dequeue_until(clock.monotonic_s())
        clock.wait_twice(thread)  # a poll that was about to begin is over
        with database.write() as session:
            workflows.start(session, MISSIONS, "note", "first", "one")
        clock.wait_twice(thread)
        assert carried_out.empty()
        workflows.dequeue_until(clock.monotonic_s() + HARDLY_EVER_S)
        assert carried_out.get(timeout=30) == "one"


def test_a_workflow_of_a_transaction_that_fails_never_begins(
    database: Database, workflows: Workflows, carried_out: Queue[str]
) -> None:
    def fail() -> None:
        with database.write() as session:
            workflows.start(session, PLANNING, "note", "never", "nothing")
            raise LookupError

    with pytest.raises(LookupError):
        fail()
    with database.write() as session:
        workflows.start(session, PLANNING, "note", "after", "something")
    assert carried_out.get(timeout=30) == "something"
    with pytest.raises(Empty):
        carried_out.get_nowait()


def test_one_that_sleeps_ends_with_its_process_and_goes_on_in_the_next(
    database: Database, carried_out: Queue[str]
) -> None:
    def nap(subject: str) -> None:
        step("fall asleep", lambda: carried_out.put("asleep"))
        sleep_until_woken(HARDLY_EVER_S)
        carried_out.put(subject)

    def launched() -> Workflows:
        workflows = Workflows(database.url)
        workflows.register("nap", nap)
        workflows.launch()
        return workflows

    with closing(launched()) as first:
        with database.write() as session:
            first.start(session, MISSIONS, "nap", "mine", "awake")
        assert carried_out.get(timeout=30) == "asleep"
    until(lambda: not [one for one in threading.enumerate() if one.name.startswith("dbos-executor")])

    with closing(launched()) as second:
        if database.shared:
            with psycopg.connect(database.url.replace("+psycopg", ""), autocommit=True) as other:
                other.execute(f"LISTEN {CHANNEL}")
                with database.write() as session:
                    assert second.recover_executor(session, first.executor) == 1
                topics = [
                    one.payload.split()[0] for one in other.notifies(timeout=30, stop_after=len(QUEUES))
                ]
                assert MISSIONS.name in topics
        assert carried_out.get(timeout=30) == "asleep"  # it begins at its first step
        with database.write() as session:
            second.wake(session, "mine")
        assert carried_out.get(timeout=30) == "awake"
    assert carried_out.empty()


def test_a_wake_that_comes_before_the_sleep_ends_it(database: Database, carried_out: Queue[str]) -> None:
    works, goes_on = threading.Event(), threading.Event()

    def nap(subject: str) -> None:
        works.set()
        goes_on.wait()
        sleep_until_woken(HARDLY_EVER_S)
        carried_out.put(subject)

    with closing(Workflows(database.url)) as workflows:
        workflows.register("nap", nap)
        workflows.launch()
        with database.write() as session:
            workflows.start(session, MISSIONS, "nap", "mine", "awake")
        assert works.wait(30)
        with database.write() as session:
            workflows.wake(session, "mine")
        goes_on.set()
        assert carried_out.get(timeout=30) == "awake"


@contextmanager
def sleeping(database: Database, carried_out: Queue[str]) -> Iterator[Workflows]:
    """Workflows of which one, `mine`, sleeps; it says how its sleep ends."""

    def nap(_: str) -> None:
        carried_out.put("asleep")
        try:
            sleep_until_woken(HARDLY_EVER_S)
        except BaseException as ending:
            carried_out.put(type(ending).__name__)
            raise
        carried_out.put("awake")

    with closing(Workflows(database.url)) as workflows:
        workflows.register("nap", nap)
        workflows.launch()
        with database.write() as session:
            workflows.start(session, MISSIONS, "nap", "mine", "anything")
        assert carried_out.get(timeout=30) == "asleep"
        yield workflows


def test_a_run_ends_whose_workflow_another_process_has_taken_over(
    database: Database, carried_out: Queue[str]
) -> None:
    table = "dbos.workflow_status" if database.shared else "workflow_status"
    with sleeping(database, carried_out) as workflows:
        assert workflows.recover_lost() == 0
        with database.write() as session:
            session.execute(text(f"UPDATE {table} SET executor_id = 'another' WHERE workflow_uuid = 'mine'"))
        assert workflows.recover_lost() == 0  # it might just have ended
        assert carried_out.empty()
        assert workflows.recover_lost() == 0
        assert carried_out.get(timeout=30) == "Interrupted"
    with database.read() as session:
        query = text(f"SELECT status, executor_id FROM {table} WHERE workflow_uuid = 'mine'")
        assert tuple(session.execute(query).one()) == ("PENDING", "another")


def test_a_workflow_that_comes_back_to_its_process_has_one_run(
    database: Database, carried_out: Queue[str]
) -> None:
    """As if another process had counted this one as dead, and this one had dequeued the workflow again."""
    if not database.shared:
        return  # there is one process
    with sleeping(database, carried_out) as workflows:
        with database.write() as session:
            assert workflows.recover_executor(session, workflows.executor) == 1
        assert sorted(carried_out.get(timeout=30) for _ in range(2)) == ["Interrupted", "asleep"]
        with database.write() as session:
            workflows.wake(session, "mine")
        assert carried_out.get(timeout=30) == "awake"


def test_a_workflow_is_woken_by_what_another_process_writes(
    database: Database, carried_out: Queue[str]
) -> None:
    if not database.shared:
        return  # there is one process
    with (
        sleeping(database, carried_out) as workflows,
        closing(NotificationListener(database, workflows.topics, wake=workflows.wake_here)) as listener,
        closing(Database(database.url)) as there,
    ):
        listener.start()
        assert (
            carried_out.get(timeout=30) == "awake"
        )  # what was written before it listened may have been missed
        with database.write() as session:
            workflows.start(session, MISSIONS, "nap", "second", "anything")
        assert carried_out.get(timeout=30) == "asleep"
        with there.write() as session:
            announce(session, f"{WAKE}:second")
        assert carried_out.get(timeout=30) == "awake"


def test_a_workflow_that_was_lost_between_its_queue_and_the_process_is_recovered(
    database: Database, workflows: Workflows, carried_out: Queue[str]
) -> None:
    """As when the database dies after it has recorded who has the workflow, and before it has said so."""
    with database.write() as session:
        never_served = WorkflowQueue(name="nobody's", at_once=1)
        workflows.start(session, never_served, "note", "lost", "something")
        table = "dbos.workflow_status" if database.shared else "workflow_status"
        taken = (
            "SET status = 'PENDING', executor_id = :me, queue_name = 'missions' WHERE workflow_uuid = 'lost'"
        )
        session.execute(text(f"UPDATE {table} {taken}"), {"me": workflows.executor})
    assert workflows.recover_lost() == 0  # it might just be on its way
    assert workflows.recover_lost() == 1
    assert carried_out.get(timeout=30) == "something"
    assert workflows.recover_lost() == 0


def test_a_workflow_whose_step_keeps_failing_gives_up_with_the_reason(
    database: Database, workflows: Workflows, carried_out: Queue[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.workflows.steps.STEP_ATTEMPTS", 2)
    with database.write() as session:
        workflows.start(session, PLANNING, "fail", "first", "anything")
    assert "step 'try' failed 2 times" in carried_out.get(timeout=30)
