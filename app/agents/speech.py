"""The service's own speech with robots, in FIPA ACL over their ordinary link (SRA, the social level).

Conversations are kept in the database: whichever process holds the world's lease says what is due and hears the
answers, and a restart loses nothing. What is said is in the event log.
"""

import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError
from sqlalchemy import Select, delete, or_, select
from sqlalchemy.orm import Session

from app.agents.communications import SERVICE
from app.agents.running_world import FLAT_OUT
from app.core import Core
from app.domain.errors import Conflict, Invalid
from app.domain.events import SpeechSaid
from app.domain.ids import new_id
from app.domain.lifecycles import conversation as life
from app.domain.lifecycles.conversation import OutOfProtocol
from app.domain.lifecycles.goal import GoalState
from app.store import ConversationRow, GoalRow
from app.store.known_empty import KnownEmpty
from robots.clock import Clock
from robots.social import ContentError, Term, content_of, parse_term
from robots.social.protocols import INFORM, InteractionProtocol
from robots.social.speech import TOO_LONG
from robots.wire import MAX_CONTENT, TERMS, Message, Performative, SpeechAct, new_message_id
from robots.world import WorldFile

ONTOLOGY = "macta-mission"
KEPT = 200
"""Conversations of one robot; beyond it the oldest of those that are over and no longer needed are forgotten."""

