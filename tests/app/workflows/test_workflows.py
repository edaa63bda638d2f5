"""Durable workflows: begun when the transaction that starts them commits."""

import threading
import time
from collections.abc import Iterator
from functools import partial
from queue import Empty, Queue

import pytest
from sqlalchemy import text

from app.store import Database
from app.workflows import MISSIONS, PLANNING, Workflows, or_give_up, sleep_until_woken, step
from app.workflows import Queue as WorkflowQueue
from tests.databases import ON_BOTH
from tests.waiting import until

pytestmark = ON_BOTH
HARDLY_EVER_S = 3600.0


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


def test_a_process_that_others_take_for_dead_begins_nothing(
    database: Database, carried_out: Queue[str]
) -> None:
    workflows = Workflows(database.url, queue_polling_s=0.02)
    workflows.register("note", carried_out.put)
    workflows.launch()
    workflows.may_begin(time.monotonic())
    with database.write() as session:
        workflows.start(session, MISSIONS, "note", "first", "one")
    with pytest.raises(Empty):
        carried_out.get(timeout=0.5)
    workflows.may_begin(time.monotonic() + 3600)
    assert carried_out.get(timeout=30) == "one"
    workflows.close()


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

    first = launched()
    with database.write() as session:
        first.start(session, MISSIONS, "nap", "mine", "awake")
    assert carried_out.get(timeout=30) == "asleep"
    until(first._dbos._sys_db.notifications_map.snapshot, "it never sleeps")
    first.close()
    until(lambda: not [one for one in threading.enumerate() if one.name.startswith("dbos-executor")])

    second = launched()
    if database.shared:
        assert second.take_over(first.executor) == 1
    with database.write() as session:
        second.wake(session, "mine", "a message")
    assert carried_out.get(timeout=30) == "awake"
    second.close()
    assert carried_out.empty()


def test_a_workflow_that_was_lost_between_its_queue_and_the_process_is_taken_up(
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
    assert workflows.take_up() == 0  # it might just be on its way
    assert workflows.take_up() == 1
    assert carried_out.get(timeout=30) == "something"
    assert workflows.take_up() == 0


def test_a_workflow_whose_step_keeps_failing_gives_up_with_the_reason(
    database: Database, workflows: Workflows, carried_out: Queue[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.workflows.steps.STEP_ATTEMPTS", 2)
    with database.write() as session:
        workflows.start(session, PLANNING, "fail", "first", "anything")
    assert "step 'try' failed 2 times" in carried_out.get(timeout=30)
