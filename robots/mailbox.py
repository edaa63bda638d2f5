"""The robot's letters: each request is acted on once, each report kept and sent again until its receipt
comes.

No continuous link is assumed (MACTA §4): a link that loses, delays, repeats or closes changes nothing for the
script.
"""

from collections import OrderedDict
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

from robots.link import Link, LinkClosed
from robots.memory import KeptReport, MailboxMemory
from robots.wire import Body, Message, PacketReport, Performative, Receipt

SERVICE = "service"
RESEND_S, RESEND_AT_MOST_S = 2.0, 30.0
KEPT_REPORTS = 256
KEPT_ANSWERS = 256
"""A request that comes again after so many others is taken for a new one."""


@dataclass(slots=True)
class _Kept:
    message: Message
    due_s: float
    pause_s: float = RESEND_S


class Mailbox:
    """One robot's end of the link."""

    def __init__(self, name: str, link: Link) -> None:
        self._name = name
        self._link = link
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
            reports=tuple(KeptReport(message=k.message, pause_s=k.pause_s) for k in self._kept.values()),
        )

    def recall(self, memory: MailboxMemory, now_s: float) -> None:
        """Answer as before, and send at once what has no receipt: it may never have left."""
        for answer in memory.answers:
            self._note(answer.in_reply_to or "", answer)
        for one in memory.reports:
            self._kept[one.message.id] = _Kept(one.message, now_s, one.pause_s)

    def collect(self) -> Sequence[Message]:
        """New messages for this robot. A repeated one gets its earlier answer again and is not handed on."""
        fresh = []
        for message in self._arrived():
            if isinstance(message.body, Receipt):
                self._kept.pop(message.in_reply_to or "", None)
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

    def tell(self, query: Message, body: Body, now_s: float) -> None:
        """Answer a query with something that is too much to remember; who asks again asks anew."""
        self._send(self._compose(Performative.INFORM, body, now_s, query.id))

    def report(self, performative: Performative, body: Body, now_s: float) -> None:
        """Send a report and keep it until its receipt."""
        message = self._compose(performative, body, now_s)
        self._kept[message.id] = _Kept(message, now_s + RESEND_S)
        if len(self._kept) > KEPT_REPORTS:
            self._drop_one()
        self._send(message)

    def post(self, body: Body, now_s: float) -> None:
        """Send something that is not worth keeping."""
        self._send(self._compose(Performative.INFORM, body, now_s))

    def resend(self, now_s: float) -> None:
        """Send again every report whose receipt is overdue, each time later."""
        for kept in self._kept.values():
            if now_s >= kept.due_s:
                self._send(kept.message)
                kept.pause_s = min(2 * kept.pause_s, RESEND_AT_MOST_S)
                kept.due_s = now_s + kept.pause_s

    def _arrived(self) -> Sequence[Message]:
        try:
            return [message for message in self._link.receive() if message.receiver == self._name]
        except LinkClosed:
            return []

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
