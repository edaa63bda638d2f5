"""The seam `Link`, and links within one machine."""

from collections.abc import Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from queue import Empty, SimpleQueue
from threading import Lock
from typing import Protocol

from robots.wire import Message

MAX_BATCH = 1000
"""Messages that one call reads at most; a sender that is faster waits at its end of the pipe."""


class LinkClosed(ConnectionError):
    """Raised when a message is sent or awaited on a link whose other end is closed."""


class Link(Protocol):
    """One end of the channel. Several robots share it; `Message.receiver` names the robot."""

    def send(self, message: Message) -> None:
        """Send without guarantee that it arrives.

        :raises LinkClosed: if the other end is closed.
        """
        ...

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        """The messages that have arrived, waiting up to `timeout_s` (wall clock) for the first.

        :raises LinkClosed: if the other end is closed and nothing is left to read.
        """
        ...

    def close(self) -> None: ...


class InMemoryLink:
    """Both ends in one process, for tests. Messages are transferred as JSON."""

    def __init__(self, inbox: "SimpleQueue[str]", outbox: "SimpleQueue[str]") -> None:
        self._inbox = inbox
        self._outbox = outbox

    @classmethod
    def pair(cls) -> "tuple[InMemoryLink, InMemoryLink]":
        """The service's end and the robots' end."""
        one: SimpleQueue[str] = SimpleQueue()
        other: SimpleQueue[str] = SimpleQueue()
        return cls(one, other), cls(other, one)

    def send(self, message: Message) -> None:
        self._outbox.put(message.model_dump_json())

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        arrived: list[Message] = []
        with suppress(Empty):
            while True:
                wait_s = 0.0 if arrived else timeout_s
                arrived.append(
                    Message.model_validate_json(self._inbox.get(block=wait_s > 0, timeout=wait_s or None))
                )
        return arrived

    def close(self) -> None:
        """Nothing to release."""


class PipeLink:
    """An end of a pipe between two processes on one machine; the embedded default."""

    def __init__(self, connection: "Connection[bytes, bytes]") -> None:
        self._connection = connection
        self._lock = Lock()

    def send(self, message: Message) -> None:
        with self._lock:
            try:
                self._connection.send_bytes(message.model_dump_json().encode())
            except (OSError, ValueError) as error:
                raise LinkClosed(f"cannot send to {message.receiver}: the pipe is closed") from error

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        arrived: list[Message] = []
        try:
            while len(arrived) < MAX_BATCH and self._connection.poll(0.0 if arrived else timeout_s):
                arrived.append(Message.model_validate_json(self._connection.recv_bytes()))
        except (EOFError, OSError) as error:
            if not arrived:
                raise LinkClosed("the pipe's other end is gone") from error
        return arrived

    def close(self) -> None:
        self._connection.close()
