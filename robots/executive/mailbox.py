"""The robot's letters: each request is acted on once, each report kept and sent again until its receipt
comes.

No continuous link is assumed (MACTA §4): a link that loses, delays, repeats or closes changes nothing for the
script. In silence the oldest report alone is sent, now and then, to find out whether there is contact; once the service
is heard, all that is overdue goes.
"""

from collections import OrderedDict
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

from robots.executive.memory import MailboxMemory
from robots.link import Link, LinkClosed
from robots.wire import (
    Acknowledgement,
    Body,
    Message,
    PacketReport,
    Performative,
    Receipt,
    Refusal,
    SetPoint,
)

SERVICE = "service"
RESEND_S = 2.0
"""A report is sent again so long after its receipt could have come (world's clock)."""
SILENT_AT_MOST_S = 8.0
"""The longest pause of a robot in silence: some try must fall into a window of contact of 10 s."""
AT_ONCE = 16
"""So many reports are sent again in one tick at most."""
KEPT_REPORTS = 256
KEPT_ANSWERS = 256
"""A request that comes again after so many others is taken for a new one."""


@dataclass(slots=True)
class _Kept:
    message: Message
    sent_s: float


class Mailbox:
    """One robot's end of the link."""

    def __init__(self, name: str, link: Link, *, round_trip_s: float = 0.0) -> None:
        """:param round_trip_s: what a report and its receipt may be under way together, by the radio."""
        self._name = name
        self._link = link
        self._pace_s = self._pause_s = round_trip_s + RESEND_S
        self._hears = False
        self._heard_s = float("-inf")
        self._answers: OrderedDict[str, Message | None] = OrderedDict()
        self._kept: OrderedDict[str, _Kept] = OrderedDict()

    @property
    def kept(self) -> int:
        """How many reports wait for their receipt."""
        return len(self._kept)

    def memory(self) -> MailboxMemory:
        """What to keep. A request that has no answer yet is not: when it comes again it is attended to."""
        return MailboxMemory(
            answers=tuple(answer for answer in self._answers.values() if answer is not None),
            reports=tuple(kept.message for kept in self._kept.values()),
        )

    def recall(self, memory: MailboxMemory, now_s: float) -> None:
        """Answer as before, and send at once what has no receipt: it may never have left."""
        for answer in memory.answers:
            self._note(answer.in_reply_to or "", answer)
        for report in memory.reports:
            self._kept[report.id] = _Kept(report, float("-inf"))
        self._heard_s = now_s

    def collect(self) -> Sequence[Message]:
        """New messages for this robot. A repeated one gets its earlier answer again and is not handed on.

        NOTE: not so set-points, which are idempotent: a minute of them would push every other answer out.
        """
        fresh = []
        for message in self._arrived():
            if isinstance(message.body, Receipt):
                self._kept.pop(message.in_reply_to or "", None)
            elif isinstance(message.body, SetPoint):
                fresh.append(message)
            elif message.id in self._answers:
                answer = self._answers[message.id]
                if answer is not None:
                    self._send(answer)
            else:
                self._note(message.id, None)
                fresh.append(message)
        return fresh

    def answer(self, request: Message, performative: Performative, body: Body, now_s: float) -> None:
        """Answer a request and remember the answer, for the request may come again."""
        message = self._compose(performative, body, now_s, request.id)
        self._note(request.id, message)
        self._send(message)

    def agree_or_refuse(self, request: Message, script_id: str, why_not: str | None, now_s: float) -> None:
        """Answer a request that concerns a script."""
        if why_not is None:
            self.answer(request, Performative.AGREE, Acknowledgement(script_id=script_id), now_s)
        else:
            refusal = Refusal(script_id=script_id, reason=why_not)
            self.answer(request, Performative.REFUSE, refusal, now_s)

    def tell(
        self, query: Message, body: Body, now_s: float, performative: Performative = Performative.INFORM
    ) -> None:
        """Answer with something that is not to be remembered; who asks again asks anew."""
        self._send(self._compose(performative, body, now_s, query.id))

    def report(self, performative: Performative, body: Body, now_s: float) -> None:
        """Send a report and keep it until its receipt."""
        message = self._compose(performative, body, now_s)
        self._kept[message.id] = _Kept(message, now_s)
        if len(self._kept) > KEPT_REPORTS:
            self._drop_one()
        self._send(message)

    def post(self, body: Body, now_s: float) -> None:
        """Send something that is not worth keeping."""
        self._send(self._compose(Performative.INFORM, body, now_s))

    def resend(self, now_s: float) -> None:
        """Send again what has not got its receipt in time: all of it if the service has been heard since, a few a tick;
        else the oldest, each time later.
        """
        if self._hears:
            self._hears, self._heard_s, self._pause_s = False, now_s, self._pace_s
        if not self._kept:
            return
        overdue = [kept for kept in self._kept.values() if now_s - kept.sent_s >= self._pace_s]
        oldest = next(iter(self._kept.values()))
        again = [kept for kept in overdue if self._heard_s > kept.sent_s]
        if not again and now_s - oldest.sent_s >= self._pause_s:
            self._pause_s = max(min(2 * self._pause_s, SILENT_AT_MOST_S), self._pace_s)
            again = [oldest]
        for kept in again[:AT_ONCE]:
            self._send(kept.message)
            kept.sent_s = now_s

    def _arrived(self) -> Sequence[Message]:
        try:
            arrived = [message for message in self._link.receive() if message.receiver == self._name]
        except LinkClosed:
            return []
        self._hears |= bool(arrived)
        return arrived

    def _send(self, message: Message) -> None:
        with suppress(LinkClosed):  # what matters is kept and sent again
            self._link.send(message)

    def _note(self, request_id: str, answer: Message | None) -> None:
        self._answers[request_id] = answer
        if len(self._answers) > KEPT_ANSWERS:
            self._answers.popitem(last=False)

    def _drop_one(self) -> None:
        """Room is short: the oldest report on a packet goes first, how a script ended says more."""
        reports = [key for key, kept in self._kept.items() if isinstance(kept.message.body, PacketReport)]
        del self._kept[reports[0] if reports else next(iter(self._kept))]

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
