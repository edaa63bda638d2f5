"""When a message that is not answered is sent again: at the pace of the world and its radio, and of who is heard."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from robots.clock import Clock
from robots.world import LinkSpec
from robots.world.radio import RESENT_S

LEAST_S = 0.1
"""Wall-clock seconds between two sendings, however fast the world runs: recording an answer takes time."""
SILENT_AT_MOST_S = 16.0
"""World seconds: the longest pause between two sendings to a robot that is not heard."""


@dataclass(slots=True)
class _Sent:
    at_s: float
    at: float
    pause_s: float


class Pace:
    """What was sent when, and who was heard since.

    A robot that has been heard since and could have answered by now is sent the message again at once: the message, or
    its answer, was lost. To one in silence it goes ever more seldom, which is enough, for its first word changes that.
    """

    def __init__(
        self,
        clock: Clock,
        links: Mapping[str, LinkSpec],
        *,
        heard_s: Callable[[str], float | None],
        wall: Callable[[], float] = time.monotonic,
    ) -> None:
        """
        :param links: each robot's radio.
        :param heard_s: when a robot last said something, whatever it was, by the world's clock.
        """
        self._clock, self._heard_s, self._wall = clock, heard_s, wall
        self._paces_s = {robot: link.round_trip_s + RESENT_S for robot, link in links.items()}
        self._sent: dict[str, _Sent] = {}

    @property
    def outstanding(self) -> bool:
        """True if something was sent that may have to be sent again."""
        return bool(self._sent)

    def is_due(self, robot: str, message_id: str) -> bool:
        """True if the message is to be sent now; then it counts as sent."""
        now_s, now, pace_s = self._clock.now_s(), self._wall(), self._paces_s[robot]
        sent = self._sent.get(message_id)
        if sent is None:
            self._sent[message_id] = _Sent(now_s, now, pace_s)
            return True
        waited_s = now_s - sent.at_s
        if now - sent.at < LEAST_S or 0 <= waited_s < pace_s:  # a clock that went back is another run's
            return False
        heard_s = self._heard_s(robot)
        heard = heard_s is not None and heard_s > sent.at_s
        if 0 <= waited_s < sent.pause_s and not heard:
            return False
        pause_s = pace_s if heard else max(min(2 * sent.pause_s, SILENT_AT_MOST_S), pace_s)
        self._sent[message_id] = _Sent(now_s, now, pause_s)
        return True

    def keep(self, message_ids: set[str]) -> None:
        """Forget all messages but these: the others are answered."""
        self._sent = {known: sent for known, sent in self._sent.items() if known in message_ids}
