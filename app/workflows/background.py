"""A thread that runs until the service ends."""

import threading
from collections.abc import Callable

JOIN_S = 5.0


class Background:
    """A daemon thread. Its work returns once `ending` is set, which it checks or waits for between its turns."""

    def __init__(self, name: str, work: Callable[[], None]) -> None:
        self.ending = threading.Event()
        self._thread = threading.Thread(target=work, name=name, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def end(self) -> bool:
        """Set `ending` and join the thread; False if it was never started."""
        self.ending.set()
        was_started = self._thread.ident is not None
        if was_started:
            self._thread.join(timeout=JOIN_S)
        return was_started
