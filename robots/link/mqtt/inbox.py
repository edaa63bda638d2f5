"""The queue of arrived messages. It is bounded: senders repeat what is dropped."""

import logging
import threading
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from pydantic import ValidationError

from robots.wire import Message

CAPACITY = 10_000
MAX_WORDS = 300
"""Characters of what is kept of the reason against an arrival."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rejected:
    """Arrivals that were dropped as invalid: how many, and the last one's topic and fault."""

    count: int
    topic: str
    reason: str


class Inbox:
    """Filled by the reactor's thread, emptied by another one."""

    def __init__(self, capacity: int = CAPACITY) -> None:
        self._capacity = capacity
        self._messages: deque[Message] = deque()
        self._changed = threading.Condition()
        self.dropped = 0
        """Messages dropped because the inbox was full."""
        self.rejected: Rejected | None = None
        """Arrivals that are no valid messages, or whose topic contradicts sender or receiver; None: none so far."""

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

    @property
    def malformed(self) -> int:
        """The number of invalid arrivals."""
        return 0 if self.rejected is None else self.rejected.count

    def reject(self, topic: str, why: ValidationError | str) -> None:
        """Count an invalid arrival; the first, the tenth, the hundredth … are logged."""
        reason = (_fault(why) if isinstance(why, ValidationError) else why)[:MAX_WORDS]
        self.rejected = Rejected(count=self.malformed + 1, topic=topic[:MAX_WORDS], reason=reason)
        if str(self.malformed).strip("0") == "1":
            logger.warning(
                "dropped an invalid message on %s (%d dropped so far): %s", topic, self.malformed, reason
            )


def _fault(error: ValidationError) -> str:
    """`body.script_request.script.id: Field required`."""
    faults = error.errors(include_url=False, include_input=False, include_context=False)
    # A body that is neither of a known kind nor any other has the faults of both.
    fault = next((one for one in faults if not one["type"].startswith("union_tag")), faults[0])
    where = [str(part) for part in fault["loc"] if not str(part).startswith("tagged-union")]
    return f"{'.'.join(where) or 'payload'}: {fault['msg']}"
