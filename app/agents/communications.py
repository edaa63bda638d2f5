"""Communications with one world's robots (MACTA §4, fig. 4): sends messages, and repeats them until answered."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from app.domain.clock import SYSTEM_CLOCK, WallClock
from robots.clock import Clock
from robots.link.channel import Link
from robots.wire import Body, Message, Performative, Telemetry
from robots.world import LinkSpec
from robots.world.radio import RESENT_S

SERVICE = "service"
ESCAPED_NUL = "\\u0000"
"""As JSON has it."""
MIN_RESEND_S = 0.1
"""Wall-clock seconds between two sendings, however fast the world runs: recording an answer takes time."""
MAX_SILENT_RESEND_S = 16.0
"""World seconds: the longest pause between two sendings to a robot that is not heard."""


class Communications:
    """Sends messages to robots. One that needs an answer is repeated until `keep_unanswered` drops it.

    All repetitions have the same id, so a robot acts on it once.
    """

    def __init__(
        self,
        link: Link,
        *,
        clock: Clock,
        link_of: Callable[[str], LinkSpec],
        heard_s: Callable[[str], float | None],
        wall: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """
        :param clock: the world's.
        :param link_of: the radio of a robot as it is now.
        :param heard_s: when a robot was last heard, by the world's clock.
        """
        self._link = link
        self._clock = clock
        self._schedule = ResendSchedule(clock, link_of, heard_s=heard_s, wall=wall)
        self._unanswered: set[str] = set()

    @property
    def has_unanswered(self) -> bool:
        return self._schedule.has_unanswered

    def receive(self, timeout_s: float) -> Sequence[Message]:
        """The messages of robots, as they can be recorded.

        :raises LinkClosed: if the link is closed.
        """
        return [recordable(message) for message in self._link.receive(timeout_s)]

    def send(
        self,
        robot: str,
        performative: Performative,
        body: Body,
        *,
        message_id: str | None = None,
        in_reply_to: str | None = None,
    ) -> None:
        """Send a message now; with a new id unless one is given."""
        named = {"id": message_id} if message_id else {}
        self._link.send(
            Message(
                **named,
                performative=performative,
                sender=SERVICE,
                receiver=robot,
                sent_at_s=self._clock.now_s(),
                in_reply_to=in_reply_to,
                body=body,
            )
        )

    def send_if_due(
        self,
        robot: str,
        message_id: str,
        performative: Performative,
        body: Body,
        *,
        in_reply_to: str | None = None,
    ) -> None:
        """Send an unanswered message if its resend schedule says so."""
        self._unanswered.add(message_id)
        if self._schedule.is_due(robot, message_id):
            self.send(robot, performative, body, message_id=message_id, in_reply_to=in_reply_to)

    def keep_unanswered(self) -> None:
        """Forget the messages that were not passed to `send_if_due` since the last call: they are answered."""
        self._schedule.keep(self._unanswered)
        self._unanswered = set()


def recordable(message: Message) -> Message:
    """The message with U+FFFD for each NUL of its texts: PostgreSQL records none. Telemetry is not recorded."""
    if isinstance(message.body, Telemetry) or ESCAPED_NUL not in message.model_dump_json():
        return message
    return Message.model_validate(_without_nul(message.model_dump(mode="json")))


def _without_nul(value: Any) -> Any:
    if isinstance(value, str):
        return value.replace("\0", "\N{REPLACEMENT CHARACTER}")
    if isinstance(value, dict):
        return {_without_nul(key): _without_nul(child) for key, child in value.items()}
    return [_without_nul(child) for child in value] if isinstance(value, list) else value


@dataclass(slots=True, kw_only=True)
class _Sent:
    at_s: float
    wall_s: float
    pause_s: float


class ResendSchedule:
    """When each unanswered message was last sent, and when it is due again.

    If the robot was heard since and could have answered by now, the message is resent at once: message or answer was
    lost. To a silent robot it is resent with doubling pauses until the robot is heard.
    """

    def __init__(
        self,
        clock: Clock,
        link_of: Callable[[str], LinkSpec],
        *,
        heard_s: Callable[[str], float | None],
        wall: WallClock,
    ) -> None:
        """For the parameters see `Communications`."""
        self._clock = clock
        self._heard_s = heard_s
        self._wall = wall
        self._link_of = link_of
        self._sent: dict[str, _Sent] = {}

    @property
    def has_unanswered(self) -> bool:
        return bool(self._sent)

    def is_due(self, robot: str, message_id: str) -> bool:
        """True if the message is to be sent now; it then counts as sent."""
        now_s = self._clock.now_s()
        wall_s = self._wall.monotonic_s()
        min_pause_s = self._link_of(robot).round_trip_s + RESENT_S
        sent = self._sent.get(message_id)
        if sent is None:
            self._sent[message_id] = _Sent(at_s=now_s, wall_s=wall_s, pause_s=min_pause_s)
            return True
        waited_s = now_s - sent.at_s
        # The world's clock goes back when a new run begins.
        if wall_s - sent.wall_s < MIN_RESEND_S or 0 <= waited_s < min_pause_s:
            return False
        heard_s = self._heard_s(robot)
        heard = heard_s is not None and heard_s > sent.at_s
        if 0 <= waited_s < sent.pause_s and not heard:
            return False
        pause_s = min_pause_s if heard else max(min(2 * sent.pause_s, MAX_SILENT_RESEND_S), min_pause_s)
        self._sent[message_id] = _Sent(at_s=now_s, wall_s=wall_s, pause_s=pause_s)
        return True

    def keep(self, message_ids: set[str]) -> None:
        """Forget all messages but these."""
        self._sent = {known: sent for known, sent in self._sent.items() if known in message_ids}
