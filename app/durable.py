"""Durable workflows: the one module that knows DBOS.

The domain tables are the record; a workflow is the mechanism that carries a goal or a mission on, also after a crash.
A workflow and a message to it are started inside the transaction that makes them necessary, so neither can be lost.
"""

import logging
import threading
import uuid
from collections.abc import Callable, Collection
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any

from dbos import DBOS, DBOSClient, DBOSConfig, DBOSPortableJSONSerializer, EnqueueOptions
from dbos import error as dbos_error
from dbos._queue import queue_worker_thread
from sqlalchemy.orm import Session

from app.database import after_commit, announce, is_away

APPLICATION = "macta"
APPLICATION_VERSION = "1"
"""Raised when a workflow's steps change order, so that no old workflow is replayed by new code."""

WAKE = "wake"
STEP_ATTEMPTS = 4
POLLING_S = 0.05
SELDOM_S = 0.25
"""How often queues are looked at: every process is told of new work, and every 50 ms kept a sixth of a core busy."""
AWAY_S = 0.5
"""Pause before a step that found the database away is tried again."""
EMBEDDED = "embedded"

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Queue:
    """Where workflows of one kind wait for an executor; `at_once` is how many run in one process."""

    name: str
    at_once: int


PLANNING = Queue(name="planning", at_once=4)
WAITING = Queue(name="waiting", at_once=1)
MISSIONS = Queue(name="missions", at_once=1000)
QUEUES = (PLANNING, WAITING, MISSIONS)


_CLOSING: ContextVar[threading.Event] = ContextVar("closing")
"""Inside a workflow: set once the process ends."""


class Workflows:
    """Registers, starts, wakes and runs workflows. One instance a process at a time, for DBOS is a singleton."""

    def __init__(
        self,
        database_url: str,
        *,
        serves: Collection[Queue] = QUEUES,
        queue_polling_s: float = SELDOM_S,
    ) -> None:
        """
        :param serves: the queues whose workflows this process runs.
        :param queue_polling_s: how often to look for workflows that nobody told of.
        """
        self._url, self._serves, self._queue_polling_s = database_url, serves, queue_polling_s
        # A process that died left its workflows under its own name; the embedded service is one executor.
        self.executor = EMBEDDED if database_url.startswith("sqlite") else uuid.uuid4().hex
        self._closing = threading.Event()
        self._client: DBOSClient | None = None
        self._dbos = DBOS(config=self._config())
        DBOS.listen_queues([])  # we do, see `_Listener`
        self._listeners: dict[str, _Listener] = {}

    def _config(self) -> DBOSConfig:
        return {
            "name": APPLICATION,
            "system_database_url": self._url,
            "application_version": APPLICATION_VERSION,
            "executor_id": self.executor,
            "serializer": DBOSPortableJSONSerializer(),
            "notification_listener_polling_interval_sec": POLLING_S,
            "log_level": "ERROR",
            "console_log_level": "ERROR",
        }

    def register(self, name: str, function: Callable[[str], None]) -> None:
        """Make a workflow known under a name. Every process registers every workflow before `launch`."""

        def workflow(subject: str) -> None:  # DBOS marks what it registers; a bound method cannot be marked
            _CLOSING.set(self._closing)
            function(subject)

        DBOS.workflow(name=name)(workflow)

    def launch(self) -> None:
        """Start executing: first what an earlier process left undone."""
        DBOS.launch()
        for queue in QUEUES:
            known = DBOS.register_queue(
                queue.name, worker_concurrency=queue.at_once, polling_interval_sec=self._queue_polling_s
            )
            if queue in self._serves:
                self._listeners[queue.name] = _Listener(self._dbos, known)
        self._client = DBOSClient(
            system_database_url=self._url,
            serializer=DBOSPortableJSONSerializer(),
            application_name=APPLICATION,
        )

    def start(self, session: Session, queue: Queue, name: str, workflow_id: str, subject: str) -> None:
        """Enqueue a workflow on one subject; it exists exactly if the caller's transaction commits."""
        options: EnqueueOptions = {
            "workflow_name": name,
            "queue_name": queue.name,
            "workflow_id": workflow_id,
            "app_version": APPLICATION_VERSION,
        }
        self._connected.enqueue_in_transaction(session, options, subject)
        after_commit(session, lambda: self.look(queue))
        announce(session, queue.name)

    def look(self, queue: Queue) -> None:
        """A workflow of this queue was started, here or in another process."""
        if queue.name in self._listeners:
            self._listeners[queue.name].look()

    def rouse(self) -> None:
        """Have every workflow that waits here look whether there is a message: it may not have been told of one.

        DBOS looks by itself only once a minute.
        """
        for _, _, waiting in self._dbos._sys_db.notifications_map.snapshot():
            waiting.set()

    def take_over(self, executor: str) -> int:
        """Have what another executor left undone run again, by whoever serves its queues; answers how many.

        Only what is still that executor's: a workflow that was taken over already is left alone.
        """
        return len(DBOS._recover_pending_workflows([executor]))

    def wake(self, session: Session, workflow_id: str, key: str) -> None:
        """Send a waiting workflow a message, once per key, if the caller's transaction commits."""
        self._connected.send_in_transaction(session, workflow_id, key, WAKE, key)

    def forget(self, before: str, most: int) -> int:
        """Delete workflows that were over before an instant (ISO 8601), so many at most; answers how many."""
        over = self._connected.list_workflows(
            status=["SUCCESS", "ERROR", "CANCELLED"],
            completed_before=before,
            limit=most,
            load_input=False,
            load_output=False,
        )
        self._connected.delete_workflows([one.workflow_id for one in over])
        return len(over)

    @property
    def _connected(self) -> DBOSClient:
        if self._client is None:
            raise RuntimeError("launch() comes before start() and wake()")
        return self._client

    def close(self) -> None:
        """Stop executing. What is under way is left as it is and taken up by the next `launch`."""
        # Workflows that are cut off complain that the database is gone; they are meant to be.
        logging.getLogger("dbos").setLevel(logging.CRITICAL)
        self._closing.set()
        if self._client is not None:
            # Those that sleep need not look for the database for ever once they wake.
            self._dbos._sys_db._retry_connection_errors = False
        for listener in self._listeners.values():
            listener.end()
        if self._client is not None:
            self._client.destroy()
        DBOS.destroy(destroy_registry=True)


