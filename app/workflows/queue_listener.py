"""Takes workflows from their queues as soon as there are any."""

import threading
import time
from collections.abc import Callable
from typing import Any

from dbos import DBOS
from dbos._queue import queue_worker_thread

AWAKE_S = 5.0
"""So long after the last workflow, or word of one, a queue is looked at as often as ever."""
ASLEEP_S = 1.0
"""How often then: what nobody tells of is what a dead process has left."""


class Listener:
    """Takes the workflows of one queue in this process. DBOS looks every so often; this looks also when it is told that
    there is one, which saves a goal half a poll, and seldom while there is nothing."""

    def __init__(self, dbos: DBOS, queue: Any, *, may_take: Callable[[], bool]) -> None:
        """:param may_take: whether workflows may be taken just now; if not, they are left to others."""
        active = dbos._active_workflows_set
        self._pause = _Pause(may_take, is_busy=lambda: active.count_for_queue(queue.name) > 0)
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
    """Between two looks: set at the end, and can be cut short. As long as nothing may be taken, one more follows."""

    def __init__(self, may_take: Callable[[], bool], *, is_busy: Callable[[], bool]) -> None:
        super().__init__()
        self._may_take, self._is_busy = may_take, is_busy
        self._over = threading.Event()
        self._awake_until = time.monotonic() + AWAKE_S

    def cut_short(self) -> None:
        self._over.set()

    def set(self) -> None:
        super().set()
        self._over.set()

    def wait(self, timeout: float | None = None) -> bool:
        """Until it is set, cut short or over; True if it is set."""
        while True:
            is_told = self._over.wait(self._length_s(timeout))
            self._over.clear()
            if is_told:
                self._awake_until = time.monotonic() + AWAKE_S
            if self.is_set() or self._may_take():
                return self.is_set()

    def _length_s(self, awake_s: float | None) -> float | None:
        now = time.monotonic()
        if self._is_busy():
            self._awake_until = now + AWAKE_S
        return awake_s if awake_s is None or now < self._awake_until else max(awake_s, ASLEEP_S)
