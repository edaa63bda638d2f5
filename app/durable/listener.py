"""Takes workflows from their queues as soon as there are any."""

import threading
from typing import Any

from dbos import DBOS
from dbos._queue import queue_worker_thread


class Listener:
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
