"""Starts, wakes and runs workflows, and recovers those of ended processes and lost ones."""

import logging
import threading
import uuid
from collections.abc import Callable, Collection, Mapping
from functools import partial
from math import inf

from dbos import DBOS, DBOSClient, DBOSConfig, DBOSPortableJSONSerializer, EnqueueOptions
from sqlalchemy.orm import Session

from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.store import after_commit, announce
from app.workflows.dbos_internals import (
    executing_workflows,
    leave_message_poller,
    poll_seldom,
    queue_of,
    reenqueue,
)
from app.workflows.queue_listener import BUSY_POLLING_S, QueueListener
from app.workflows.queues import MISSIONS, QUEUES, Queue
from app.workflows.steps import CURRENT_RUN, Run
from app.workflows.system_database import create_system_engine, retire

APPLICATION = "macta"
APPLICATION_VERSION = "2"
"""Increased when workflows of an earlier version must not be run by this one: no process recovers them then."""

UNUSED_POLLING_S = 4.0
"""Interval at which DBOS looks for kinds of workflows that there are none of. The lock that it holds meanwhile on
PostgreSQL is taken from it after 5 s."""
WAKE = "wake"
"""The topic of the announcement that wakes a workflow of another process, before its id."""
QUEUE_POLLING_S = 0.25
"""Polling interval of queues while there is work, if several processes take work from them and may get into each
other's way: every process is notified of new work, and polling every 50 ms kept a sixth of a core busy."""
EMBEDDED = "embedded"