Listener = Callable[[Session, ConversationRow], None]
"""Is told of an answer, or of an end without one, in the transaction that records it; the row says which."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Speech:
    """A message to a robot, to be sent now.

    :param ends: it ends its conversation, so that nothing answers it; report it by `was_said`.
    """

    robot: str
    message_id: str
    performative: Performative
    act: SpeechAct
    in_reply_to: str | None
    ends: bool = False


class SpeechService:
    """Opens conversations with robots, hears what they answer, and answers what they open."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: Mapping[str, WorldFile],
        clocks: Mapping[str, Clock],
        paces: Mapping[str, Callable[[], float | None]] | None = None,
    ) -> None:
        """:param paces: by world, its seconds per wall-clock second now, None: as fast as possible; default: 1."""
        self._paces = paces or {}
        self._database = core.database
        self._none_open = KnownEmpty(core.database, ConversationRow)
        self._events = core.events
        self._worlds = worlds
        self._clocks = clocks
        self._listeners: dict[str, Listener] = {}

    def listen(self, opener: str, listener: Listener) -> None:
        """Pass the answers to what `opener` has said, and the ends of its conversations, to a listener."""
        self._listeners[opener] = listener

    def patience_s(self, world: str, robot: str, wall_s: float) -> float:
        """World's seconds in which a robot can answer: what its radio takes, and `wall_s` by the wall clock.

        A simulated world that runs faster than real time leaves its robots and the service no more time to compute.
        """
        pace = self._paces[world]() if world in self._paces else 1.0
        return self._worlds[world].links[robot].answer_s + wall_s * max(
            1.0, FLAT_OUT if pace is None else pace
        )

    def unheard_reason(self, world: str, robot: str, what: str) -> str:
        """Why a robot does not take what is said, such as `bids`; empty if it does."""
        file = self._worlds[world]
        spec = file.robots_by_name.get(robot)
        if spec is None:
            return f"{world} has no robot {robot}"
        if file.speaks(spec, what):
            return ""
        said = ", ".join(spec.speaks or ()) or "nothing"
        if spec.speaks is None:
            return f"software of its own drives {robot}, and nothing states that it speaks {what}"
        return f"{robot} does not speak {what}; it speaks {said}"

    def open(
        self,
        session: Session,
        *,
        world: str,
        robot: str,
        what: str,
        performative: Performative,
        content: Term,
        protocol: InteractionProtocol,
        within_s: float,
        opener: str,
        about: str = "",
        speaker: str = "",
        conversation_id: str | None = None,
    ) -> ConversationRow:
        """Open a conversation; it is repeated until the robot answers or `within_s` of the world's clock is over.

        :param what: what the robot must speak to take it, such as `bids`.
        :param opener: whose listener hears of the answers. :param about: the goal, plan or mission that it is about.
        :param speaker: the person on whose behalf it is said.
        :param conversation_id: of a conversation with several robots, one row each.
        :raises Conflict: if the robot does not speak that.
        :raises Invalid: if the content is longer than a message holds.
        """
        if reason := self.unheard_reason(world, robot, what):
            raise Conflict(reason, code="robot-does-not-speak")
        row = ConversationRow(
            id=conversation_id or new_id("conversation"),
            robot=robot,
            world=world,
            protocol=protocol.name,
            is_ours=True,
            opener=opener,
            about=about,
            speaker=speaker,
            said=[],
        )
        life.open_conversation(row, performative)
        self._add(session, row)
        self._note(session, row, performative, content, within_s=within_s)
        return row

    def say(
        self,
        session: Session,
        row: ConversationRow,
        performative: Performative,
        content: Term,
        *,
        within_s: float | None = None,
    ) -> None:
        """Go on with a conversation. :param within_s: how long an answer is awaited; None: for as long as it takes.

        :raises OutOfProtocol: if it may not be said now.
        :raises Invalid: if the content is longer than a message holds.
        """
        life.say(row, performative)
        self._note(session, row, performative, content, within_s=within_s)

    def take_time(self, row: ConversationRow) -> None:
        """Have the conversation wait for the service's next word, for as long as that takes."""
        row.reply_by_s = None

    def ask_again(self, row: ConversationRow, *, wall_s: float) -> None:
        """Have what was said last repeated: the robot's last answer may have been lost."""
        life.ask_again(row)
        row.reply_by_s = self._clocks[row.world].now_s() + self.patience_s(row.world, row.robot, wall_s)

    def cancel(self, row: ConversationRow, reason: str) -> None:
        """Give a conversation up without a word."""
        life.cancel(row, reason)

    def of_robot(self, robot: str, *, limit: int) -> Sequence[ConversationRow]:
        """The robot's conversations with the service, the newest first."""
        query = select(ConversationRow).where(ConversationRow.robot == robot)
        with self._database.read() as session:
            newest = query.order_by(ConversationRow.opened_at.desc(), ConversationRow.id).limit(limit)
            return session.scalars(newest).all()

    def due(self, world: str) -> list[Speech]:
        """What is to be said until it is answered, or once if it ends its conversation.

        Conversations whose time is over end here.
        """
        rows = self._none_open.read(world, lambda: self._open(world))
        now_s = self._clocks[world].now_s()
        late = [
            row for row in rows if not row.is_over and row.reply_by_s is not None and now_s >= row.reply_by_s
        ]
        if late:
            self._end_late(late, now_s)
        wanted = [row for row in rows if life.is_to_be_said(row) and row not in late]
        return [one for one in map(_sendable, wanted) if one is not None]

    def _open(self, world: str) -> Sequence[ConversationRow]:
        """The conversations that are not over, or whose end is still to be said."""
        query = select(ConversationRow).where(
            ConversationRow.world == world, or_(ConversationRow.is_over.is_(False), ConversationRow.is_due)
        )
        with self._database.read() as session:
            return session.scalars(query.order_by(ConversationRow.opened_at, ConversationRow.robot)).all()

    def was_said(self, one: Speech) -> None:
        """Record that what ends a conversation was sent."""
        with self._database.write() as session:
            key = (one.act.conversation_id, one.robot)
            row = session.get(ConversationRow, key, with_for_update=True)
            if row is not None:
                life.was_said(row)

    def hear(self, world: str, message: Message, act: SpeechAct) -> list[Speech]:
        """Record what a robot says; what is to be sent at once. In the service's own conversations it is `due`."""
        with self._database.write() as session:
            key = (act.conversation_id, message.sender)
            self._database.lock(session, "/".join(key))
            row = session.get(ConversationRow, key, with_for_update=True)
            if row is None:
                return self._opened(session, world, message, act)
            return self._answered(session, row, message, act)

    def _answered(
        self, session: Session, row: ConversationRow, message: Message, act: SpeechAct
    ) -> list[Speech]:
        heard_last = next((one for one in reversed(row.said) if one["sender"] != SERVICE), None)
        repeats = heard_last is not None and heard_last["performative"] == message.performative.value
        if any(one["id"] == message.id for one in row.said) or (row.is_ours and repeats):
            if row.is_ours:
                # A robot repeats itself when it has heard what was said last, but cannot answer it yet. A late copy of
                # what it said before says nothing of that.
                if message.in_reply_to == _last_said(row)["id"]:
                    life.stop_repeating(row)
                return []
            return [_speech(row)] if row.said[-1]["sender"] == SERVICE else []
        if row.is_over:
            return []
        try:
            life.hear(row, message.performative, _reason(content_of(message.performative, act)))
        except (ContentError, OutOfProtocol) as error:
            return self.not_understood(message, act, str(error))
        self._hear(session, row, message, act)
        if (listener := self._listeners.get(row.opener)) is not None:
            listener(session, row)
        return []

    def _opened(self, session: Session, world: str, message: Message, act: SpeechAct) -> list[Speech]:
        """Record what a robot tells, and confirm it; nothing else that it opens is understood."""
        if message.in_reply_to is not None:
            return []  # an answer in a conversation that is long over
        row = ConversationRow(
            id=act.conversation_id,
            robot=message.sender,
            world=world,
            protocol=act.protocol,
            is_ours=False,
            said=[],
        )
        try:
            content = content_of(message.performative, act)
            life.open_conversation(row, message.performative)
            if row.protocol != INFORM.name:
                raise OutOfProtocol(f"the service does not take {message.performative} of {content.name!r}")
        except (ContentError, OutOfProtocol) as error:
            return self.not_understood(message, act, str(error))
        self._add(session, row)
        self._hear(session, row, message, act)
        is_too_long = len(str(content)) > MAX_CONTENT  # as it is written here
        self.say(session, row, Performative.CONFIRM, TOO_LONG if is_too_long else content)
        return [_speech(row)]

    def not_understood(self, message: Message, act: SpeechAct, reason: str) -> list[Speech]:
        """The answer to what cannot be taken; nothing is recorded."""
        if message.performative is Performative.NOT_UNDERSTOOD:
            return []  # or two would not come to an end
        logger.debug("%s is not understood: %s", message.sender, reason)
        answer = act.model_copy(
            update={"content": str(Term("reason", (reason[:300],))), "language": TERMS, "reply_by_s": None}
        )
        return [
            Speech(
                robot=message.sender,
                message_id=new_message_id(),
                performative=Performative.NOT_UNDERSTOOD,
                act=answer,
                in_reply_to=message.id,
            )
        ]

    def _end_late(self, rows: Sequence[ConversationRow], now_s: float) -> None:
        with self._database.write() as session:
            for known in sorted(rows, key=lambda one: (one.id, one.robot)):
                row = session.get(ConversationRow, (known.id, known.robot), with_for_update=True)
                if row is None or row.is_over or row.reply_by_s is None or now_s < row.reply_by_s:
                    continue
                life.time_out(row, f"{row.robot} has not answered in time")
                if (listener := self._listeners.get(row.opener)) is not None:
                    listener(session, row)

    def _add(self, session: Session, row: ConversationRow) -> None:
        """Record a new conversation, and forget the robot's oldest."""
        of_robot = (ConversationRow.world == row.world, ConversationRow.robot == row.robot)
        newest = select(ConversationRow.id).where(*of_robot).order_by(ConversationRow.opened_at.desc())
        old = session.scalars(newest.offset(KEPT - 1)).all()
        if old:
            # The answers to a goal's calls are read once all have come.
            planned = select(GoalRow.id).where(
                GoalRow.world == row.world, GoalRow.state == GoalState.PLANNING
            )
            done = (
                ConversationRow.id.in_(old),
                ConversationRow.is_over,
                ConversationRow.is_due.is_(False),
                ConversationRow.about.not_in(planned),
            )
            session.execute(delete(ConversationRow).where(*of_robot, *done))
        session.add(row)

    def _note(
        self,
        session: Session,
        row: ConversationRow,
        performative: Performative,
        content: Term,
        *,
        within_s: float | None,
    ) -> None:
        written = str(content)
        if len(written) > MAX_CONTENT:
            detail = (
                f"that is {len(written)} characters as it is sent, with what is not ASCII escaped; "
                f"{row.robot} is sent at most {MAX_CONTENT}"
            )
            raise Invalid(detail, code="too-long-to-say")
        now_s = self._clocks[row.world].now_s()
        heard = next((one["id"] for one in reversed(row.said) if one["sender"] != SERVICE), "")
        row.reply_by_s = None if within_s is None else now_s + within_s
        self._record(
            session,
            row,
            {
                "id": new_message_id(),
                "sender": SERVICE,
                "receiver": row.robot,
                "performative": performative.value,
                "content": written,
                "in_reply_to": heard,
                "sent_at_s": now_s,
                "at_s": now_s,
            },
        )

    def _hear(self, session: Session, row: ConversationRow, message: Message, act: SpeechAct) -> None:
        self._record(
            session,
            row,
            {
                "id": message.id,
                "sender": message.sender,
                "receiver": SERVICE,
                "performative": message.performative.value,
                "content": act.content,
                "in_reply_to": message.in_reply_to or "",
                "sent_at_s": message.sent_at_s,
                "at_s": self._clocks[row.world].now_s(),
            },
        )

    def _record(self, session: Session, row: ConversationRow, said: dict[str, Any]) -> None:
        row.said = [*row.said, said]
        session.flush()
        told = {name: value for name, value in said.items() if name != "id"}
        self._events.append(
            session,
            SpeechSaid(
                subject=row.about or row.robot,
                world=row.world,
                protocol=row.protocol,
                conversation=row.id,
                message=said["id"],
                speaker=row.speaker if said["sender"] == SERVICE else "",
                **told,
            ),
        )


