"""A robot's own software whose mind may leave it, and which takes up minds that come. Call `tick()` at 20 Hz.

While its mind is elsewhere it stands by: it neither acts nor speaks, and hears nothing but what moves minds. What it
has been handed over, and everything that it answers, is saved before it is said.
"""

import logging
from collections.abc import Callable
from contextlib import suppress
from typing import Protocol

from robots.clock import Clock
from robots.contract.held_link import HeldLink
from robots.contract.mailbox import SERVICE
from robots.contract.memory_file import MemoryStore
from robots.executive.agent import BehaviouralAgent
from robots.executive.hand_over import MindUnfit, Pieces, read_document
from robots.executive.memory import RobotMemory
from robots.link import Link, LinkClosed
from robots.wire import (
    Message,
    MindTransfer,
    MindTransferReport,
    Performative,
    Telemetry,
)

SAVED_EVERY_S = 1.0
"""Interval at which the memory of a robot that acts is saved, beside what it says (world's clock)."""

logger = logging.getLogger(__name__)

MakeAgent = Callable[[Link, RobotMemory | None], BehaviouralAgent]
"""Makes the robot's agent on a link, with this memory; with the same body each time."""


class Seat(Protocol):
    """A link on which the robot's own software speaks for it, or stands by."""

    def speak(self, robot: str, *, speaks: bool) -> None:
        """Speak for the robot from now on, or only hear what moves minds."""
        ...


class RobotProgram:
    """One robot's. One thread calls it."""

    def __init__(
        self,
        name: str,
        *,
        make: MakeAgent,
        link: Link,
        clock: Clock,
        store: MemoryStore | None = None,
        stands_by: bool = False,
        seat: Seat | None = None,
    ) -> None:
        """
        :param store: its persistent memory; None: it forgets everything at a restart.
        :param stands_by: without a memory it begins without a mind: another program has it.
        :param seat: is told whether the robot speaks.
        :raises OSError: if the memory cannot be read. :raises ValueError: if it is none.
        """
        self.name = name
        self._make = make
        self._clock = clock
        self._store = store
        self._seat = seat
        self._inbox = _Inbox(link)
        self._link = HeldLink(self._inbox)
        self._pieces = Pieces()
        self._saved_s = float("-inf")
        text = None if store is None else store.load()
        memory = None if text is None else RobotMemory.model_validate_json(text)
        self.agent = make(self._link, memory)
        if memory is None and stands_by:
            self.agent.stand_by()
        self._speaks: bool | None = None
        self._tell_seat()

    @property
    def is_mute(self) -> bool:
        """True while another program has the mind."""
        return self.agent.embodiment.is_handed_over

    def tick(self) -> None:
        """One control cycle: take what moves minds, let the agent act, save, and only then send."""
        arrived = [one for one in self._inbox.take() if one.receiver == self.name]
        for message in arrived:
            if isinstance(message.body, MindTransfer):
                self._take(message, message.body)
            else:
                self._inbox.pass_on(message)
        self.agent.tick()
        self._save_and_send()
        self._tell_seat()

    def close(self) -> None:
        """Save the memory; the link is its maker's."""
        self._save()

    def _take(self, message: Message, transfer: MindTransfer) -> None:
        """Take a piece of a mind, and with the last one the mind."""
        if message.sender != SERVICE:
            return
        reason = self._why_not(transfer)
        if reason is None and not self._has(transfer):
            try:
                text = self._pieces.put(transfer.mind)
                if text is not None:
                    self._begin(transfer, text)
            except MindUnfit as error:
                reason = str(error)
        report = MindTransferReport(
            fence=transfer.fence,
            digest=transfer.mind.digest,
            number=transfer.mind.number,
            reason=reason or "",
        )
        self._answer(message, Performative.REFUSE if reason else Performative.AGREE, report)

    def _why_not(self, transfer: MindTransfer) -> str | None:
        here = self.agent.embodiment
        if transfer.fence < here.fence:
            return f"fencing number {transfer.fence} is over, {here.fence} is in force"
        if not here.is_handed_over:
            return f"the mind of {self.name} is here"
        if self.agent.held is not None:
            return f"{self.name} holds {self.agent.held} in this body; have it put down first"
        return self.agent.fault or None

    def _has(self, transfer: MindTransfer) -> bool:
        """True if the mind was taken up under this number: a program is handed one mind by a move."""
        return self.agent.embodiment.fence == transfer.fence and self.agent.embodiment.rests

    def _begin(self, transfer: MindTransfer, text: str) -> None:
        """Exchange the agent for one with this mind, at rest.

        :raises MindUnfit: if it cannot carry it on; the one before stays.
        """
        document = read_document(text)
        if document.fence != transfer.fence:
            raise MindUnfit(f"the document is of move {document.fence}, not of {transfer.fence}")
        body = self.agent.memory().body
        assert body is not None
        agent = self._make(self._link, None)
        # What the robot is was told by another program last.
        reason = agent.take_over(document, body=body.model_copy(update={"announced": None}))
        if reason is not None:
            raise MindUnfit(reason)
        self.agent = agent
        self._saved_s = float("-inf")

    def _answer(self, request: Message, performative: Performative, body: MindTransferReport) -> None:
        self._link.send(
            Message(
                performative=performative,
                sender=self.name,
                receiver=SERVICE,
                sent_at_s=self._clock.now_s(),
                in_reply_to=request.id,
                body=body,
            )
        )

    def _save_and_send(self) -> None:
        """What matters leaves once it is saved; without that it is said again."""
        now_s = self._clock.now_s()
        matters = any(not isinstance(one.body, Telemetry) for one in self._link.held)
        if not matters and now_s - self._saved_s < SAVED_EVERY_S:
            self._link.release()
        elif self._save():
            self._saved_s = now_s
            self._link.release()
        else:
            self._link.discard()

    def _save(self) -> bool:
        if self._store is None:
            return True
        try:
            self._store.save(self.agent.memory().model_dump_json())
        except OSError as error:
            logger.error("the memory of %s cannot be saved: %s", self.name, error)
            return False
        return True

    def _tell_seat(self) -> None:
        if self._seat is not None and self._speaks is not (not self.is_mute):
            self._speaks = not self.is_mute
            self._seat.speak(self.name, speaks=self._speaks)


class _Inbox:
    """What has arrived, without what the program itself takes. Implements `robots.link.Link`."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._passed: list[Message] = []

    def take(self) -> list[Message]:
        with suppress(LinkClosed):
            return list(self._link.receive())
        return []

    def pass_on(self, message: Message) -> None:
        self._passed.append(message)

    def send(self, message: Message) -> None:
        self._link.send(message)

    def receive(self, timeout_s: float = 0.0) -> list[Message]:
        passed = self._passed
        self._passed = []
        return passed

    def close(self) -> None:
        self._link.close()
