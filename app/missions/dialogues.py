"""What persons say to single robots: understood, clarified, approved, said to the robot, and answered (SRA).

Whatever moves the robot becomes a script of its own, which the person sees first. A robot that works for a mission is
left alone: nothing of a mission's script or its proof is touched; `stop` pauses the mission.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from app.agents.robot_board import RobotBoard
from app.agents.robot_directory import ROBOT, RobotDirectory, RobotReport
from app.agents.speech import SpeechService, last_heard
from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, iso_utc
from app.domain.errors import Conflict, Invalid, NotFound
from app.domain.events import DialogueChanged
from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.words import joined
from app.domain.ids import new_id
from app.domain.lifecycles import dialogue as life
from app.domain.lifecycles.conversation import TIMED_OUT, OutOfProtocol
from app.domain.lifecycles.dialogue import DialogueState
from app.domain.robot_language.answers import in_words
from app.domain.robot_language.references import WHICH_ONE
from app.domain.robot_language.surroundings import Surroundings, surroundings_of
from app.domain.robot_language.understand import (
    Ordered,
    Spoken,
    Stopped,
    Understood,
    answered,
    understand,
)
from app.missions.dialogue_checks import why_not_now
from app.missions.mission_service import MissionService
from app.store import ConversationRow, DialogueRow
from app.store.event_log import EventLog
from app.store.records import page
from app.store.tables import utc_now
from robots.repertoire import Repertoire
from robots.social import Term
from robots.social.persons import HALT, perform_of
from robots.social.protocols import OPENED_BY
from robots.wire import BehaviourPacket, Performative
from robots.world import PERSONS, WorldFile

OPENER = "dialogues"
ANSWER_S = 30.0
"""How long an answer is awaited beyond the radio's time and that of the packets (wall clock)."""
DECISION_S = 120.0
"""How long the bids that a person has called for stay open, for the person to decide on them (wall clock)."""
AWARD_S = 600.0
"""How long the end of what a person has awarded is awaited (world's clock)."""
UNANSWERED_S = 3600.0
"""After so long a question or a script that nobody has answered gives way to the next word to the robot."""
KEPT = 500
"""Dialogues of one robot; beyond it the oldest of those that have ended are forgotten."""
YES = frozenset({"yes", "ok", "do it", "go ahead", "y"})
NO = frozenset({"no", "never mind", "forget it", "n"})

