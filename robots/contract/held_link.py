"""A link whose messages wait until what they tell of is on the disk."""

from collections.abc import Sequence
from contextlib import suppress

from robots.link import Link, LinkClosed
from robots.wire import Message


class HeldLink:
    """Implements `robots.link.Link`: sent messages are held until `release`."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._held: list[Message] = []

    @property
    def held(self) -> Sequence[Message]:
        """What waits."""
        return self._held

    def send(self, message: Message) -> None:
        self._held.append(message)

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        return self._link.receive(timeout_s)

    def release(self) -> None:
        """Send what is held. What a closed link does not take is lost, as by radio."""
        held, self._held = self._held, []
        with suppress(LinkClosed):
            for message in held:
                self._link.send(message)

    def discard(self) -> None:
        """Forget what is held."""
        self._held = []

    def close(self) -> None:
        self._link.close()
