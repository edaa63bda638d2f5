"""A thread that runs for the length of the service's life."""

import threading
from collections.abc import Callable

JOIN_S = 5.0


class Background:
    """Work in a daemon thread that goes on until `ending` is set: it checks that, or waits on it, between its turns."""

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
