"""A robot's social level: it speaks with other robots in FIPA ACL (SRA, the social level).

What it is told is given to handlers by performative and the name of the content's term; what it has to say itself is
said by `say`. Messages are sent again until they are answered (`conversation.py`).
"""

import uuid
from collections.abc import Callable, Iterable, Sequence

from robots.clock import Clock
from robots.contract.mailbox import SERVICE
from robots.contract.memory import ConversationMemory, SocialMemory
from robots.executive.society import Situated
from robots.perception.percepts import Needs
from robots.social.acquaintances import Acquaintances
from robots.social.bidding import Bidding, Handler
from robots.social.conversation import Conversation, Conversations, OutOfProtocol
from robots.social.delegating import Delegating
from robots.social.peer_clearance import PeerClearance
from robots.social.persons import PersonsRequests, of_person
from robots.social.protocols import (
    ANY,
    CONTRACT_NET,
    INFORM,
    PROTOCOLS,
    ContractNetState,
    InteractionProtocol,
    Side,
)
from robots.social.speech import Ending, Heard, Reply, content_of
from robots.social.terms import ContentError, Term
from robots.wire import (
    MAX_TOLD_CONVERSATIONS,
    BehaviourPacket,
    BehaviourScript,
    Message,
    Performative,
    SpeechAct,
    ToldConversation,
)

ONTOLOGY = "macta-mission"
"""What the words of contents mean: scripts, actions, places and samples of the service's missions."""
TELLING = (Performative.INFORM, Performative.PROPOSE)
"""An answer by these is its content; one by others says enough without it."""
KEPT_ENDED = 64
"""The last conversations that have ended go on to another program, too (our choice)."""
ABILITIES = "abilities"
"""The term that lists what a robot can do; without arguments in a question for it."""

Ended = Callable[[Ending], None]
Listener = Callable[[Heard], bool]
"""Hears what no handler takes; False if it does not take it either."""