class _Listener:
    """Takes the workflows of one queue in this process. DBOS looks every so often; this looks also when it is told that
    there is one, which saves a goal half a poll."""

    def __init__(self, dbos: DBOS, queue: Any) -> None:
        self._pause = _Pause()
        self._thread = threading.Thread(
            target=queue_worker_thread,
            args=(self._pause, dbos, queue),
            name=f"queue {queue.name}",
            daemon=True,
        )
        self._thread.start()

    def look(self) -> None:
        """Look now."""
        self._pause.cut_short()

    def end(self) -> None:
        self._pause.set()
        self._thread.join()


class _Pause(threading.Event):
    """Between two looks: set at the end, and can be cut short."""

    def __init__(self) -> None:
        super().__init__()
        self._over = threading.Event()

    def cut_short(self) -> None:
        self._over.set()

    def set(self) -> None:
        super().set()
        self._over.set()

    def wait(self, timeout: float | None = None) -> bool:
        """Until it is set, cut short or over; True if it is set."""
        self._over.wait(timeout)
        self._over.clear()
        return self.is_set()


class StepFailed(Exception):
    """Raised when a step has failed as often as it is tried; the message says which and why."""


def step(name: str, function: Callable[[], Any]) -> Any:
    """Run a step of the current workflow: its result, JSON data, is kept and not computed again on replay.

    A step that fails is tried again a few times, ever later; while the database is away, as often as it takes.

    :raises StepFailed: if it failed every time.
    """

    def logged() -> Any:
        while True:
            try:
                return function()
            except Exception as error:
                if not is_away(error):
                    logger.exception("step %r failed", name)
                    raise
                logger.warning("step %r waits for the database: %s", name, error)
                if _CLOSING.get().wait(AWAY_S):
                    raise

    try:
        return DBOS.run_step(
            {"name": name, "retries_allowed": True, "interval_seconds": 0.5, "max_attempts": STEP_ATTEMPTS},
            logged,
        )
    except dbos_error.DBOSMaxStepRetriesExceeded as error:
        raise StepFailed(f"step {name!r} failed {STEP_ATTEMPTS} times; the log says why") from error


def or_give_up(work: Callable[[], None], give_up: Callable[[str], None]) -> None:
    """Take a workflow's steps; if one keeps failing, the step that gives up, with the reason, in place of the rest."""
    try:
        work()
    except StepFailed as failure:
        reason = str(failure)
        step("give up", lambda: give_up(reason))


def sleep_until_woken(timeout_s: float) -> None:
    """Wait inside a workflow for a message on `WAKE`, `timeout_s` at most; the instant it ends at is durable."""
    DBOS.recv(WAKE, timeout_seconds=timeout_s)
