"""Contracts of DBOS's private names: what breaks in the service if a new version of DBOS changes one of them."""

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from dbos import DBOS, DBOSPortableJSONSerializer, EnqueueOptions, Queue, _workflow_commands
from sqlalchemy import create_engine, event

from app.workflows import dbos_internals
from tests.waiting import until

HARDLY_EVER_S = 3600.0
EXECUTOR = "contract"


class Worker(threading.Event):
    """A queue's worker and its stop event, which counts its waits and returns from each at once."""

    def __init__(self, dbos: DBOS, queue: Queue) -> None:
        super().__init__()
        self.waits_s: list[float | None] = []
        self._thread = threading.Thread(
            target=dbos_internals.work_queue, args=(dbos, queue, self), daemon=True
        )
        self._thread.start()

    def wait(self, timeout: float | None = None) -> bool:
        self.waits_s.append(timeout)
        return self.is_set()

    def stop(self) -> None:
        """No workflow is dequeued after this returns: a poll under way has ended."""
        self.set()
        self._thread.join(timeout=30)
        assert not self._thread.is_alive(), "a worker that does not end holds up the service's shutdown"


@pytest.fixture
def dbos(tmp_path: Path) -> Iterator[DBOS]:
    dbos = DBOS(
        config={
            "name": "contract",
            "system_database_url": f"sqlite:///{tmp_path / 'dbos.sqlite'}",
            "application_version": "1",
            "executor_id": EXECUTOR,
            "serializer": DBOSPortableJSONSerializer(),
            "notification_listener_polling_interval_sec": 0.05,
            "console_log_level": "CRITICAL",
        }
    )
    DBOS.listen_queues([])

    @DBOS.workflow(name="wait")
    def wait(subject: str) -> str:
        return subject + str(DBOS.recv("topic", timeout_seconds=HARDLY_EVER_S))

    DBOS.launch()
    yield dbos
    DBOS.destroy(destroy_registry=True)


def test_how_often_dbos_looks_for_what_there_is_none_of_can_be_set(tmp_path: Path) -> None:
    """Else the idle service polls five times as often, which `poll_seldom` would do nothing about."""
    engine = create_engine(f"sqlite:///{tmp_path / 'dbos.sqlite'}")
    own, delayed = [], []

    @event.listens_for(engine, "before_cursor_execute")
    def count(connection: object, cursor: object, statement: str, parameters: object, *_: object) -> None:
        if "_dbos_internal_queue" in str(parameters):
            own.append(statement)
        if statement.startswith("UPDATE") and "delay_until_epoch_ms" in statement:
            delayed.append(statement)

    before_s = _workflow_commands._BACKGROUND_JOBS_INTERVAL_SEC
    dbos = DBOS(
        config={"name": "contract", "system_database_engine": engine, "console_log_level": "CRITICAL"}
    )
    dbos_internals.poll_seldom(dbos, 0.02)
    try:
        DBOS.launch()
        until(lambda: len(own) > 20 and len(delayed) > 20, "polls are a second apart", within_s=10)
    finally:
        DBOS.destroy(destroy_registry=True)
        _workflow_commands._BACKGROUND_JOBS_INTERVAL_SEC = before_s


@pytest.fixture
def queue(dbos: DBOS) -> Queue:
    return DBOS.register_queue("work", polling_interval_sec=0.25)


@pytest.fixture
def worker(dbos: DBOS, queue: Queue) -> Iterator[Worker]:
    """The queue's worker runs until it is stopped; its workflows are dequeued here."""
    worker = Worker(dbos, queue)
    yield worker
    worker.stop()
    left = [one.workflow_id for one in DBOS.list_workflows(status=["PENDING", "ENQUEUED"])]
    DBOS.cancel_workflows(left)
    for one in left:
        DBOS.send(one, "end", "topic")
    until(lambda: not dbos_internals.executing_workflows(dbos))


def wait_for_message(name: str) -> None:
    """Have a workflow run here and wait for a message."""
    options: EnqueueOptions = {"queue_name": "work", "workflow_id": name, "workflow_name": "wait"}
    DBOS.enqueue_workflow_with_options(options, "heard ")
    until(lambda: [step for step in DBOS.list_workflow_steps(name) if step["function_name"] == "DBOS.sleep"])


def test_a_queues_worker_pauses_on_its_stop_event_between_polls(worker: Worker) -> None:
    """Else `PollPause` could neither hasten a poll nor hold one back: workflows start late, or in a dead process."""
    until(lambda: len(worker.waits_s) > 2)
    assert all(0.2 < (waited_s or 0.0) < 0.3 for waited_s in worker.waits_s)
    wait_for_message("dequeued")


def test_a_workflow_counts_as_executing_until_its_outcome_is_recorded(dbos: DBOS, worker: Worker) -> None:
    """Else `Workflows.recover_lost` would run healthy workflows twice, or leave lost ones pending for ever."""
    wait_for_message("mine")
    assert dbos_internals.executing_workflows(dbos) == {"mine"}
    DBOS.send("mine", "this", "topic")
    assert DBOS.retrieve_workflow("mine").get_result() == "heard this"
    until(lambda: not dbos_internals.executing_workflows(dbos))


def test_a_workflow_has_a_place_of_its_queue_until_its_outcome_is_recorded(
    dbos: DBOS, worker: Worker
) -> None:
    """Else workflows that wait for a place begin up to a second late."""
    wait_for_message("mine")
    assert dbos_internals.queue_of(dbos, "mine") == "work"
    assert dbos_internals.running_in(dbos, "work") == 1
    assert dbos_internals.running_in(dbos, "another") == 0
    DBOS.send("mine", "this", "topic")
    assert DBOS.retrieve_workflow("mine").get_result() == "heard this"
    until(lambda: dbos_internals.queue_of(dbos, "mine") is None)
    assert dbos_internals.running_in(dbos, "work") == 0


def test_only_a_pending_workflow_of_the_named_executor_is_enqueued_again(dbos: DBOS, worker: Worker) -> None:
    """Else two processes that recover the same workflow would both run it."""
    wait_for_message("mine")
    worker.stop()
    assert not dbos_internals.reenqueue(dbos, "mine", executor="another", default_queue="work")
    assert dbos_internals.reenqueue(dbos, "mine", executor=EXECUTOR, default_queue="work")
    status = DBOS.get_workflow_status("mine")
    assert status is not None
    assert (status.status, status.queue_name) == ("ENQUEUED", "work")
    assert not dbos_internals.reenqueue(dbos, "mine", executor=EXECUTOR, default_queue="work")


def test_the_poller_for_messages_is_one_thread_that_ends_by_itself(dbos: DBOS) -> None:
    (poller,) = dbos_internals.leave_message_poller(dbos)
    assert poller.is_alive()
    DBOS.destroy()
    poller.join(timeout=30)
    assert not poller.is_alive()