class SocialLevel:
    """Speaks for one robot. Implements `robots.executive.society.Society`."""

    def __init__(
        self,
        name: str,
        clock: Clock,
        *,
        abilities: Iterable[str] = (),
        round_trip_s: float = 0.0,
        takes_legs: bool = True,
    ) -> None:
        """
        :param abilities: what the robot says that it can do, if it is asked.
        :param takes_legs: it does legs that other robots award to it.
        :param round_trip_s: the longest travel time of a message to another robot and its answer together.
        """
        self.name = name
        self.acquaintances = Acquaintances()
        self.conversations = Conversations()
        self._clock = clock
        self.round_trip_s = round_trip_s
        self._handlers: dict[tuple[Performative, str], Handler] = {}
        self._abilities = Term(ABILITIES, tuple(sorted(abilities)))
        self._opened: dict[tuple[str, str], Ended] = {}
        self._outbox: list[Message] = []
        self._listener: Listener = lambda heard: False
        self._clearance = PeerClearance(self.say)
        self._bidding = Bidding(name, self.conversations, self._answer_later, takes_legs=takes_legs)
        self._bidding.register(self.on)
        self._delegating = Delegating(name, clock, self)
        self._persons = PersonsRequests(name, self._answer_later, self._is_open)
        self.on(Performative.INFORM, "ended", self._clearance.heard)
        self.on(Performative.QUERY_REF, ABILITIES, self._say_abilities)

    def on(self, performative: Performative, name: str, handler: Handler) -> None:
        """Have what opens a conversation with this performative and a term of this name handled; the handler is called
        once for each message that is not a repetition, and must be idempotent over restarts.
        """
        self._handlers[performative, name] = handler

    def listen(self, listener: Listener) -> None:
        """Have what no handler takes heard, and the answers in conversations that rules have opened."""
        self._listener = listener

    def say(
        self,
        performative: Performative,
        receiver: str,
        content: Term,
        *,
        protocol: InteractionProtocol,
        within_s: float,
        ended: Ended = lambda ending: None,
        is_of_rules: bool = False,
        conversation_id: str | None = None,
    ) -> Conversation:
        """Open a conversation.

        :param within_s: how long an answer is awaited.
        :param ended: called once with how it ended.
        :param is_of_rules: the listener hears the answers.
        :raises OutOfProtocol: if the protocol is not opened by this performative.
        """
        now_s = self._clock.now_s()
        conversation_id = conversation_id or uuid.uuid4().hex
        act = SpeechAct(
            content=str(content),
            ontology=ONTOLOGY,
            protocol=protocol.name,
            conversation_id=conversation_id,
            reply_by_s=now_s + within_s,
        )
        message = self._message(performative, receiver, act, now_s)
        conversation = Conversation(protocol, conversation_id, receiver, message, mine=True)
        conversation.is_of_rules = is_of_rules
        self.conversations.add(conversation)
        self._opened[receiver, conversation_id] = ended
        self._outbox.append(message)
        return conversation

    def go_on(self, performative: Performative, receiver: str, content: Term, *, within_s: float) -> bool:
        """Say this in the listener's newest conversation with the receiver in which it may be said now; False if
        there is none.
        """
        for one in reversed(list(self.conversations)):
            if receiver != (one.speaker or one.partner) or not one.is_of_rules:
                continue
            if not one.may_say(performative):
                continue
            self.say_in(one, performative, content, within_s=within_s if one.side is Side.INITIATOR else None)
            return True
        return False

    def say_in(
        self,
        conversation: Conversation,
        performative: Performative,
        content: Term,
        *,
        within_s: float | None = None,
        script: BehaviourScript | None = None,
    ) -> Message:
        """Say this in an open conversation.

        :param script: by which the other does what it is awarded.
        :raises OutOfProtocol: if it may not be said now.
        """
        now_s = self._clock.now_s()
        body = SpeechAct(
            content=str(content),
            ontology=ONTOLOGY,
            protocol=conversation.protocol.name,
            conversation_id=conversation.id,
            reply_by_s=None if within_s is None else now_s + within_s,
            script=script,
        )
        message = self._message(performative, conversation.partner, body, now_s, conversation.last_heard)
        conversation.say(message)
        self._outbox.append(message)
        return message

    def go_on_with(self, award: Message) -> Conversation:
        """A conversation that goes on after a power failure, in which this side has awarded a leg."""
        act = award.body
        assert isinstance(act, SpeechAct)
        conversation = Conversation(
            CONTRACT_NET,
            act.conversation_id,
            award.receiver,
            award,
            mine=True,
            state=ContractNetState.AWARDED,
        )
        self.conversations.add(conversation)
        self._opened[award.receiver, act.conversation_id] = lambda ending: None
        return conversation

    def step(self, arrived: Sequence[Message], robot: Situated) -> None:
        now_s = self._clock.now_s()
        for message in arrived:
            if isinstance(message.body, SpeechAct):
                self._hear(message, message.body, robot, now_s)
        self._clearance.step(now_s)
        self._bidding.step(robot, now_s)
        self._delegating.step(robot, now_s)
        self._persons.step(robot, now_s)
        for one in self.conversations.open_ones():
            again = one.step(
                now_s, round_trip_s=self.round_trip_s, heard_s=self.acquaintances.heard_s(one.partner)
            )
            if again is not None:
                self._outbox.append(again)
            if one.has_ended and (ended := self._opened.pop((one.partner, one.id), None)) is not None:
                ended(Ending(state=one.state, answer=one.answer, at_s=now_s))
        outbox = self._outbox
        self._outbox = []
        for message in outbox:
            robot.send(message)

    @property
    def needs(self) -> Needs:
        return self._persons.needs | self._delegating.needs

    def packet_ended(self, packet: BehaviourPacket) -> None:
        self._clearance.packet_ended(packet, self._clock.now_s())

    def told(self) -> tuple[ToldConversation, ...]:
        """The open conversations, the newest last, as they are told when the robot's mind is read."""
        open_ones = [one for one in self.conversations if not one.has_ended]
        return tuple(
            ToldConversation(
                id=one.id,
                protocol=one.protocol.name,
                partner=one.partner,
                state=one.state,
                is_mine=one.side is Side.INITIATOR,
                reply_by_s=one.reply_by_s if one.side is Side.INITIATOR else None,
            )
            for one in open_ones[-MAX_TOLD_CONVERSATIONS:]
        )

    def memory(self) -> SocialMemory:
        return SocialMemory(
            owed=self._clearance.memory(),
            awards=self._bidding.memory(),
            delegation=self._delegating.memory(),
            withdrawals=self._delegating.withdrawals(),
        )

    def hand_over(self) -> SocialMemory:
        """The memory with the conversations, for another program. What this side has opened for other ends than its
        rules' is opened again by what is left to say.
        """
        known = [one for one in self.conversations if one.side is Side.PARTICIPANT or one.is_of_rules]
        ended = [one for one in known if one.has_ended][-KEPT_ENDED:]
        more = {
            "conversations": tuple(one.memory() for one in known if not one.has_ended or one in ended),
            "bids": self._bidding.bids(),
            "withdrawn": self._bidding.withdrawals(),
            "requests": self._persons.memory(),
        }
        return self.memory().model_copy(update=more)

    def recall(self, memory: SocialMemory) -> None:
        now_s = self._clock.now_s()
        self._clearance.recall(memory.owed)
        self._bidding.recall((award, self._heard_before(award.message, now_s)) for award in memory.awards)
        self._delegating.recall(memory.delegation, memory.withdrawals)
        for one in memory.conversations:
            self._recall_conversation(one)
        bids = (
            (one, None if one.award is None else self._heard_before(one.award, one.awarded_s))
            for one in memory.bids
        )
        self._bidding.recall_bids(bids, memory.withdrawn)
        self._persons.recall((one, self._heard_before(one.message, one.at_s)) for one in memory.requests)

    def _recall_conversation(self, memory: ConversationMemory) -> None:
        """Go on with a conversation, if its protocol is known here."""
        protocol = PROTOCOLS.get(memory.protocol)
        if protocol is None:
            return
        answer = None if memory.answer is None else self._heard_before(memory.answer, memory.answered_s)
        self.conversations.add(Conversation.restored(protocol, memory, answer))
        if memory.is_mine:
            self._opened[memory.partner, memory.id] = lambda ending: None

    def _heard_before(self, message: Message, at_s: float) -> Heard:
        act = message.body
        assert isinstance(act, SpeechAct)
        return self._understood(message, act, at_s)

    def _hear(self, message: Message, act: SpeechAct, robot: Situated, now_s: float) -> None:
        self.acquaintances.hear(message.sender, now_s)
        known = self.conversations.of(act.conversation_id, message.sender)
        if known is not None and known.knows(message):
            known.note_repeated(message)
            # Whoever has opened the conversation repeats by itself; else two would repeat without end.
            if known.side is Side.PARTICIPANT and (again := known.say_again()) is not None:
                # So the other sees which of its messages has arrived.
                self._outbox.append(again.model_copy(update={"in_reply_to": message.id}))
            return
        if known is None and message.in_reply_to is not None:
            return  # an answer in a conversation that was before a restart, or is long over
        try:
            heard = self._understood(message, act, now_s)
            if known is None:
                known = self._opened_by(message, act, heard)
                handler = self._handler(heard)
                reply = _confirmed(heard, known) if handler is None else handler(heard, robot)
            else:
                if known.has_ended or known.is_past(message):
                    return  # its time is over, or messages have overtaken each other
                known.hear(message)
                if known.is_of_rules:
                    self._listener(heard)
                if (known.partner, known.id) in self._opened:
                    self._note_answer(known, heard)
                    return
                reply = self._reply(known, heard, robot)
        except (ContentError, OutOfProtocol) as error:
            self._not_understood(message, act, str(error), now_s)
            return
        if reply is not None:
            self._answer(known, message, act, reply, now_s)

    def _reply(self, conversation: Conversation, heard: Heard, robot: Situated) -> Reply | None:
        """The answer to what goes on in a conversation that another has opened. Rules answer by themselves."""
        if conversation.is_of_rules:
            return None
        handler = self._handler(heard)
        if handler is not None:
            return handler(heard, robot)
        if conversation.has_ended:
            return None
        return Reply(
            performative=Performative.NOT_UNDERSTOOD, content=Term("reason", (self._untaken(heard),))
        )

    def _untaken(self, heard: Heard) -> str:
        """Why nobody here takes what was heard."""
        every = {**self._handlers, **(self._persons.handlers if heard.person else {})}
        known = sorted(word for performative, word in every if performative is heard.performative)
        return (
            f"{self.name} does not take {heard.performative} of {heard.content.name!r}; it takes "
            f"{', '.join(known) or 'nothing of that kind'}"
        )

    def _understood(self, message: Message, act: SpeechAct, now_s: float) -> Heard:
        """:raises ContentError: if the language or the content is not known here."""
        return Heard(
            performative=message.performative,
            sender=message.sender,
            person=act.speaker if of_person(act, message.sender, SERVICE) else "",
            content=content_of(message.performative, act),
            message=message,
            at_s=now_s,
        )

    def _note_answer(self, conversation: Conversation, heard: Heard) -> None:
        conversation.answer = heard
        if heard.key == (Performative.INFORM, ABILITIES):
            self.acquaintances.hear(heard.sender, heard.at_s, frozenset(heard.content.words))

    def _say_abilities(self, heard: Heard, robot: Situated) -> Reply:
        return Reply(performative=Performative.INFORM, content=self._abilities)

    def _opened_by(self, message: Message, act: SpeechAct, heard: Heard) -> Conversation:
        """:raises OutOfProtocol: if nobody here answers what the message is about."""
        protocol = PROTOCOLS.get(act.protocol)
        if protocol is None:
            choices = ", ".join(PROTOCOLS)
            raise OutOfProtocol(f"the protocol {act.protocol!r} is not known here; choices: {choices}")
        conversation = Conversation(protocol, act.conversation_id, message.sender, message, mine=False)
        conversation.speaker = heard.person
        has_handler = self._handler(heard) is not None
        if not has_handler:
            conversation.is_of_rules = self._listener(heard)
        if not has_handler and not conversation.is_of_rules:
            raise OutOfProtocol(self._untaken(heard))
        self.conversations.add(conversation)
        return conversation

    def _handler(self, heard: Heard) -> Handler | None:
        """Who handles it; what a person says may mean more than the same of a robot."""
        of_persons = self._persons.handlers.get(heard.key) if heard.person else None
        return of_persons or self._handlers.get(heard.key)

    def _is_open(self, heard: Heard) -> bool:
        act = heard.message.body
        assert isinstance(act, SpeechAct)
        known = self.conversations.of(act.conversation_id, heard.sender)
        return known is not None and not known.has_ended

    def _answer_later(self, heard: Heard, reply: Reply) -> None:
        act = heard.message.body
        if isinstance(act, SpeechAct) and (known := self.conversations.of(act.conversation_id, heard.sender)):
            self._answer(known, heard.message, act, reply, self._clock.now_s())

    def _answer(
        self, conversation: Conversation, message: Message, act: SpeechAct, reply: Reply, now_s: float
    ) -> None:
        """Say it if the conversation still allows it. What tells something too long becomes a failure or a refusal."""
        tells_too_much = reply.is_too_long and reply.performative in TELLING
        choices = (Performative.FAILURE, Performative.REFUSE) if tells_too_much else (reply.performative,)
        performative = next((one for one in choices if conversation.may_say(one)), None)
        if performative is None:
            return
        body = SpeechAct(
            content=reply.text,
            ontology=act.ontology,
            protocol=act.protocol,
            conversation_id=act.conversation_id,
        )
        answer = self._message(performative, message.sender, body, now_s, message.id)
        conversation.say(answer)
        self._outbox.append(answer)

    def _not_understood(self, message: Message, act: SpeechAct, reason: str, now_s: float) -> None:
        """Say so; never of a not-understood, or two robots would not come to an end."""
        if message.performative is Performative.NOT_UNDERSTOOD:
            return
        body = SpeechAct(
            content=str(Term("reason", (reason[:300],))),
            ontology=act.ontology,
            protocol=act.protocol,
            conversation_id=act.conversation_id,
        )
        self._outbox.append(
            self._message(Performative.NOT_UNDERSTOOD, message.sender, body, now_s, message.id)
        )

    def _message(
        self,
        performative: Performative,
        receiver: str,
        act: SpeechAct,
        now_s: float,
        in_reply_to: str | None = None,
    ) -> Message:
        return Message(
            performative=performative,
            sender=self.name,
            receiver=receiver,
            sent_at_s=now_s,
            in_reply_to=in_reply_to,
            body=act,
        )


def _confirmed(heard: Heard, conversation: Conversation) -> Reply | None:
    """What is answered at once to what rules hear: the confirmation of an inform, and of what stands outside of FIPA's
    protocols; they answer the rest themselves.
    """
    if conversation.protocol not in (INFORM, ANY):
        return None
    return Reply(performative=Performative.CONFIRM, content=heard.content)
