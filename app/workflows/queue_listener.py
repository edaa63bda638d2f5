"""Dequeues workflows as soon as there are any."""

import threading
from collections.abc import Callable

from dbos import DBOS, Queue

from app.domain.clock import WallClock
from app.workflows.dbos_internals import work_queue

ROOM_S = 0.02
"""How long after a workflow's function has returned its queue is polled: its place is free once its end is recorded."""
BUSY_POLLING_S = 1.0
"""Longest polling interval while workflows run whose ends make room for others."""
IDLE_POLLING_S = 5.0
"""The same while none does, in case a notification is lost: all that is put into a queue is announced."""


class QueueListener:
    """A thread that dequeues the workflows of one queue into this process.

    It polls at once when notified, then at intervals that double, from the queue's own to `BUSY_POLLING_S` or
    `IDLE_POLLING_S`: workflows that found no free slot wait for the end of others.
    """

    def __init__(
        self,
        dbos: DBOS,
        queue: Queue,
        *,
        may_dequeue: Callable[[], bool],
        is_busy: Callable[[], bool],
        clock: WallClock,
    ) -> None:
        """
        :param may_dequeue: False while workflows are to be left to other processes.
        :param is_busy: True while workflows of the queue run, for whose end others may wait.
        """
        self._pause = PollPause(may_dequeue, is_busy=is_busy, clock=clock)
        self._thread = threading.Thread(
            target=work_queue, args=(dbos, queue, self._pause), name=f"queue {queue.name}", daemon=True
        )
        self._thread.start()

    def poll_now(self) -> None:
        self._pause.cut_short()

    def poll_soon(self) -> None:
        """Poll as soon as the end of the workflow that calls this is recorded."""
        self._pause.cut_short(ROOM_S)

    def stop(self) -> None:
        self._pause.set()
        self._thread.join()


class PollPause(threading.Event):
    """The pause between two polls, as the stop event of a queue's worker: set at the end, cut short by `cut_short`.

    While nothing may be dequeued, the pause is repeated.
    """

    def __init__(
        self,
        may_dequeue: Callable[[], bool],
        *,
        is_busy: Callable[[], bool] = lambda: False,
        clock: WallClock,
    ) -> None:
        super().__init__()
        self._may_dequeue = may_dequeue
        self._is_busy = is_busy
        self._clock = clock
        self._over = threading.Event()
        self._rest_s = 0.0
        self._pauses = 0
        """Since the last notification."""

    def cut_short(self, rest_s: float = 0.0) -> None:
        """End the pause in `rest_s` seconds."""
        self._rest_s = rest_s
        self._over.set()

    def set(self) -> None:
        super().set()
        self._over.set()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until it is set, cut short or over; True if it is set."""
        polling_s = IDLE_POLLING_S if timeout is None else timeout
        while True:
            longest_s = max(polling_s, BUSY_POLLING_S if self._is_busy() else IDLE_POLLING_S)
            if self._clock.wait(self._over, min(polling_s * 2**self._pauses, longest_s)):
                self._over.clear()
                if self._rest_s and not self.is_set():
                    self._clock.wait(self._over, self._rest_s)
                self._pauses = 0
            elif polling_s * 2**self._pauses < longest_s:
                self._pauses += 1
            if self.is_set() or self._may_dequeue():
                return self.is_set()
