"""The private names of DBOS (3.4) that this service depends on, one function per use.

No other module uses a private name of DBOS. `tests/app/workflows/test_dbos_internals.py` has a contract test for each
function: with a new minor version of DBOS, those tests show which use has to change, and only this module does.
"""

import threading

from dbos import DBOS, Queue, _workflow_commands
from dbos._queue import queue_worker_thread


def work_queue(dbos: DBOS, queue: Queue, stop_event: threading.Event) -> None:
    """Dequeue and start workflows of one queue until `stop_event` is set. Blocks.

    Between polls it calls `stop_event.wait(timeout=…)`, so an event that returns early makes it poll at once. The
    public `DBOS.listen_queues` polls at a fixed interval: a new workflow would wait for half of it on average, and
    could not be left to other executors while this process may count as dead.
    """
    queue_worker_thread(stop_event, dbos, queue)


def poll_seldom(dbos: DBOS, interval_s: float) -> None:
    """Have DBOS look at this interval, not each second, for what this service has none of. Before `DBOS.launch`.

    That is workflows in DBOS's own queue, and those that are delayed or have a time limit. It has no setting for them.
    """
    dbos._registry.get_internal_queue()._polling_interval_sec = interval_s
    _workflow_commands._BACKGROUND_JOBS_INTERVAL_SEC = interval_s


def executing_workflows(dbos: DBOS) -> set[str]:
    """The ids of the workflows that run in this process, from being dequeued until their outcome is recorded.

    The public `list_workflows` returns the executor's workflows by the database, which differ after a lost commit.
    """
    return set(dbos._active_workflows_set.activeList())


def queue_of(dbos: DBOS, workflow_id: str) -> str | None:
    """The queue that a workflow was dequeued from which runs in this process; None once its outcome is recorded.

    Until then it has one of the places of its queue. The public `get_workflow_status` reads it from the database.
    """
    active = dbos._active_workflows_set
    with active._lock:
        queues = [bucket[0] for bucket in active._m.get(workflow_id, ()) if bucket is not None]
    return queues[-1] if queues else None


def running_in(dbos: DBOS, queue: str) -> int:
    """How many workflows of a queue run in this process, as DBOS counts them when it looks whether there is room."""
    return dbos._active_workflows_set.count_for_queue(queue)


def reenqueue(dbos: DBOS, workflow_id: str, *, executor: str, default_queue: str) -> bool:
    """Put a pending workflow back into its queue, if it is still that executor's; True if it was.

    The public `resume_workflow` does not check the executor: it would start a second run of a workflow that another
    process has taken over meanwhile.
    """
    return dbos._sys_db.reenqueue_for_recovery(workflow_id, [executor], default_queue)


def leave_message_poller(dbos: DBOS) -> list[threading.Thread]:
    """Have `DBOS.destroy` not wait for the thread that polls for messages on SQLite; returns that one thread.

    It sleeps for a polling interval and cannot be woken; then it ends by itself, since it finds the engine retired. The
    public `DBOS.destroy` waits for it, half an interval on average.
    """
    poll = dbos._sys_db.run_notification_listener
    left = [thread for thread in dbos._background_threads if getattr(thread, "_target", None) == poll]
    for thread in left:
        dbos._background_threads.remove(thread)
    return left
