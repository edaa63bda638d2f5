"""One side's view of a conversation with one partner, and the only code that changes its state.

Who opened it repeats its last message until the conversation ends or its time is over; who was spoken to answers a
repetition with what it said last. So whatever is lost on the way is said again, and nothing is handled twice. The time
is the one that its opener has said last (`reply_by_s`); both sides end it then.
"""

from collections import OrderedDict
from collections.abc import Iterator

from robots.contract.memory import ConversationMemory
from robots.errors import RobotError
from robots.social.protocols import CANCELLED, TIMED_OUT, InteractionProtocol, Side
from robots.social.speech import Heard
from robots.wire import Message, Performative, SpeechAct

RESEND_S = 2.0
"""A message is repeated this long after its answer could have arrived (world's clock)."""
LONGEST_PAUSE_S = 8.0
"""The longest pause between two repetitions."""
MAX_CONVERSATIONS = 512
"""Of one robot; beyond it the oldest that has ended is forgotten, or the oldest if none has."""


class OutOfProtocol(RobotError):
    """Raised when a message may not be said in a conversation's state; says what may be."""


class Conversation:
    """A conversation by one protocol. `state` is one of the protocol's, or one of its common ends."""

    def __init__(
        self,
        protocol: InteractionProtocol,
        conversation_id: str,
        partner: str,
        first: Message,
        *,
        mine: bool,
        state: str | None = None,
    ) -> None:
        """
        :param mine: this side has opened it by the first message.
        :param state: of one that goes on after a power failure; `first` is then the initiator's last message.
        :raises OutOfProtocol: if the message does not open a conversation of the protocol.
        """
        if state is None and first.performative not in protocol.opens:
            raise OutOfProtocol(
                f"{protocol.name} is opened by {' or '.join(protocol.opens)}, not by {first.performative}"
            )
        self.protocol = protocol
        self.id = conversation_id
        self.partner = partner
        self.side = Side.INITIATOR if mine else Side.PARTICIPANT
        self.state = protocol.opens[first.performative] if state is None else state
        self.last_said: Message | None = None
        """By this side."""
        self.is_of_rules = False
        """The robot's rules hear it and speak in it."""
        self.speaker = ""
        """The person for whom the partner speaks; empty if it speaks for itself."""
        self.answer: Heard | None = None
        """What the partner has said last, if this side has opened it."""
        self.last_heard: str | None = None
        """The id of the partner's last message."""
        self._heard: set[str] = {first.in_reply_to} if mine and first.in_reply_to else set()
        self._said_s = first.sent_at_s
        self._pause_s = 0.0
        self._has_arrived = False
        self.reply_by_s: float | None = None
        self._note(first, mine=mine)

    def memory(self) -> ConversationMemory:
        """For another program that goes on with it."""
        return ConversationMemory(
            protocol=self.protocol.name,
            id=self.id,
            partner=self.partner,
            is_mine=self.side is Side.INITIATOR,
            state=self.state,
            last_said=self.last_said,
            is_of_rules=self.is_of_rules,
            speaker=self.speaker,
            last_heard=self.last_heard,
            heard=tuple(sorted(self._heard)),
            said_s=self._said_s,
            pause_s=self._pause_s,
            has_arrived=self._has_arrived,
            reply_by_s=self.reply_by_s,
            answer=None if self.answer is None else self.answer.message,
            answered_s=0.0 if self.answer is None else self.answer.at_s,
            has_ended=self.has_ended,
        )

    @classmethod
    def restored(
        cls, protocol: InteractionProtocol, memory: ConversationMemory, answer: Heard | None
    ) -> "Conversation":
        """The conversation as it was; `answer`: the memory's, understood again."""
        one = cls.__new__(cls)
        one.protocol = protocol
        one.id = memory.id
        one.partner = memory.partner
        one.side = Side.INITIATOR if memory.is_mine else Side.PARTICIPANT
        one.state = memory.state
        one.last_said = memory.last_said
        one.is_of_rules = memory.is_of_rules
        one.speaker = memory.speaker
        one.answer = answer
        one.last_heard = memory.last_heard
        one._heard = set(memory.heard)
        one._said_s = memory.said_s
        one._pause_s = memory.pause_s
        one._has_arrived = memory.has_arrived
        one.reply_by_s = memory.reply_by_s
        return one

    @property
    def has_ended(self) -> bool:
        return self.protocol.has_ended(self.state)

    def knows(self, message: Message) -> bool:
        """True if the partner repeats what it has said."""
        return message.id in self._heard

    def is_past(self, message: Message) -> bool:
        """True for what opens a conversation, once this one has gone on: a late copy that is not known since a power
        failure.
        """
        opened = self.protocol.opens.get(message.performative)
        return self.side is Side.PARTICIPANT and opened is not None and opened != self.state

    def note_repeated(self, message: Message) -> None:
        """The partner has repeated what it said: it has heard what this side said last, and is not done yet."""
        if self.side is Side.INITIATOR and message.id == self.last_heard and self.last_said is not None:
            self._has_arrived = self.last_said.in_reply_to == message.id

    def hear(self, message: Message) -> None:
        """:raises OutOfProtocol: if the partner may not say this now."""
        self._advance(
            message.performative, Side.PARTICIPANT if self.side is Side.INITIATOR else Side.INITIATOR
        )
        self._note(message, mine=False)

    def may_say(self, performative: Performative) -> bool:
        """True if this side may say this now."""
        return self.protocol.after(self.state, self.side, performative) is not None

    def say(self, message: Message) -> None:
        """:raises OutOfProtocol: if this side may not say this now."""
        self._advance(message.performative, self.side)
        self._note(message, mine=True)

    def step(self, now_s: float, *, round_trip_s: float, heard_s: float) -> Message | None:
        """End the conversation if its time is over; what is to be repeated now, if anything is.

        :param heard_s: when the partner was last heard.
        """
        if self.has_ended:
            return None
        if self.reply_by_s is not None and now_s >= self.reply_by_s:
            self.state = TIMED_OUT
            return None
        if self.side is Side.PARTICIPANT or self.last_said is None:
            return None
        interval_s = round_trip_s + RESEND_S
        pause_s = interval_s if heard_s > self._said_s else max(self._pause_s, interval_s)
        if self._has_arrived:
            pause_s = max(LONGEST_PAUSE_S, interval_s)
        if now_s - self._said_s < pause_s:
            return None
        self._said_s = now_s
        self._pause_s = max(min(2 * pause_s, LONGEST_PAUSE_S), interval_s)
        return self.say_again()

    def say_again(self) -> Message | None:
        """What this side said last, counted as said once more."""
        said = self.last_said
        if said is not None and isinstance(said.body, SpeechAct):
            body = said.body.model_copy(update={"attempt": said.body.attempt + 1})
            self.last_said = said.model_copy(update={"body": body})
        return self.last_said

    def take_time(self, until_s: float | None = None) -> None:
        """Wait for the next word until then; None: for as long as that takes."""
        self.reply_by_s = until_s

    def cancel(self) -> None:
        """Give it up without a word."""
        if not self.has_ended:
            self.state = CANCELLED

    def _advance(self, performative: Performative, side: Side) -> None:
        after = self.protocol.after(self.state, side, performative)
        if after is None:
            may = [one for who, one in self.protocol.transitions.get(self.state, {}) if who is side]
            raise OutOfProtocol(
                f"{performative} by the {side} does not follow in {self.protocol.name}, which is {self.state}"
                + (f"; {' or '.join(may)} may" if may else "")
            )
        self.state = after

    def _note(self, message: Message, *, mine: bool) -> None:
        if mine == (self.side is Side.INITIATOR) and isinstance(message.body, SpeechAct):
            self.reply_by_s = message.body.reply_by_s
        if not mine:
            self._heard.add(message.id)
            self.last_heard = message.id
            return
        self.last_said = message
        self._said_s = message.sent_at_s
        self._pause_s = 0.0
        self._has_arrived = False


