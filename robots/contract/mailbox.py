"""The robot's mailbox: each request is handled once, each report is kept and resent until its receipt arrives.

No continuous link is assumed (MACTA §4): scripts run on over a link that loses, delays, repeats or closes. Without
contact only the oldest report is resent, at growing intervals, to detect contact; then all overdue reports are sent.
"""

from collections import OrderedDict
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain

from robots.contract.known_scripts import remember
from robots.contract.memory import MailboxMemory
from robots.link import Link, LinkClosed
from robots.wire import (
    Acknowledgement,
    Body,
    Message,
    MindOrder,
    NotUnderstood,
    PacketReport,
    Performative,
    Receipt,
    Refusal,
    SetPoint,
    SpeechAct,
    SpeechReport,
    UnknownBody,
    UnknownKinds,
)

SERVICE = "service"
RESEND_S = 2.0
"""A report is resent this long after its receipt could have arrived (world's clock)."""
LONGEST_PAUSE_S = 8.0
"""The longest interval without contact: at least one attempt must fall into a contact window of 10 s."""
RESENT_A_TICK = 16
KEPT_REPORTS = 256
KEPT_ANSWERS = 256
"""A request that is repeated after this many others counts as new."""


@dataclass(slots=True)
class _Kept:
    message: Message
    sent_s: float


