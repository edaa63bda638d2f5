"""The queue of arrived messages. It is bounded: senders repeat what is dropped."""

import logging
import threading
from collections import deque
from collections.abc import Sequence

from robots.wire import Message

CAPACITY = 10_000

logger = logging.getLogger(__name__)


class Inbox:
    """Filled by the reactor's thread, emptied by another one."""

    def __init__(self, capacity: int = CAPACITY) -> None:
        self._capacity = capacity
        self._messages: deque[Message] = deque()
        self._changed = threading.Condition()
        self.dropped = 0
        """Messages dropped because the inbox was full."""
        self.malformed = 0
        """Arrivals that are no valid messages, or whose topic contradicts sender or receiver."""

    def put(self, message: Message) -> None:
        with self._changed:
            if len(self._messages) >= self._capacity:
                self.dropped += 1
                return
            self._messages.append(message)
            self._changed.notify()

    def take(self, timeout_s: float) -> Sequence[Message]:
        """All messages, waiting up to `timeout_s` for the first."""
        with self._changed:
            if timeout_s > 0:
                self._changed.wait_for(lambda: self._messages, timeout_s)
            taken = tuple(self._messages)
            self._messages.clear()
            return taken

    def reject(self, topic: str, why: object) -> None:
        """Count an invalid arrival; the first, the tenth, the hundredth … are logged."""
        self.malformed += 1
        if str(self.malformed).strip("0") == "1":
            lines = str(why).splitlines() or [""]
            logger.warning(
                "dropped an invalid message on %s (%d dropped so far): %s", topic, self.malformed, lines[0]
            )