class Conversations:
    """One robot's conversations, by their ids and partners, the newest last."""

    def __init__(self) -> None:
        self._known: OrderedDict[str, Conversation] = OrderedDict()
        self._open: dict[str, Conversation] = {}
        """Those that have not ended."""

    def __iter__(self) -> Iterator[Conversation]:
        return iter(self._known.values())

    def of(self, conversation_id: str, partner: str) -> Conversation | None:
        return self.at(key_of(conversation_id, partner))

    def at(self, key: str) -> Conversation | None:
        """The conversation of that key, see `key_of`."""
        return self._known.get(key)

    def add(self, conversation: Conversation) -> None:
        key = key_of(conversation.id, conversation.partner)
        self._known[key] = conversation
        if len(self._known) > MAX_CONVERSATIONS:
            oldest = next(iter(self._known))
            ended = next((old for old, one in self._known.items() if one.has_ended), oldest)
            self._known.pop(ended).cancel()
        self._open[key] = conversation

    def open_ones(self) -> list[Conversation]:
        """Those that have not ended, or have since this was called last."""
        open_ones = list(self._open.values())
        self._open = {key: one for key, one in self._open.items() if not one.has_ended}
        return open_ones


def key_of(conversation_id: str, partner: str) -> str:
    return f"{partner}/{conversation_id}"