class Workflows:
    """Registers, starts, wakes and runs workflows. One instance per process at a time, because DBOS is a singleton."""

    def __init__(
        self,
        database_url: str,
        *,
        serves: Collection[Queue] = QUEUES,
        queue_polling_s: float | None = None,
        clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """
        :param serves: the queues whose workflows this process runs.
        :param queue_polling_s: polling interval for workflows that were not announced; None: `QUEUE_POLLING_S`, or
            `BUSY_POLLING_S` where no other process takes any.
        """
        self.engine = create_system_engine(database_url)
        """The connections of DBOS."""
        self._serves = serves
        self._clock = clock
        # Workflows of an ended process are recovered by its executor id; the embedded service has always the same.
        is_alone = database_url.startswith("sqlite")
        self.executor = EMBEDDED if is_alone else uuid.uuid4().hex
        usual_s = BUSY_POLLING_S if is_alone else QUEUE_POLLING_S
        self._queue_polling_s = usual_s if queue_polling_s is None else queue_polling_s
        self._is_closing = False
        self._runs: dict[str, Run] = {}
        self._suspected: set[str] = set()
        self._perhaps_taken: set[str] = set()
        self._lock = threading.Lock()
        self._dequeues_until = inf
        self._client: DBOSClient | None = None
        self._dbos = DBOS(config=self._config())
        DBOS.listen_queues([])  # `QueueListener` does
        self._listeners: dict[str, QueueListener] = {}

    def _config(self) -> DBOSConfig:
        return {
            "name": APPLICATION,
            "system_database_engine": self.engine,
            "application_version": APPLICATION_VERSION,
            "executor_id": self.executor,
            "serializer": DBOSPortableJSONSerializer(),
            "notification_listener_polling_interval_sec": UNUSED_POLLING_S,
            "log_level": "ERROR",
            "console_log_level": "ERROR",
        }

    def register(self, name: str, function: Callable[[str], None]) -> None:
        """Register a workflow under a name. Every process registers every workflow before `launch`."""

        def workflow(subject: str) -> None:  # DBOS marks what it registers; a bound method cannot be marked
            assert DBOS.workflow_id is not None
            run = Run(DBOS.workflow_id)
            CURRENT_RUN.set(run)
            with self._lock:
                # One that another process had taken over, and that came back here.
                earlier = self._runs.get(DBOS.workflow_id)
                self._runs[DBOS.workflow_id] = run
                if self._is_closing:
                    run.interrupt()
            if earlier is not None:
                earlier.interrupt()
            try:
                function(subject)
            finally:
                with self._lock:
                    if self._runs.get(DBOS.workflow_id) is run:
                        del self._runs[DBOS.workflow_id]
                self._poll_after(run.workflow_id)

        DBOS.workflow(name=name)(workflow)

    def launch(self) -> None:
        """Start executing workflows, first those that an earlier process left pending."""
        poll_seldom(self._dbos, UNUSED_POLLING_S)
        DBOS.launch()
        for queue in QUEUES:
            registered = DBOS.register_queue(
                queue.name, worker_concurrency=queue.at_once, polling_interval_sec=self._queue_polling_s
            )
            registered.database_backed_queue = False  # its settings never change, so no poll reads them again
            if queue in self._serves:
                self._listeners[queue.name] = QueueListener(
                    self._dbos,
                    registered,
                    waits=queue.waits,
                    may_dequeue=self._may_dequeue,
                    clock=self._clock,
                )
        self._client = DBOSClient(
            system_database_engine=self.engine,
            serializer=DBOSPortableJSONSerializer(),
            application_name=APPLICATION,
        )

    def start(
        self,
        session: Session,
        queue: Queue,
        name: str,
        workflow_id: str,
        subject: str,
        *,
        rank: int | None = None,
    ) -> None:
        """Enqueue a workflow on one subject; it exists exactly if the caller's transaction commits.

        :param rank: 1 to 2147483647; of a queue's workflows the one with the lowest is run first, those without a rank
            before.
        """
        options: EnqueueOptions = {
            "workflow_name": name,
            "queue_name": queue.name,
            "workflow_id": workflow_id,
            "app_version": APPLICATION_VERSION,
        }
        if rank is not None:
            options["priority"] = rank
        self._connected.enqueue_in_transaction(session, options, subject)
        after_commit(session, lambda: self.poll(queue))
        announce(session, queue.name)

    def has_ended(self, workflow_id: str) -> bool:
        """True if a workflow has ended, however it did, or if there is none of that id."""
        found = self._connected.list_workflows(
            workflow_ids=[workflow_id], load_input=False, load_output=False
        )
        return all(one.status not in ("ENQUEUED", "PENDING") for one in found)

    @property
    def topics(self) -> Mapping[str, Callable[[], None]]:
        """The topics of other processes' announcements that this one handles, each with its handler."""
        return {queue.name: partial(self.poll, queue) for queue in self._serves}

    def poll(self, queue: Queue) -> None:
        """Poll this queue now: a workflow was started, here or in another process."""
        if queue.name in self._listeners:
            self._listeners[queue.name].poll_now()

    def dequeue_until(self, monotonic_s: float) -> None:
        """Dequeue nothing after this instant, unless it is moved before.

        After it, other processes may count this one as dead and run again what it dequeues.
        """
        was_held_back = not self._may_dequeue()
        self._dequeues_until = monotonic_s
        if was_held_back:
            self._poll_all()

    def wake_here(self, workflow_id: str | None = None) -> None:
        """Wake the workflow, if it runs in this process; None: all that do, for their wake may have been lost."""
        with self._lock:
            runs = [*self._runs.values()] if workflow_id is None else [self._runs.get(workflow_id)]
        for run in runs:
            if run is not None:
                run.wake()

    def recover_executor(self, session: Session, executor: str) -> int:
        """Put back into their queues the workflows that another executor left pending; returns their number.

        The processes that serve the queues are notified when the session's transaction commits.
        """
        count = self._reenqueue(self._pending(executor), executor)
        if count:
            for queue in QUEUES:
                announce(session, queue.name)
        return count

    def recover_lost(self) -> int:
        """Put back into their queues this process's pending workflows that it does not execute; returns their number.

        A workflow is lost if the database fails after it has committed a dequeue and before it has answered. One that
        is being dequeued looks the same, so only those found at two calls in a row count: call this periodically.
        Likewise the runs of workflows end that another process has taken over, because it counted this one as dead.
        """
        pending = self._pending(self.executor)
        unclaimed = pending - executing_workflows(self._dbos)
        lost = unclaimed & self._suspected
        with self._lock:
            not_ours = self._runs.keys() - pending
            taken = [self._runs[one] for one in not_ours & self._perhaps_taken]
        self._perhaps_taken = not_ours
        for run in taken:
            run.interrupt()
        self._suspected = unclaimed
        return self._reenqueue(lost, self.executor)

    def _pending(self, executor: str) -> set[str]:
        found = self._connected.list_workflows(
            status="PENDING",
            executor_id=executor,
            app_version=APPLICATION_VERSION,
            load_input=False,
            load_output=False,
        )
        return {one.workflow_id for one in found}

    def _reenqueue(self, workflow_ids: Collection[str], executor: str) -> int:
        count = sum(
            reenqueue(self._dbos, one, executor=executor, default_queue=MISSIONS.name) for one in workflow_ids
        )
        if count:
            self._poll_all()
        return count

    def _poll_all(self) -> None:
        for listener in self._listeners.values():
            listener.poll_now()

    def _poll_after(self, workflow_id: str) -> None:
        """Poll the queue of a workflow whose function returns once its end is recorded: another may wait for its place.

        Whether one does is only known to the database. That the queue is not full now does not tell: the poll after the
        end before may have had room for one of two that wait.
        """
        name = queue_of(self._dbos, workflow_id)
        if name in self._listeners:
            self._listeners[name].poll_after(workflow_id)

    def _may_dequeue(self) -> bool:
        return self._clock.monotonic_s() < self._dequeues_until

    def wake(self, session: Session, workflow_id: str) -> None:
        """End a workflow's sleep, or its next one, in its process, if the caller's transaction commits."""
        after_commit(session, partial(self.wake_here, workflow_id))
        announce(session, f"{WAKE}:{workflow_id}")

    def delete_finished(self, before: str, limit: int) -> int:
        """Delete up to `limit` workflows that ended before an instant (ISO 8601); returns their number."""
        over = self._connected.list_workflows(
            status=["SUCCESS", "ERROR", "CANCELLED"],
            completed_before=before,
            limit=limit,
            load_input=False,
            load_output=False,
        )
        self._connected.delete_workflows([one.workflow_id for one in over])
        return len(over)

    @property
    def _connected(self) -> DBOSClient:
        if self._client is None:
            raise RuntimeError("launch() comes before start()")
        return self._client

    def close(self) -> None:
        """Stop executing. Running workflows stay pending and are recovered by the next `launch`."""
        # Interrupted workflows would log that the database is closed.
        logging.getLogger("dbos").setLevel(logging.CRITICAL)
        with self._lock:
            self._is_closing = True
            runs = [*self._runs.values()]
        for run in runs:
            run.interrupt()
        for listener in self._listeners.values():
            listener.stop()
        if self._client is not None:
            self._client.destroy()
            if self.executor == EMBEDDED:
                leave_message_poller(self._dbos)
        DBOS.destroy(destroy_registry=True)
        # A step that is under way may end after another process has recovered its workflow: without a connection it
        # records no outcome.
        retire(self.engine)
