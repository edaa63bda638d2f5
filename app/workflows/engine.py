"""Starts, wakes and runs workflows, and has those run again that a process left or lost."""

import logging
import sqlite3
import threading
import time
import uuid
from collections.abc import Callable, Collection, Mapping
from functools import partial
from math import inf

from dbos import DBOS, DBOSClient, DBOSConfig, DBOSPortableJSONSerializer, EnqueueOptions
from dbos._sys_db import SystemDatabase
from sqlalchemy import ExceptionContext, event
from sqlalchemy.orm import Session

from app.store import after_commit, announce, is_unwritable
from app.workflows.queue_listener import Listener
from app.workflows.queues import MISSIONS, QUEUES, Queue
from app.workflows.steps import CLOSING, WAKE

APPLICATION = "macta"
APPLICATION_VERSION = "2"
"""Raised when a workflow's steps change order, so that no old workflow is replayed by new code."""

POLLING_S = 0.05
SELDOM_S = 0.25
"""How often queues are looked at while there is work: every process is told of new work, and every 50 ms kept a sixth
of a core busy."""
EMBEDDED = "embedded"


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
        self._suspected: set[str] = set()
        self._begins_until = inf
        self._client: DBOSClient | None = None
        self._dbos = DBOS(config=self._config())
        DBOS.listen_queues([])  # we do, see `Listener`
        self._listeners: dict[str, Listener] = {}

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
            CLOSING.set(self._closing)
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
                self._listeners[queue.name] = Listener(
                    self._dbos, known, may_take=lambda: time.monotonic() < self._begins_until
                )
        self._client = DBOSClient(
            system_database_url=self._url,
            serializer=DBOSPortableJSONSerializer(),
            application_name=APPLICATION,
        )
        event.listen(self._dbos._sys_db.engine, "handle_error", _as_locked)

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

    @property
    def topics(self) -> Mapping[str, Callable[[], None]]:
        """What this process is to be told of by others on its database, and what it does then."""
        return {queue.name: partial(self.look, queue) for queue in self._serves} | {"messages": self.rouse}

    def look(self, queue: Queue) -> None:
        """A workflow of this queue was started, here or in another process."""
        if queue.name in self._listeners:
            self._listeners[queue.name].look()

    def may_begin(self, until: float) -> None:
        """From then on (`time.monotonic`) nothing is taken from the queues, unless another instant is named before.

        Whoever takes this process for dead would have what it takes run again at once, and so without end.
        """
        self._begins_until = until

    def rouse(self) -> None:
        """Have every workflow that waits here look whether there is a message: it may not have been told of one.

        DBOS looks by itself only once a minute.
        """
        _rouse(self._dbos._sys_db)

    def take_over(self, executor: str) -> int:
        """Have what another executor left undone run again, by whoever serves its queues; answers how many.

        Only what is still that executor's: a workflow that was taken over already is left alone.
        """
        count = len(DBOS._recover_pending_workflows([executor]))
        self._look_at_all(count)
        return count

    def take_up(self) -> int:
        """Have what this process took from a queue and then lost run again; answers how many. To be called often.

        A database that dies may have recorded that a workflow is ours and not have come to say so. What is not executed
        here though it is ours at two calls in a row is such a one: whatever is just being taken is executed by then.
        """
        running = set(self._dbos._active_workflows_set.activeList())
        mine = self._connected.list_workflows(
            status="PENDING", executor_id=self.executor, load_input=False, load_output=False
        )
        unclaimed = {one.workflow_id for one in mine} - running
        lost, self._suspected = unclaimed & self._suspected, unclaimed
        system = self._dbos._sys_db
        count = sum(system.reenqueue_for_recovery(one, [self.executor], MISSIONS.name) for one in lost)
        self._look_at_all(count)
        return count

    def _look_at_all(self, count: int) -> None:
        """So many workflows are to run again, of whatever queues."""
        for listener in self._listeners.values() if count else ():
            listener.look()

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
        for listener in self._listeners.values():
            listener.end()
        if self._client is None:
            DBOS.destroy(destroy_registry=True)
            return
        system = self._dbos._sys_db
        # Those that sleep need not look for the database for ever once they wake.
        system._retry_connection_errors = False
        self._client.destroy()
        DBOS.destroy(destroy_registry=True)
        # A thread that slept on would hold up the process's end, and one that woke later would go on beside whoever
        # has taken the workflow up: they wake now, and without a connection they can record nothing.
        event.listen(system.engine, "do_connect", _refused)
        _rouse(system)


def _rouse(system: SystemDatabase) -> None:
    for _, _, waiting in system.notifications_map.snapshot():
        waiting.set()


def _refused(*_: object) -> None:
    """:raises RuntimeError: always: there are no connections any more."""
    raise RuntimeError("the service has ended")


def _as_locked(context: ExceptionContext) -> None:
    """What cannot be written for now is tried again, as what is locked is: DBOS would give the workflow up.

    :raises sqlite3.OperationalError: in place of SQLite's words for a full disk.
    """
    error = context.original_exception
    if isinstance(error, sqlite3.Error) and is_unwritable(error):
        raise sqlite3.OperationalError(f"database is locked: {error}") from error
