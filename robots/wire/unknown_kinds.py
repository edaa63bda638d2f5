"""Which messages of unknown kinds are answered: each once, and few a second."""

from collections import OrderedDict

from robots.wire.messages import Message, NotUnderstood, UnknownBody

REMEMBERED = 256
PER_S = 10.0
"""Answers a second, and at once after a pause (our choice)."""


class UnknownKinds:
    """Makes the answers of one end to messages of kinds that it does not know."""

    def __init__(self) -> None:
        self._answered: OrderedDict[str, None] = OrderedDict()
        self._left = PER_S
        self._at_s = float("-inf")
        self.unanswered = 0
        """Messages that came too often to be answered."""

    def answer(self, message: Message, now_s: float) -> NotUnderstood | None:
        """The answer to a message; None if its kind is known, it was answered before, or too many came.

        :param now_s: by any clock; after it was set back, counting begins again.
        """
        if not isinstance(message.body, UnknownBody) or message.id in self._answered:
            return None
        passed_s = now_s - self._at_s
        self._left = min(self._left + passed_s * PER_S, PER_S) if passed_s >= 0 else PER_S
        self._at_s = now_s
        if self._left < 1:
            self.unanswered += 1
            return None
        self._left -= 1
        self._answered[message.id] = None
        if len(self._answered) > REMEMBERED:
            self._answered.popitem(last=False)
        return NotUnderstood(reason=f"unknown kind {message.body.kind}")
