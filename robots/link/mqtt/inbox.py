"""What has arrived and is not read yet: bounded, for whoever sent what is dropped here sends it again."""

import logging
import threading
from collections import deque
from collections.abc import Sequence

from robots.wire import Message

HOLDS = 10_000

logger = logging.getLogger(__name__)


class Inbox:
    """Filled by the reactor's thread, emptied by another."""

    def __init__(self, holds: int = HOLDS) -> None:
        self._holds = holds
        self._messages: deque[Message] = deque()
        self._changed = threading.Condition()
        self.dropped = 0
        """Messages that there was no room for."""
        self.malformed = 0
        """Arrivals that are no messages, or lie about whom they are from or for."""

    def put(self, message: Message) -> None:
        with self._changed:
            if len(self._messages) >= self._holds:
                self.dropped += 1
                return
            self._messages.append(message)
            self._changed.notify()

    def take(self, timeout_s: float) -> Sequence[Message]:
        """All there is, waiting up to `timeout_s` for the first."""
        with self._changed:
            if timeout_s > 0:
                self._changed.wait_for(lambda: self._messages, timeout_s)
            taken = tuple(self._messages)
            self._messages.clear()
            return taken

    def reject(self, topic: str, why: object) -> None:
        """Count an arrival that cannot be understood; the first, the tenth, the hundredth … are logged."""
        self.malformed += 1
        if str(self.malformed).strip("0") == "1":
            lines = str(why).splitlines() or [""]
            logger.warning("dropped what came on %s, the %d. so far: %s", topic, self.malformed, lines[0])