def in_order(query: Select[ConversationRow]) -> Select[ConversationRow]:
    """The order in which all who lock several conversations lock them."""
    return query.order_by(ConversationRow.id, ConversationRow.robot)


def end_with_robots(session: Session, world: str, here: Collection[str]) -> None:
    """Have conversations with robots that the world no longer has time out, so that nobody waits for their answers.

    What was still to be sent to them is not.
    """
    unfinished = or_(ConversationRow.is_over.is_(False), ConversationRow.is_due)
    gone = (ConversationRow.world == world, ConversationRow.robot.not_in(here), unfinished)
    for row in session.scalars(in_order(select(ConversationRow).where(*gone)).with_for_update()):
        row.reply_by_s = 0.0
        if row.is_over:
            life.drop(row, row.reason)


def end_conversations(session: Session, world: str, reason: str) -> None:
    """Give up all conversations with the robots of a world."""
    unfinished = or_(ConversationRow.is_over.is_(False), ConversationRow.is_due)
    for row in session.scalars(select(ConversationRow).where(ConversationRow.world == world, unfinished)):
        life.drop(row, reason)


def last_heard(row: ConversationRow) -> tuple[Performative, Term] | None:
    """What the robot has said last; None if it has said nothing."""
    for one in reversed(row.said):
        if one["sender"] != SERVICE:
            performative = Performative(one["performative"])
            try:
                return performative, parse_term(one["content"])
            except ContentError:  # only a not-understood may be in no language
                return performative, Term("reason", (one["content"],))
    return None


def _sendable(row: ConversationRow) -> Speech | None:
    """What the service has said last; None if no message holds it, which must not keep others from being sent."""
    try:
        return _speech(row)
    except ValidationError as error:
        logger.error("what is said to %s in conversation %s cannot be sent: %s", row.robot, row.id, error)
        return None


def _speech(row: ConversationRow) -> Speech:
    """What the service has said last, as it is sent."""
    said = _last_said(row)
    return Speech(
        robot=row.robot,
        message_id=said["id"],
        performative=Performative(said["performative"]),
        act=SpeechAct(
            content=said["content"],
            ontology=ONTOLOGY,
            protocol=row.protocol,
            conversation_id=row.id,
            reply_by_s=row.reply_by_s,
            speaker=row.speaker,
        ),
        in_reply_to=said["in_reply_to"] or None,
        ends=row.is_over and row.is_ours,
    )


def _last_said(row: ConversationRow) -> Mapping[str, Any]:
    """What the service has said last."""
    return next(one for one in reversed(row.said) if one["sender"] == SERVICE)


def _reason(content: Term) -> str:
    """What an answer says in words: the last argument of a refusal, a failure or a not-understood."""
    return content.words[-1] if content.args else content.name
