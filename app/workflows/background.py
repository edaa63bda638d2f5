"""A thread beside the service's others, for the length of its life."""

import threading
from collections.abc import Callable

JOIN_S = 5.0


class Background:
    """Work that goes on until it is told to end: it looks at `ending`, or waits on it, between its turns."""

    def __init__(self, name: str, work: Callable[[], None]) -> None:
        self.ending = threading.Event()
        self._thread = threading.Thread(target=work, name=name, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def end(self) -> bool:
        """Tell it to end and wait for that; False if it never began."""
        self.ending.set()
        began = self._thread.ident is not None
        if began:
            self._thread.join(timeout=JOIN_S)
        return began