class Mailbox:
    """One robot's end of the link."""

    def __init__(self, name: str, link: Link, *, round_trip_s: float = 0.0) -> None:
        """:param round_trip_s: the longest travel time of a report and its receipt together."""
        self._name = name
        self._link = link
        self._interval_s = round_trip_s + RESEND_S
        self._pause_s = self._interval_s
        self._has_received = False
        self._received_s = float("-inf")
        self._heard_s = float("-inf")
        self._answers: OrderedDict[str, Message | None] = OrderedDict()
        self._kept: OrderedDict[str, _Kept] = OrderedDict()
        self.changes = 0
        """Counts the changes of what `memory` holds."""
        self._unknown_kinds = UnknownKinds()
        self._speech: list[Message] = []

    @property
    def heard_s(self) -> float:
        """When the service was last heard (world's clock); a power failure does not count."""
        return self._heard_s

    @property
    def answer_s(self) -> float:
        """In what time a receipt comes, if the link is up and neither is lost."""
        return self._interval_s

    @property
    def kept(self) -> int:
        """The number of reports without a receipt."""
        return len(self._kept)

    def memory(self) -> MailboxMemory:
        """The state to restore. Requests without an answer are left out: they are handled when repeated."""
        return MailboxMemory(
            answers=tuple(answer for answer in self._answers.values() if answer is not None),
            reports=tuple(kept.message for kept in self._kept.values()),
        )

    def recall(self, memory: MailboxMemory, now_s: float) -> None:
        """Restore answers, and reports without a receipt, which are resent at once."""
        for answer in memory.answers:
            self._note(answer.in_reply_to or "", answer)
        for report in memory.reports:
            self._kept[report.id] = _Kept(report, float("-inf"))
        self._received_s = now_s

    def collect_orders_to_mind(self) -> Sequence[Message]:
        """The orders to the robot's mind that have come, and nothing else: while another program speaks for the robot,
        what is for that one is neither noted nor answered here.
        """
        new = []
        for message in self._arrived():
            if not isinstance(message.body, MindOrder):
                continue
            answer = self._answers.get(message.id)
            if answer is not None:
                self._send(answer)
            else:
                new.append(message)
        return new

    def collect(self, now_s: float) -> Sequence[Message]:
        """New messages for this robot. A repeated request gets its earlier answer again and is left out.

        Messages of unknown kinds are answered here. A report that the service does not understand is forgotten, as one
        with a receipt.

        NOTE: set-points are idempotent and not noted: a minute of them would displace every other answer.
        """
        new = []
        for message in self._arrived():
            if isinstance(message.body, Receipt | NotUnderstood):
                self.changes += self._kept.pop(message.in_reply_to or "", None) is not None
            elif isinstance(message.body, UnknownBody):
                if (answer_to := self._unknown_kinds.answer(message, now_s)) is not None:
                    self.tell(message, answer_to, now_s, Performative.NOT_UNDERSTOOD)
            elif isinstance(message.body, SetPoint):
                new.append(message)
            elif message.id in self._answers:
                answer = self._answers[message.id]
                if answer is not None:
                    self._send(answer)
            else:
                self._note(message.id, None)
                new.append(message)
        return new

    def speech(self) -> Sequence[Message]:
        """The speech acts that the last `collect` has found."""
        return self._speech

    def pass_on(self, message: Message) -> None:
        """Send a message of the robot's own making, without guarantee that it arrives."""
        self._send(message)

    def answer(self, request: Message, performative: Performative, body: Body, now_s: float) -> None:
        """Answer a request and keep the answer for its repetitions."""
        message = self._compose(performative, body, now_s, request.id)
        self._note(request.id, message)
        self._send(message)

    def agree_or_refuse(self, request: Message, script_id: str, reason: str | None, now_s: float) -> None:
        """Answer a request on a script. `reason`: why it is refused, None if it is not."""
        if reason is None:
            self.answer(request, Performative.AGREE, Acknowledgement(script_id=script_id), now_s)
        else:
            refusal = Refusal(script_id=script_id, reason=reason)
            self.answer(request, Performative.REFUSE, refusal, now_s)

    def tell(
        self, query: Message, body: Body, now_s: float, performative: Performative = Performative.INFORM
    ) -> None:
        """Answer without keeping the answer; a repeated query gets a new one."""
        self._send(self._compose(performative, body, now_s, query.id))

    def report(self, performative: Performative, body: Body, now_s: float) -> None:
        """Send a report and keep it until its receipt."""
        message = self._compose(performative, body, now_s)
        self._kept[message.id] = _Kept(message, now_s)
        self.changes += 1
        if len(self._kept) > KEPT_REPORTS:
            self._drop_one()
        self._send(message)

    def post(self, body: Body, now_s: float) -> None:
        """Send without keeping it."""
        self._send(self._compose(Performative.INFORM, body, now_s))

    def resend(self, now_s: float) -> None:
        """Resend reports without a receipt: with contact all overdue ones, a few a tick; without, the oldest alone."""
        if self._has_received:
            self._has_received = False
            self._received_s = now_s
            self._heard_s = now_s
            self._pause_s = self._interval_s
        if not self._kept:
            return
        overdue = [kept for kept in self._kept.values() if now_s - kept.sent_s >= self._interval_s]
        oldest = next(iter(self._kept.values()))
        again = [kept for kept in overdue if self._received_s > kept.sent_s]
        if not again and now_s - oldest.sent_s >= self._pause_s:
            self._pause_s = max(min(2 * self._pause_s, LONGEST_PAUSE_S), self._interval_s)
            again = [oldest]
        for kept in again[:RESENT_A_TICK]:
            self._send(kept.message)
            kept.sent_s = now_s

    def _arrived(self) -> Sequence[Message]:
        try:
            arrived = [message for message in self._link.receive() if message.receiver == self._name]
        except LinkClosed:
            self._speech = []
            return []
        # NOTE: only the service gives orders, and only its messages show that there is contact with it.
        self._speech = [message for message in arrived if isinstance(message.body, SpeechAct)]
        of_service = [message for message in arrived if message.sender == SERVICE]
        self._has_received |= bool(of_service)
        return [message for message in of_service if not isinstance(message.body, SpeechAct)]

    def _send(self, message: Message) -> None:
        with suppress(LinkClosed):  # what matters is kept and resent
            self._link.send(message)

    def _note(self, request_id: str, answer: Message | None) -> None:
        remember(self._answers, request_id, answer, KEPT_ANSWERS)
        self.changes += answer is not None

    def _drop_one(self) -> None:
        """Drop the oldest report on what others have said; else that on a packet without results; else the oldest."""
        bodies = [(key, kept.message.body) for key, kept in self._kept.items()]
        speech = (key for key, body in bodies if isinstance(body, SpeechReport))
        spare = (key for key, body in bodies if isinstance(body, PacketReport) and not body.results)
        del self._kept[next(chain(speech, spare, self._kept))]

    def _compose(
        self, performative: Performative, body: Body, now_s: float, reply: str | None = None
    ) -> Message:
        return Message(
            performative=performative,
            sender=self._name,
            receiver=SERVICE,
            sent_at_s=now_s,
            in_reply_to=reply,
            body=body,
        )
