"""Dequeues workflows as soon as there are any."""

import threading
from collections.abc import Callable

from dbos import DBOS, Queue

from app.domain.clock import WallClock, pause
from app.workflows.dbos_internals import queue_of, running_in, work_queue

LOOK_S = 0.005
"""Between two looks whether the end of a workflow whose function has returned is recorded; then its place is free."""
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
        waits: bool,
        may_dequeue: Callable[[], bool],
        clock: WallClock,
    ) -> None:
        """
        :param waits: whether workflows of the queue wait for others' ends.
        :param may_dequeue: False while workflows are to be left to other processes.
        """
        self._waits = waits
        self._pause = PollPause(
            may_dequeue,
            is_busy=lambda: waits and running_in(dbos, queue.name) > 0,
            is_executing=lambda workflow_id: queue_of(dbos, workflow_id) is not None,
            clock=clock,
        )
        self._thread = threading.Thread(
            target=work_queue, args=(dbos, queue, self._pause), name=f"queue {queue.name}", daemon=True
        )
        self._thread.start()

    def poll_now(self) -> None:
        self._pause.cut_short()

    def poll_after(self, workflow_id: str) -> None:
        """Poll as soon as the end of this workflow, whose function returns, is recorded, if others wait for ends."""
        if self._waits:
            self._pause.cut_short(workflow_id)

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
        is_executing: Callable[[str], bool] = lambda workflow_id: False,
        clock: WallClock,
    ) -> None:
        """
        :param is_busy: True while workflows run for whose end others may wait.
        :param is_executing: whether a workflow's end is not recorded.
        """
        super().__init__()
        self._may_dequeue = may_dequeue
        self._is_busy = is_busy
        self._is_executing = is_executing
        self._clock = clock
        self._over = threading.Event()
        self._lock = threading.Lock()
        self._is_announced = False
        self._ending: set[str] = set()
        """Workflows whose functions have returned, and whose places others may be waiting for."""
        self._pauses = 0
        """Since the last notification."""

    def cut_short(self, ending: str | None = None) -> None:
        """End the pause, at once, or when the end of this workflow is recorded."""
        with self._lock:
            if ending is None:
                self._is_announced = True
            else:
                self._ending.add(ending)
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
                self._wait_for_room()
                self._pauses = 0
            elif polling_s * 2**self._pauses < longest_s:
                self._pauses += 1
            if self.is_set() or self._may_dequeue():
                return self.is_set()

    def _wait_for_room(self) -> None:
        """Wait until a workflow was announced or one that ends has ended, `BUSY_POLLING_S` at most."""
        until_s = self._clock.monotonic_s() + BUSY_POLLING_S
        while not self.is_set() and self._clock.monotonic_s() < until_s:
            with self._lock:
                left = {one for one in self._ending if self._is_executing(one)}
                has_room = self._is_announced or left < self._ending or not left
                self._is_announced = False
                self._ending = left
            if has_room:
                if left:
                    self._over.set()  # the next pause is over when they have ended
                return
            pause(self._clock, LOOK_S)
        with self._lock:
            self._ending.clear()