_ENDINGS: Mapping[Performative, DialogueState] = {
    Performative.AGREE: DialogueState.AGREED,
    Performative.INFORM: DialogueState.DONE,
    Performative.CONFIRM: DialogueState.DONE,
    Performative.REFUSE: DialogueState.REFUSED,
    Performative.FAILURE: DialogueState.FAILED,
    Performative.NOT_UNDERSTOOD: DialogueState.NOT_UNDERSTOOD,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Word:
    """What a person says.

    :param dialogue: the id of the dialogue that it goes on with; None begins one.
    :param approve: a script that it makes is carried out at once.
    :param key: words with the same key are one.
    """

    text: str
    dialogue: str | None = None
    approve: bool = False
    key: str | None = None


class DialogueService:
    """Takes persons' words to robots and what the robots answer."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: Mapping[str, WorldFile],
        robots: RobotDirectory,
        board: RobotBoard,
        missions: MissionService,
        speech: SpeechService,
        repertoire: Repertoire,
    ) -> None:
        """:param repertoire: the packets of the robots' software, with the words for them."""
        self._core = core
        self._database = core.database
        self._worlds = worlds
        self._robots = robots
        self._board = board
        self._missions = missions
        self._speech = speech
        self._repertoire = repertoire
        self._fillers = frozenset(
            spec.tag
            for spec in repertoire.specs.values()
            if any(condition.get("sense") == "lies_at" for condition in spec.after)
        )
        """Packets that put something somewhere."""
        speech.listen(OPENER, self._hear)

    def say(self, robot: str, word: Word, *, actor: str) -> DialogueRow:
        """Say something to a robot; the dialogue says what became of it.

        :raises Invalid: if it is not understood: with the word, its place and what would be.
        :raises Conflict: if the dialogue that it goes on with has ended, or is under way.
        """
        report = self._report(robot)
        with self._database.read() as session:
            around = self._around(session, report)
        with self._database.write() as session:
            self._lock(session, robot)
            if word.key is not None:
                self._database.lock(session, f"words' key {word.key}")
            if (known := self._by_key(session, robot, word)) is not None:
                return known
            row = None if word.dialogue is None else self._row(session, robot, word.dialogue)
            if row is None:
                return self._begin(session, report, around, word, actor)
            return self._go_on(session, row, report, around, word, actor)

    def approve(self, robot: str, dialogue: str, *, actor: str) -> DialogueRow:
        """Have the robot carry out the script that is shown. :raises Conflict: if none is."""
        report = self._report(robot)
        with self._database.write() as session:
            self._lock(session, robot)
            row = self._row(session, robot, dialogue)
            if row.state != DialogueState.PROPOSED:
                raise Conflict(
                    f"dialogue {row.id} is {row.state}: nothing waits for approval", code="not-proposed"
                )
            self._note(row, actor, Performative.ACCEPT_PROPOSAL, "", "approved")
            self._perform(session, row, report, actor)
            return row

    def withdraw(self, robot: str, dialogue: str, *, actor: str, comment: str = "") -> DialogueRow:
        """Withdraw what was said; a script under way ends. :raises Conflict: if it has ended."""
        with self._database.write() as session:
            self._lock(session, robot)
            row = self._row(session, robot, dialogue)
            if not life.is_open(row):
                raise Conflict(f"dialogue {row.id} is {row.state}: it has ended", code="dialogue-ended")
            self._withdraw(session, row, actor, comment)
            return row

    def get(self, robot: str, dialogue: str) -> DialogueRow:
        with self._database.read() as session:
            return self._row(session, robot, dialogue, to_change=False)

    def newest(
        self, robot: str, *, limit: int = 100, after: str | None = None
    ) -> tuple[Sequence[DialogueRow], str | None]:
        """The robot's dialogues, newest first."""
        self._robots.robot(robot)
        with self._database.read() as session:
            return page(session, DialogueRow, limit=limit, after=after, robot=robot)

    def open_one(self, robot: str) -> str | None:
        """The id of the newest dialogue with the robot that has not ended."""
        query = select(DialogueRow.id).where(DialogueRow.robot == robot, DialogueRow.state.in_(life.OPEN))
        with self._database.read() as session:
            return session.scalars(query.order_by(DialogueRow.created_at.desc()).limit(1)).first()

    def _begin(
        self, session: Session, report: RobotReport, around: Surroundings, word: Word, actor: str
    ) -> DialogueRow:
        understood = understand(word.text, around)
        _refuse_unclear(understood)
        row = DialogueRow(
            id=new_id("dialogue"),
            world=report.view.world,
            robot=report.view.name,
            text=word.text,
            said_by=actor,
            idempotency_key=word.key,
        )
        self._withdraw_unanswered(session, row.robot, actor)
        self._forget_oldest(session, row.robot)
        self._note(row, actor, _performative(understood), word.text, word.text, key=word.key)
        self._take(session, row, report, understood, word, actor)
        return row

    def _go_on(
        self,
        session: Session,
        row: DialogueRow,
        report: RobotReport,
        around: Surroundings,
        word: Word,
        actor: str,
    ) -> DialogueRow:
        if not life.is_open(row):
            raise Conflict(f"dialogue {row.id} is {row.state}; begin another one", code="dialogue-ended")
        if row.state in life.UNDER_WAY:
            self._continue_speech(session, row, around, word, actor)
        else:
            self._answer(session, row, report, around, word, actor)
        return row

    def _answer(
        self,
        session: Session,
        row: DialogueRow,
        report: RobotReport,
        around: Surroundings,
        word: Word,
        actor: str,
    ) -> None:
        """Take the answer to a question or a shown script, or what is said in its place."""
        said = word.text.strip().lower().rstrip(".!")
        if said in NO:
            self._withdraw(session, row, actor, word.text, key=word.key)
            return
        if row.state == DialogueState.PROPOSED and said in YES:
            self._note(row, actor, Performative.ACCEPT_PROPOSAL, "", word.text, key=word.key)
            self._perform(session, row, report, actor)
            return
        whole: str | None = None
        if row.state == DialogueState.ASKING:
            whole = answered(row.text, word.text, _clarification(row.asked), around)
        understood = understand(whole or word.text, around)
        _refuse_unclear(understood)
        row.text = whole or word.text
        row.asked = {}
        row.packets = []
        performative = Performative.INFORM if whole else _performative(understood)
        self._note(row, actor, performative, word.text, word.text, key=word.key)
        self._take(session, row, report, understood, word, actor)

    def _take(
        self,
        session: Session,
        row: DialogueRow,
        report: RobotReport,
        understood: Understood | Clarification,
        word: Word,
        actor: str,
    ) -> None:
        match understood:
            case Clarification():
                row.asked = asdict(understood)
                self._note(row, row.robot, Performative.QUERY_REF, "which", understood.detail)
                self._become(session, row, DialogueState.ASKING, actor)
            case Ordered(packets=packets):
                row.packets = [one.model_dump(mode="json") for one in packets]
                if reason := self._why_not(session, row, report, packets):
                    self._refuse(session, row, reason, actor)
                    return
                shown = joined([one.description for one in packets], last="then")
                self._note(row, row.robot, Performative.PROPOSE, shown, f"I would do {shown}")
                if word.approve:
                    self._perform(session, row, report, actor)
                else:
                    self._become(session, row, DialogueState.PROPOSED, actor)
            case Stopped():
                self._stop(session, row, report, actor)
            case Spoken(performative=performative, content=content):
                answer_s = DECISION_S if performative is Performative.CFP else ANSWER_S
                self._speak(session, row, performative, content, actor, answer_s=answer_s)

    def _perform(self, session: Session, row: DialogueRow, report: RobotReport, actor: str) -> None:
        """Have the robot do what was approved, unless something stands against it now."""
        packets = [BehaviourPacket.model_validate(one) for one in row.packets]
        if reason := self._why_not(session, row, report, packets):
            self._refuse(session, row, reason, actor)
            return
        work_s = sum(one.timeout_s + one.wait_timeout_s for one in packets)
        content = perform_of(row.id, packets)
        self._speak(session, row, Performative.REQUEST, content, actor, work_s=work_s)

    def _why_not(
        self, session: Session, row: DialogueRow, report: RobotReport, packets: Sequence[BehaviourPacket]
    ) -> str:
        filled = {one.arguments.get("ref2", "") for one in packets if one.tag in self._fillers}
        return why_not_now(
            session, self._core, self._worlds[row.world], report, packets, filled=filled, dialogue=row.id
        )

    def _stop(self, session: Session, row: DialogueRow, report: RobotReport, actor: str) -> None:
        """Pause the mission of a robot that has one; else have it end its own script."""
        if report.mission_id is None:
            self._speak(session, row, Performative.REQUEST, Term(HALT), actor)
            return
        try:
            self._missions.pause_in(session, report.mission_id, actor, f"{row.robot} was told to stop")
        except Conflict as conflict:
            self._refuse(session, row, conflict.detail, actor)
            return
        words = f"mission {report.mission_id} is paused with all its robots; resume it to go on"
        self._note(row, row.robot, Performative.INFORM, "halted", words)
        self._become(session, row, DialogueState.DONE, actor)

    def _speak(
        self,
        session: Session,
        row: DialogueRow,
        performative: Performative,
        content: Term,
        actor: str,
        *,
        answer_s: float = ANSWER_S,
        work_s: float = 0.0,
    ) -> None:
        """Open the conversation with the robot.

        :param answer_s: how long its answer is awaited (wall clock), beside `work_s` for its work (world's clock).
        """
        if reason := self._speech.unheard_reason(row.world, row.robot, PERSONS):
            self._refuse(session, row, reason, actor)
            return
        if performative not in OPENED_BY:
            detail = f"{performative} answers something; say it in a dialogue that is under way"
            raise Invalid(detail, code="opens-nothing", thing=performative.value, choices=sorted(OPENED_BY))
        conversation = self._speech.open(
            session,
            world=row.world,
            robot=row.robot,
            what=PERSONS,
            performative=performative,
            content=content,
            protocol=OPENED_BY[performative],
            within_s=work_s + self._speech.patience_s(row.world, row.robot, answer_s),
            opener=OPENER,
            speaker=actor,
        )
        row.conversation = conversation.id
        self._become(session, row, DialogueState.SAID, actor)

    def _continue_speech(
        self, session: Session, row: DialogueRow, around: Surroundings, word: Word, actor: str
    ) -> None:
        """Say another performative in the conversation, such as accept-proposal; `stop` ends it."""
        understood = understand(word.text, around)
        _refuse_unclear(understood)
        gives_up = isinstance(understood, Spoken) and understood.performative is Performative.CANCEL
        if gives_up or isinstance(understood, Stopped):
            self._withdraw(session, row, actor, word.text, key=word.key)
            return
        conversation = session.get(ConversationRow, (row.conversation, row.robot))
        if not isinstance(understood, Spoken) or conversation is None:
            raise Conflict(
                f"dialogue {row.id} is {row.state}; say stop, or wait for its end", code="under-way"
            )
        performative = understood.performative
        within_s = self._speech.patience_s(row.world, row.robot, ANSWER_S)
        if performative is Performative.ACCEPT_PROPOSAL:
            within_s += AWARD_S
        try:
            self._speech.say(session, conversation, performative, understood.content, within_s=within_s)
        except OutOfProtocol as error:
            raise Conflict(str(error), code="out-of-protocol") from error
        self._note(row, actor, performative, word.text, word.text, key=word.key)
        if conversation.is_over:  # by reject-proposal
            self._become(session, row, DialogueState.WITHDRAWN, actor, "its bid was not taken")
        else:
            self._tell(session, row, actor)

    def _withdraw(
        self, session: Session, row: DialogueRow, actor: str, comment: str, *, key: str | None = None
    ) -> None:
        conversation = (
            session.get(ConversationRow, (row.conversation, row.robot))
            if row.state in life.UNDER_WAY
            else None
        )
        self._note(row, actor, Performative.CANCEL, "", comment or "withdrawn", key=key)
        if conversation is not None and not conversation.is_over:
            self._speech.cancel(conversation, "withdrawn")
            if row.packets and row.robot in self._worlds[row.world].links:
                # A cancel would be said once, and may be lost; the order to halt is repeated.
                halt = self._speech.open(
                    session,
                    world=row.world,
                    robot=row.robot,
                    what=PERSONS,
                    performative=Performative.REQUEST,
                    content=Term(HALT, (row.id,)),
                    protocol=OPENED_BY[Performative.REQUEST],
                    within_s=self._speech.patience_s(row.world, row.robot, ANSWER_S),
                    opener=OPENER,
                    speaker=actor,
                )
                row.conversation = halt.id
        self._become(session, row, DialogueState.WITHDRAWN, actor, comment)

    def _hear(self, session: Session, conversation: ConversationRow) -> None:
        """Take what a robot has answered, or that it has not."""
        query = select(DialogueRow).where(DialogueRow.conversation == conversation.id).with_for_update()
        row = session.scalars(query).first()
        if row is not None and row.state == DialogueState.WITHDRAWN:
            self._hear_halted(session, row, conversation)
            return
        if row is None or row.state not in life.UNDER_WAY:
            return
        if conversation.state == TIMED_OUT:
            self._become(session, row, DialogueState.TIMED_OUT, row.robot, conversation.reason)
            return
        if (heard := last_heard(conversation)) is None:
            return
        performative, content = heard
        words = in_words(performative, content)
        self._note(row, row.robot, performative, str(content), words)
        state = _ENDINGS.get(performative)
        if state is None or state == row.state:
            self._tell(session, row, row.robot)
            return
        failed = state in (DialogueState.REFUSED, DialogueState.FAILED, DialogueState.NOT_UNDERSTOOD)
        self._become(session, row, state, row.robot, words if failed else "")

    def _hear_halted(self, session: Session, row: DialogueRow, conversation: ConversationRow) -> None:
        """Take what a robot answers to the order to end a script that was withdrawn, or that it does not."""
        reason = row.reason
        if conversation.state == TIMED_OUT:
            unheard = f"{row.robot} has not answered the order to stop, and may still be at it"
            reason = f"{reason}; {unheard}" if reason else unheard
        elif (heard := last_heard(conversation)) is not None:
            performative, content = heard
            self._note(row, row.robot, performative, str(content), in_words(performative, content))
        self._become(session, row, DialogueState.WITHDRAWN, row.robot, reason)

    def _refuse(self, session: Session, row: DialogueRow, reason: str, actor: str) -> None:
        self._note(row, row.robot, Performative.REFUSE, "", f"no: {reason}")
        self._become(session, row, DialogueState.REFUSED, actor, reason)

    def _become(
        self, session: Session, row: DialogueRow, state: DialogueState, actor: str, reason: str = ""
    ) -> None:
        if row.state is None:
            life.begin(row, state, reason)
            session.add(row)
        elif row.state == state:
            row.reason = reason
        else:
            life.become(row, state, reason)
        self._tell(session, row, actor)

    def _tell(self, session: Session, row: DialogueRow, actor: str) -> None:
        session.flush()
        self._core.events.append(session, _changed(row, actor))

    @staticmethod
    def _note(
        row: DialogueRow,
        by: str,
        performative: Performative,
        content: str,
        words: str,
        *,
        key: str | None = None,
    ) -> None:
        """Add a line to the dialogue. :param key: the idempotency key of what is said."""
        line: dict[str, Any] = {
            "by": by,
            "performative": performative.value,
            "content": content,
            "words": words,
            "at": utc_now(),
        }
        if key is not None:
            line["key"] = key
        row.lines = [*(row.lines or []), line]

    def _lock(self, session: Session, robot: str) -> None:
        """Have persons' words to a robot wait for each other."""
        self._database.lock(session, f"words to {robot}")

    def _report(self, robot: str) -> RobotReport:
        report = self._robots.robot(robot)
        if report.kind != ROBOT:
            raise Conflict(
                f"{robot} is a {report.kind}, and takes scripts of missions alone", code="no-robot"
            )
        return report

    def _around(self, session: Session, report: RobotReport) -> Surroundings:
        name = report.view.world
        world = self._worlds[name]
        return surroundings_of(
            world.robot(report.view.name),
            world,
            self._core.facts.facts(session, name),
            self._repertoire,
            telemetry=report.view.telemetry,
            points=self._board.points(name),
        )

    @staticmethod
    def _by_key(session: Session, robot: str, word: Word) -> DialogueRow | None:
        """The dialogue that an idempotency key was used for."""
        if word.key is None:
            return None
        row = session.scalars(select(DialogueRow).where(DialogueRow.idempotency_key == word.key)).first()
        if row is None and word.dialogue is not None:
            row = session.get(DialogueRow, word.dialogue)
        spoken = [] if row is None else [one["words"] for one in row.lines if one.get("key") == word.key]
        if row is None or not spoken:
            return None
        if row.robot != robot or spoken != [word.text] or word.dialogue not in (None, row.id):
            raise Conflict("this idempotency key was used for another word", code="idempotency-key-reused")
        return row

    @staticmethod
    def _row(session: Session, robot: str, dialogue: str, *, to_change: bool = True) -> DialogueRow:
        """:param to_change: lock its conversation, then itself: in the order in which the robot's answers do."""
        row = session.get(DialogueRow, dialogue)
        if row is None or row.robot != robot:
            raise NotFound(f"{robot} has no dialogue {dialogue!r}", code="unknown-dialogue")
        if to_change:
            if row.conversation:
                session.get(ConversationRow, (row.conversation, robot), with_for_update=True)
            session.refresh(row, with_for_update=True)
        return row

    def _withdraw_unanswered(self, session: Session, robot: str, actor: str) -> None:
        """Withdraw questions and shown scripts that nobody has answered for long."""
        before = iso_utc(SYSTEM_CLOCK.epoch_s() - UNANSWERED_S)
        waiting = (DialogueRow.robot == robot, DialogueRow.state.in_(life.AWAITS_PERSON))
        for row in session.scalars(select(DialogueRow).where(*waiting)):
            if row.lines[-1]["at"] < before:
                self._withdraw(session, row, actor, "nobody has answered for an hour")

    @staticmethod
    def _forget_oldest(session: Session, robot: str) -> None:
        newest = select(DialogueRow.id).where(DialogueRow.robot == robot)
        newest = newest.order_by(DialogueRow.created_at.desc(), DialogueRow.id.desc()).offset(KEPT - 1)
        if old := session.scalars(newest).all():
            ended = (DialogueRow.id.in_(old), DialogueRow.state.not_in(life.OPEN))
            session.execute(delete(DialogueRow).where(*ended))


def end_dialogues(session: Session, events: EventLog, world: str, reason: str) -> None:
    """End the dialogues of a world whose robots no longer answer in them."""
    query = select(DialogueRow).where(DialogueRow.world == world, DialogueRow.state.in_(life.OPEN))
    for row in session.scalars(query.with_for_update()):
        under_way = row.state in life.UNDER_WAY
        life.become(row, DialogueState.FAILED if under_way else DialogueState.WITHDRAWN, reason)
        events.append(session, _changed(row, row.robot))


def _changed(row: DialogueRow, actor: str) -> DialogueChanged:
    last = row.lines[-1]
    return DialogueChanged(
        subject=row.robot,
        world=row.world,
        dialogue=row.id,
        state=DialogueState(row.state),
        actor=actor,
        text=row.text,
        speaker=last["by"],
        performative=Performative(last["performative"]),
        words=last["words"],
        reason=row.reason,
    )


def _performative(understood: Understood | Clarification) -> Performative:
    return understood.performative if isinstance(understood, Spoken) else Performative.REQUEST


def _clarification(asked: Mapping[str, Any]) -> Clarification:
    span = asked.get("span")
    known = {**asked, "choices": tuple(asked["choices"]), "span": None if span is None else tuple(span)}
    return Clarification(**known)


def _refuse_unclear(understood: Understood | Clarification) -> None:
    """:raises Invalid: for what is no question which one is meant."""
    if isinstance(understood, Clarification) and understood.code != WHICH_ONE:
        raise understood.refusal()
