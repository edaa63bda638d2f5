"""Agent models (MACTA §4, fig. 4): deliver scripts and orders until robots answer, and record what robots report.

What is still to be delivered is read from the database, so a restart loses nothing.
"""

import logging
import threading
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from typing import Protocol

from sqlalchemy import Row, Select, or_, select, union

from app.agents.communications import MIN_RESEND_S, Communications
from app.agents.edition_delivery import EditionDelivery
from app.agents.questions import Questions
from app.agents.robot_board import RobotBoard
from app.agents.rules import RuleService
from app.agents.speech import Speech, SpeechService
from app.agents.teleoperation import Teleoperation
from app.agents.tuning import TuningService
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.lifecycles.mission import OPEN, MissionState
from app.domain.lifecycles.script import Delivery, order_label, unanswered_order
from app.store import Database, MissionRow, ScriptRow, is_unavailable
from app.store.known_empty import KnownEmpty
from app.workflows.background import Background
from robots.clock import Clock
from robots.link import Link, LinkClosed
from robots.wire import (
    WORLD,
    BehaviourScript,
    Clearance,
    ControlVerb,
    Factsheet,
    FactsheetAnswer,
    FactsheetState,
    ForeignState,
    Message,
    MindOrder,
    MindOrderReport,
    MindTransfer,
    MindTransferReport,
    MindVerb,
    NotUnderstood,
    Performative,
    Receipt,
    Refusal,
    Retune,
    RuleSet,
    RulesReport,
    ScriptRequest,
    SpeechAct,
    StatusQuery,
    Telemetry,
    TuningReport,
    UnknownBody,
    UnknownKinds,
    WorldEdition,
)
from robots.world import LinkSpec

RECEIVE_S = 0.05
DELIVER_S = 1.0
"""Wall-clock seconds between two checks whether robots are heard again, and after a turn that failed."""
IDLE_DELIVER_S = 5.0
"""Wall-clock seconds between two deliveries while nothing is unanswered and nothing was written: the notification of a
message may be lost."""

TUNING = "tuning"
RULES = "rules"
MIND = "mind"
TRANSFER = "transfer"
"""In the ids of messages that bring them, or orders to minds."""
MAX_DIGITS = 10
"""Of the version of a tuning or of rules."""

logger = logging.getLogger(__name__)


class Reception(Enum):
    """How a report was handled."""

    RECORDED = auto()
    """It is recorded, with its consequences."""
    IGNORED = auto()
    """It is a duplicate, or concerns no known script."""
    HELD_BACK = auto()
    """It is implausible so far: no receipt is sent, so the robot repeats it."""


class ReportRecorder(Protocol):
    """Records what robots report of their scripts, with all consequences."""

    def record_all(self, messages: Sequence[Message], world: str) -> Sequence[Reception]:
        """Record reports, each once, in one transaction."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class FactsheetReply:
    """What a robot is told of its factsheet, which the message brought."""

    robot: str
    message_id: str
    state: FactsheetState
    reason: str


class FactsheetKeeper(Protocol):
    """Keeps robots' factsheets."""

    def due(self, world: str) -> Sequence[FactsheetReply]:
        """Follow those that had to wait; the answers to send now, which then count as sent."""
        ...


class DueOrder(Protocol):
    """An order to a robot's mind that it has not answered."""

    @property
    def robot(self) -> str: ...

    @property
    def order(self) -> MindOrder | MindTransfer: ...


class EmbodimentKeeper(Protocol):
    """Moves robots' minds from body to body."""

    def due(self, world: str) -> Sequence[DueOrder]:
        """The orders that robots of the world have not answered."""
        ...

    def has_leases(self, world: str) -> bool:
        """Whether robots of the world have leases, which are to be renewed in time."""
        ...

    def record_answer(
        self, world: str, robot: str, performative: Performative, report: MindOrderReport
    ) -> None:
        """Record a robot's answer to an order to its mind."""
        ...

    def record_transfer(
        self, world: str, robot: str, performative: Performative, report: MindTransferReport
    ) -> None:
        """Record whether a robot's own software takes a mind."""
        ...


class AgentModels:
    """The agent models of one world's robots, on one link, in one thread."""

    def __init__(
        self,
        *,
        robots: Callable[[], Mapping[str, LinkSpec]],
        link: Link,
        clock: Clock,
        database: Database,
        reports: ReportRecorder,
        board: RobotBoard,
        questions: Questions,
        teleoperation: Teleoperation,
        tunings: TuningService,
        rules: RuleService,
        speech: SpeechService | None = None,
        readmit: Callable[[], None],
        record_batteries: Callable[[], None] = lambda: None,
        world: str,
        has_lease: Callable[[], bool] = lambda: True,
        each_turn: Callable[[], None] = lambda: None,
        editions: EditionDelivery | None = None,
        factsheets: FactsheetKeeper | None = None,
        embodiments: EmbodimentKeeper | None = None,
        foreign: Callable[[], ForeignState | None] = lambda: None,
        wall: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """
        :param robots: those of the world now, each with its radio.
        :param clock: the world's.
        :param speech: the service's conversations with robots; None: it does not speak with them.
        :param readmit: restores robots that were declared lost as silent and are heard again.
        :param record_batteries: records the batteries that robots have told of; called once a second.
        :param has_lease: True while this process, of those that share the database, delivers and records. Otherwise it
            only keeps the robots' current state and passes on the questions of its own clients.
        :param each_turn: called in each turn of the loop, before messages are received.
        :param editions: tells the world of its changes; None: it never changes.
        :param factsheets: of robots that announce themselves; None: nobody answers them.
        :param embodiments: moves robots' minds; None: nobody does.
        :param foreign: what the world is to be told now of robots that it does not simulate.
        """
        self._links = robots
        self._world = world
        self._communications = Communications(
            link,
            clock=clock,
            link_of=lambda name: LinkSpec() if name == WORLD else robots()[name],
            heard_s=lambda name: None if name == WORLD else board.view(name).heard_s,
            wall=wall,
        )
        self._database = database
        self._reports = reports
        self._board = board
        self._questions = questions
        self._teleoperation = teleoperation
        self._tunings = tunings
        self._rules = rules
        self._speech = speech
        self._readmit = readmit
        self._record_batteries = record_batteries
        self._has_lease = has_lease
        self._each_turn = each_turn
        self._editions = editions
        self._factsheets = factsheets
        self._embodiments = embodiments
        self._foreign = foreign
        self._wall = wall
        self._none_unanswered = KnownEmpty(database, ScriptRow, MissionRow, clock=wall)
        self._served: Mapping[str, LinkSpec] = {}
        self._serve(robots())
        self._due = threading.Event()
        self._unknown_kinds = UnknownKinds()
        self._unknown = 0
        self._background = Background(f"agents-{world}", self._run)
        database.committed.append(self._due.set)

    def _serve(self, robots: Mapping[str, LinkSpec]) -> None:
        """Exchange messages with these robots from now on."""
        if robots is self._served:
            return
        self._served = robots
        self._robots = frozenset(robots)
        self._open_scripts_query = _open_scripts_query(self._world, self._robots)
        self._none_unanswered.forget(self._world)

    def start(self) -> None:
        self._background.start()

    def close(self) -> None:
        self._background.end()
        if self._due.set in self._database.committed:
            self._database.committed.remove(self._due.set)
        self._none_unanswered.close()

    def _run(self) -> None:
        due_s = 0.0
        readmit_s = 0.0
        had_lease = False
        while not self._background.ending.is_set():
            try:
                self._each_turn()
                self._serve(self._links())
                received = [_as_refusal(one) for one in self._communications.receive(RECEIVE_S)]
                self._record([message for message in received if not self._handle(message)])
                self._ask()
                now_s = self._wall.monotonic_s()
                has_lease = self._has_lease()
                if has_lease and (foreign := self._foreign()) is not None:
                    self._communications.send(WORLD, Performative.INFORM, foreign)
                if now_s >= readmit_s and has_lease:
                    readmit_s = now_s + DELIVER_S  # first: a failure below must not hold up messages
                    self._readmit()
                    self._record_batteries()
                has_news = self._editions is not None and self._editions.has_news()
                if self._due.is_set() or now_s >= due_s or has_news or (has_lease and not had_lease):
                    self._due.clear()
                    if has_lease:
                        self._deliver()
                    due_s = self._wall.monotonic_s() + self._pause_s()
                had_lease = has_lease
            except LinkClosed:
                logger.warning("the link to the robots of %s is closed", self._world)
                self._board.link_closed(self._world)
                return
            except Exception as error:
                # A message that cannot be recorded now must not end the thread: robots send their reports until they
                # get a receipt.
                if is_unavailable(error):
                    logger.warning(
                        "database unavailable: messages to and from the robots of %s wait", self._world
                    )
                else:
                    logger.exception("handling of messages of the robots of %s failed", self._world)
                self._wall.wait(self._background.ending, DELIVER_S)

    def _pause_s(self) -> float:
        """Wall-clock seconds until the next delivery, if nothing is written meanwhile."""
        if self._communications.has_unanswered:
            return MIN_RESEND_S
        has_leases = self._embodiments is not None and self._embodiments.has_leases(self._world)
        return DELIVER_S if has_leases else IDLE_DELIVER_S

    def _handle(self, message: Message) -> bool:
        """Handle a message at once; False if it is one to be recorded."""
        if isinstance(message.body, WorldEdition):
            # Only the world itself says at which edition it is, not one of its robots.
            if message.sender == WORLD and self._editions is not None and self._has_lease():
                self._editions.answered(message, message.body)
            return True
        if message.sender not in self._robots:
            return not (isinstance(message.body, Factsheet) and self._has_lease())
        if isinstance(message.body, Telemetry):
            self._board.heard(message.sender, message.body)
            return True
        self._board.heard(message.sender)
        is_handled = self._questions.answered(message) or self._teleoperation.refused(message)
        return is_handled or not self._has_lease() or self._follow(message)

    def _follow(self, message: Message) -> bool:
        """Take the answer to what was delivered, or what a robot says; False if it is a message to be recorded."""
        match message.body:
            case TuningReport() as report:
                self._tunings.record_answer(self._world, message.sender, message.performative, report)
            case RulesReport() as report:
                self._rules.record_answer(self._world, message.sender, message.performative, report)
            case MindOrderReport() as report if self._embodiments is not None:
                self._embodiments.record_answer(self._world, message.sender, message.performative, report)
            case MindTransferReport() as taken if self._embodiments is not None:
                self._embodiments.record_transfer(self._world, message.sender, message.performative, taken)
            case SpeechAct() as act:
                self._hear(message, act)
            case UnknownBody():
                self._answer_unknown(message)
            case NotUnderstood(reason=reason):
                logger.debug("%s does not understand %s: %s", message.sender, message.in_reply_to, reason)
            case _:
                return False
        return True

    def _hear(self, message: Message, act: SpeechAct) -> None:
        """Take what a robot says; what cannot be taken does not hold up the others' messages."""
        if self._speech is None:
            return
        try:
            answers = self._speech.hear(self._world, message, act)
        except Exception as error:
            if is_unavailable(error):
                raise
            logger.exception("what %s says cannot be taken", message.sender)
            answers = self._speech.not_understood(message, act, "the service cannot take this")
        self._say(answers)

    def _say(self, speech: Sequence[Speech]) -> None:
        """Answer what robots have said; they repeat it if the answer is lost."""
        for one in speech:
            self._communications.send(
                one.robot,
                one.performative,
                one.act,
                message_id=one.message_id,
                in_reply_to=one.in_reply_to,
            )

    def _answer_unknown(self, message: Message) -> None:
        answer = self._unknown_kinds.answer(message, self._wall.monotonic_s())
        if answer is not None:
            self._unknown += 1
            if str(self._unknown).strip("0") == "1":  # the first, the tenth, the hundredth …
                logger.warning(
                    "%s sent a message of an %s (%d so far)", message.sender, answer.reason, self._unknown
                )
            self._communications.send(
                message.sender, Performative.NOT_UNDERSTOOD, answer, in_reply_to=message.id
            )

    def _record(self, messages: Sequence[Message]) -> None:
        """Record messages, together if possible, and confirm those that robots repeat.

        A message whose recording fails keeps no other from being recorded.
        """
        if not messages:
            return
        try:
            receptions = self._reports.record_all(messages, self._world)
        except Exception as error:
            if len(messages) == 1 or is_unavailable(error):
                raise
            middle = len(messages) // 2
            try:
                self._record(messages[:middle])
            finally:
                self._record(messages[middle:])
            return
        for message, reception in zip(messages, receptions, strict=True):
            is_repeated = message.performative in (Performative.INFORM, Performative.FAILURE)
            if is_repeated and reception is not Reception.HELD_BACK:
                self._communications.send(
                    message.sender, Performative.CONFIRM, Receipt(), in_reply_to=message.id
                )

    def _ask(self) -> None:
        """Send clients' questions and set-points, without repetition: they expire soon."""
        for question in self._questions.to_send(self._robots):
            self._communications.send(
                question.robot, Performative.QUERY, question.body, message_id=question.id
            )
        for robot, set_point in self._teleoperation.to_send(self._robots):
            self._communications.send(robot, Performative.REQUEST, set_point)

    def _deliver(self) -> None:
        """Send each message that the database records as unanswered, if it is due."""
        send = self._communications.send_if_due
        if self._editions is not None and (edition := self._editions.due()) is not None:
            request, change = edition
            send(WORLD, request, Performative.REQUEST, change)
        for row in self._tunings.pending(self._world):
            retune = Retune(version=row.version, tuning=row.tuning)
            send(row.robot, f"{row.robot}:{TUNING}:{row.version}", Performative.REQUEST, retune)
        for rules in self._rules.pending(self._world):
            files = {**dict(rules.files), **dict(rules.role_files)}
            rule_set = RuleSet(version=rules.version, files=files, role=rules.role)
            send(rules.robot, f"{rules.robot}:{RULES}:{rules.version}", Performative.REQUEST, rule_set)
        for due in () if self._embodiments is None else self._embodiments.due(self._world):
            send(due.robot, order_id(due.robot, due.order), Performative.REQUEST, due.order)
        for said in () if self._speech is None else self._speech.due(self._world):
            if said.robot in self._robots:
                send(said.robot, said.message_id, said.performative, said.act, in_reply_to=said.in_reply_to)
                if said.ends and self._speech is not None:
                    self._speech.was_said(said)
        for script in self._open_scripts():
            if script.delivery == Delivery.PENDING and not script.stopping:
                body = BehaviourScript.model_validate(script.body)
                send(script.robot, f"{script.id}:request", Performative.REQUEST, ScriptRequest(script=body))
                continue
            if script.clearance is not None:
                clearance = Clearance(script_id=script.id, ended=tuple(script.cleared))
                send(script.robot, f"{script.id}:{script.clearance}", Performative.REQUEST, clearance)
            if (order := unanswered_order(script)) is not None:
                cancels = order.verb is ControlVerb.CANCEL
                performative = Performative.CANCEL if cancels else Performative.REQUEST
                send(script.robot, f"{script.id}:{order_label(order)}", performative, order)
            elif script.question is not None:
                query = StatusQuery(script_id=script.id)
                send(script.robot, script.question, Performative.QUERY, query)
        self._communications.keep_unanswered()
        self._answer_factsheets()

    def _answer_factsheets(self) -> None:
        if self._factsheets is None:
            return
        for reply in self._factsheets.due(self._world):
            refused = reply.state is FactsheetState.REFUSED
            self._communications.send(
                reply.robot,
                Performative.REFUSE if refused else Performative.CONFIRM,
                FactsheetAnswer(state=reply.state, reason=reply.reason),
                in_reply_to=reply.message_id,
            )

    def _open_scripts(self) -> Sequence[ScriptRow]:
        return [
            row
            for row, state in self._none_unanswered.read(self._world, self._unanswered)
            if state != MissionState.PAUSED or row.delivery != Delivery.PENDING or row.stopping
        ]

    def _unanswered(self) -> Sequence[Row[ScriptRow, str]]:
        with self._database.read() as session:
            return session.execute(self._open_scripts_query).all()


def order_id(robot: str, order: MindOrder | MindTransfer) -> str:
    """The id of the message that brings an order to a mind: a later lease is another order, and so is each piece."""
    if isinstance(order, MindTransfer):
        piece = order.mind
        return f"{robot}:{MIND}:{order.fence}:{TRANSFER}:{piece.digest[:8]}:{piece.number}"
    if order.piece:
        return f"{robot}:{MIND}:{order.fence}:{order.verb}:{order.piece}"
    until = "" if order.lease_until_s is None else f":{order.lease_until_s:.1f}"
    return f"{robot}:{MIND}:{order.fence}:{order.verb}{until}"


def _as_refusal(message: Message) -> Message:
    """A refusal for a robot's not-understood, if the request's id names its subject; other messages as they are."""
    if not isinstance(message.body, NotUnderstood):
        return message
    subject, _, request = (message.in_reply_to or "").partition(":")
    reason = f"not understood: {message.body.reason}"
    kind, _, version = request.partition(":")
    body: TuningReport | RulesReport | MindOrderReport | MindTransferReport | Refusal
    fence, _, verb = version.partition(":")
    verb = verb.partition(":")[0]  # of an order to go on, a lease may follow
    if kind == MIND and fence.isdecimal() and len(fence) < MAX_DIGITS and verb in tuple(MindVerb):
        body = MindOrderReport(verb=MindVerb(verb), fence=int(fence), reason=reason)
    elif kind == MIND and fence.isdecimal() and len(fence) < MAX_DIGITS and verb == TRANSFER:
        body = MindTransferReport(fence=int(fence), digest="", number=0, reason=reason)
    elif kind in (TUNING, RULES) and version.isdecimal() and len(version) < MAX_DIGITS:
        answer = TuningReport if kind == TUNING else RulesReport
        body = answer(version=int(version), reason=reason)
    elif request:
        body = Refusal(script_id=subject, reason=reason)
    else:
        return message
    return message.model_copy(update={"performative": Performative.REFUSE, "body": body})


def _open_scripts_query(world: str, robots: Collection[str]) -> Select[ScriptRow, str]:
    """The scripts of open missions, or of robots declared lost, for which a robot owes an answer, with their mission's
    state.
    """
    unanswered = or_(
        ScriptRow.delivery == Delivery.PENDING,
        ScriptRow.clearance.is_not(None),
        ScriptRow.control.is_not(None),
        ScriptRow.question.is_not(None),
    )
    # Through the indices of both tables: with an `or` over them, all missions of the record would be read.
    is_open = (MissionRow.world == world, MissionRow.state.in_(OPEN))
    missions = union(
        select(MissionRow.id).where(*is_open), select(ScriptRow.mission_id).where(ScriptRow.abandoned)
    )
    return (
        select(ScriptRow, MissionRow.state)
        .join(MissionRow, MissionRow.id == ScriptRow.mission_id)
        .where(
            MissionRow.id.in_(missions),
            MissionRow.world == world,
            or_(MissionRow.state.in_(OPEN), ScriptRow.abandoned),
            ScriptRow.robot.in_(robots),
            unanswered,
        )
        .order_by(ScriptRow.id)
    )
