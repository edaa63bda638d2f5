"""Robots' reports: each recorded once, with its consequences; those that arrive together in one transaction."""

import hashlib
import logging
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import select, tuple_
from sqlalchemy.orm import Session

from app.agents.agent_models import Reception
from app.core import Core
from app.domain.events import (
    ClearanceRefused,
    ControlRefused,
    MissionRunning,
    PacketReported,
    RobotFaultsReported,
    RobotQueryNotUnderstood,
    ScriptAcknowledged,
    ScriptRefused,
    ScriptReported,
    ScriptStatus,
    SpeechHeard,
)
from app.domain.lifecycles.mission import MissionState, begin_work, has_ended
from app.domain.lifecycles.script import (
    TERMINAL_SCRIPTS,
    Delivery,
    acknowledge,
    ask,
    doubt,
    end,
    follow_order,
    forget,
    has_terminated,
    hear,
    note_answer,
    order_label,
    refuse,
    reissue_if_diverged,
    settle_clearance,
    settle_doubt,
    settle_order,
    unanswered_order,
)
from app.domain.world_model import Reservation
from app.missions.belief_updates import BeliefUpdates
from app.missions.clearance import (
    action_has_ended,
    begun_uncleared,
    packets_of,
    renew_clearances,
    told_by_peers,
)
from app.missions.contradictions import ContradictionRecord, note_claim
from app.missions.delegation import DelegationRecord, finish_by, granted_to, stand_after
from app.missions.factsheets import Factsheets
from app.missions.mission_speech import speech_of
from app.missions.plausibility import Plausibility
from app.missions.results import keep_results
from app.missions.world_changes import WorldChanges
from app.planning.waiting_goals import WaitingGoals
from app.store import MessageRow, MissionRow, ScriptRow, UnaskedRobotRow
from app.store.durations import learn
from robots.wire import (
    Acknowledgement,
    BehaviourScript,
    ControlVerb,
    DelegationReport,
    DelegationState,
    Factsheet,
    FaultReport,
    Message,
    PacketReport,
    PacketState,
    Refusal,
    SampleReport,
    ScriptReport,
    ScriptState,
    SpeechReport,
    StatusReport,
    SymbolicFact,
    UpkeepReport,
)

OfScript = (
    Acknowledgement | Refusal | PacketReport | ScriptReport | StatusReport | SpeechReport | DelegationReport
)
"""Reports and answers about a script."""
MAX_ID = 120
"""The longest key of a recorded message."""
BEGUN_PACKETS = frozenset({PacketState.RUNNING, PacketState.FINISHED})
TERMINAL_PACKETS = frozenset({PacketState.FINISHED, PacketState.FAILED})

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Subject:
    """What a report is about.

    :param scripts: all of the plan that the script belongs to.
    """

    script: ScriptRow
    mission: MissionRow
    scripts: Sequence[ScriptRow]

    @property
    def is_current(self) -> bool:
        """True if the script belongs to the mission's current plan."""
        return self.script.plan_id == self.mission.plan_id


class MissionReports:
    """Records robots' reports and answers. A message whose id is recorded already changes nothing.

    An implausible report is not recorded: the mission becomes `unknown`, and the robot is asked for its status.
    """

    def __init__(
        self,
        core: Core,
        *,
        waiting: WaitingGoals,
        plausibility: Plausibility,
        changes: WorldChanges,
        factsheets: Factsheets,
    ) -> None:
        self._core = core
        self._database = core.database
        self._workflows = core.workflows
        self._events = core.events
        self._reservations = core.reservations
        self._beliefs = BeliefUpdates(core)
        self._contradictions = ContradictionRecord(core)
        self._delegations = DelegationRecord(core)
        self._waiting = waiting
        self._plausibility = plausibility
        self._changes = changes
        self._factsheets = factsheets

    def record(self, message: Message, world: str) -> Reception:
        """Record one answer or report, see `record_all`."""
        return self.record_all([message], world)[0]

    def record_all(self, messages: Sequence[Message], world: str) -> Sequence[Reception]:
        """Record robots' answers and reports, in order; first factsheets, then reports of unknown samples.

        :param world: the world that the robots are in.
        """
        sheets = [message for message in messages if isinstance(message.body, Factsheet)]
        kept = self._factsheets.record(world, sheets) if sheets else ()
        found = {_key(message): reception for message, reception in zip(sheets, kept, strict=True)}
        found |= {
            _key(message): self._record_sample(message.sender, message.body, world)
            for message in messages
            if isinstance(message.body, SampleReport)
        }
        others = [message for message in messages if _key(message) not in found]
        recorded = iter(self._record_all(others, world))
        return [found.get(_key(message)) or next(recorded) for message in messages]

    def _record_sample(self, robot: str, report: SampleReport, world: str) -> Reception:
        if why := self._plausibility.doubt_of_sample(robot, report, world):
            logger.debug("report held back as implausible: %s %s", robot, why)
            return Reception.HELD_BACK
        self._changes.discover(world, robot, report)
        return Reception.RECORDED

    def _record_all(self, messages: Sequence[Message], world: str) -> Sequence[Reception]:
        if not messages:
            return []
        with self._database.write() as session:
            ids = sorted({_key(message) for message in messages})
            self._database.lock(session, *ids)  # another process may receive them, too
            known = set(session.scalars(select(MessageRow.id).where(MessageRow.id.in_(ids))))
            subjects = _subjects_of(session, [one for one in messages if _key(one) not in known])
            freeing = {
                subject.mission.id: subject
                for message in messages
                if _may_free(message) and (subject := subjects.get(_key(message))) and subject.is_current
            }
            before = self._reserved(session, freeing.values())
            receptions = list[Reception]()
            reported_on = dict[str, MissionRow]()
            for message in messages:
                subject = subjects.get(_key(message))
                reception = Reception.IGNORED
                if _key(message) in known:
                    pass
                elif isinstance(message.body, FaultReport):
                    reception = self._record_faults(session, message, message.body, world)
                elif isinstance(message.body, UpkeepReport):
                    reception = self._record_upkeep(session, message, message.body, world)
                elif subject is not None:
                    reception = self._record_subject(session, message, subject, world)
                if reception is Reception.RECORDED:
                    known.add(_key(message))
                    if subject is not None:
                        reported_on[subject.mission.id] = subject.mission
                receptions.append(reception)
            if self._reserved(session, freeing.values()) != before:
                self._waiting.release(session, world)
            for mission in reported_on.values():
                if not has_ended(mission):
                    self._workflows.wake(session, mission.workflow)
            return receptions

    def _record_faults(
        self, session: Session, message: Message, report: FaultReport, world: str
    ) -> Reception:
        session.add(_row(message))
        event = RobotFaultsReported(
            subject=message.sender, world=world, at_s=report.at_s, faults=report.faults
        )
        self._events.append(session, event)
        return Reception.RECORDED

    def _record_upkeep(
        self, session: Session, message: Message, report: UpkeepReport, world: str
    ) -> Reception:
        if why := self._plausibility.doubt(session, message, world, None):
            logger.debug("report held back as implausible: %s %s", message.sender, why)
            return Reception.HELD_BACK
        session.add(_row(message))
        self._beliefs.note_upkeep(session, report, world=world, robot=message.sender)
        return Reception.RECORDED

    def _record_subject(self, session: Session, message: Message, subject: _Subject, world: str) -> Reception:
        if why := self._plausibility.doubt(session, message, world, subject.script, subject.scripts):
            self._hold_back(session, message, subject, why, world)
            return Reception.HELD_BACK
        session.add(_row(message))
        self._apply(session, message, subject)
        return Reception.RECORDED

    def _hold_back(self, session: Session, message: Message, subject: _Subject, why: str, world: str) -> None:
        """Note an implausible report, and wake its mission to query the robot."""
        note_claim(message.body, subject.script, subject.scripts)
        is_open = subject.is_current and not has_ended(subject.mission)
        rival = self._plausibility.rivals.of(session, message.body, world, subject.script, subject.scripts)
        if is_open and rival is not None:
            self._contradictions.note_rival(session, subject.mission, subject.script, *rival)
        if is_open and doubt(subject.script, why):
            logger.warning("report held back as implausible: %s %s", message.sender, why)
            self._workflows.wake(session, subject.mission.workflow)

    def _reserved(self, session: Session, subjects: Iterable[_Subject]) -> Sequence[Reservation]:
        """What the missions still need, in order."""
        return [self._reservations.of_scripts(session, one.mission.plan_id, one.scripts) for one in subjects]

    def _apply(self, session: Session, message: Message, subject: _Subject) -> None:
        match message.body:
            case Acknowledgement():
                self._answer(session, message, subject, refusal=None)
            case Refusal(reason=reason):
                self._answer(session, message, subject, refusal=reason)
            case PacketReport() as report:
                settle_doubt(subject.script)
                self._packet(session, report, subject)
                reissue_if_diverged(subject.script, subject.mission)
            case ScriptReport() as report:
                self._script_ended(session, report, subject)
            case SpeechReport() as report:
                self._speech(session, report, subject)
            case DelegationReport() as report:
                self._delegated(session, report, subject)
            case StatusReport() as report:
                self._status(session, message, report, subject)
                reissue_if_diverged(subject.script, subject.mission)

    def _answer(self, session: Session, message: Message, subject: _Subject, *, refusal: str | None) -> None:
        """Record the robot's answer to a request: the script, an order on it, or a clearance.

        :param refusal: why it refused, None if it agreed.
        """
        script = subject.script
        control = unanswered_order(script)
        if message.in_reply_to == f"{script.id}:request":
            if script.delivery == Delivery.PENDING:
                self._delivered(session, subject, refusal)
        elif control is not None and message.in_reply_to == f"{script.id}:{order_label(control)}":
            if refusal is None:
                follow_order(script, control.verb, message.sent_at_s)
            else:
                settle_order(script)
                label = order_label(control)
                self._ask_why(session, subject, label, refusal)
                refused = ControlRefused(subject=script.id, robot=script.robot, control=label, reason=refusal)
                self._events.append(session, refused)
        elif script.clearance is not None and message.in_reply_to == f"{script.id}:{script.clearance}":
            clearance = script.clearance
            settle_clearance(script)
            if refusal is not None:
                self._ask_why(session, subject, clearance, refusal)
                self._events.append(
                    session,
                    ClearanceRefused(
                        subject=script.id, robot=script.robot, clearance=clearance, reason=refusal
                    ),
                )

        elif refusal is not None and script.question is not None and message.in_reply_to == script.question:
            question = script.question
            note_answer(script, question)
            self._stop_asking(session, subject, refusal)
            _conclude_refused_cancel(script, question, script.detail)

    def _stop_asking(self, session: Session, subject: _Subject, reason: str) -> None:
        """Note that the robot does not understand status queries."""
        world, robot = subject.mission.world, subject.script.robot
        if session.get(UnaskedRobotRow, (world, robot)) is None:
            session.add(UnaskedRobotRow(world=world, robot=robot, reason=reason))
            self._events.append(session, RobotQueryNotUnderstood(subject=robot, world=world, reason=reason))

    def _delivered(self, session: Session, subject: _Subject, refusal: str | None) -> None:
        script = subject.script
        if refusal is None:
            acknowledge(script)
            reissue_if_diverged(
                script, subject.mission
            )  # it may have been on its way when the mission was paused
            self._events.append(session, ScriptAcknowledged(subject=script.id, robot=script.robot, reason=""))
        else:
            refuse(script, refusal)
            if script.delivery == Delivery.REFUSED:
                self._events.append(
                    session, ScriptRefused(subject=script.id, robot=script.robot, reason=refusal)
                )

    def _ask_why(self, session: Session, subject: _Subject, refused: str, reason: str) -> None:
        """Ask the robot for its status after it refused an order or a clearance, unless it cannot be asked.

        Possible reasons: the script has ended and its report is on the way, the robot no longer has the script, or it
        has followed an order with a greater number, which a lost database had recorded.
        """
        script = subject.script
        question = _question_about(script, refused)
        if session.get(UnaskedRobotRow, (subject.mission.world, script.robot)) is not None:
            _conclude_refused_cancel(script, question, reason)
        elif not has_terminated(script):
            ask(script, question)
        script.detail = reason

    def _packet(self, session: Session, report: PacketReport, subject: _Subject) -> None:
        script = subject.script
        mission = subject.mission
        if report.packet_id not in packets_of(script):
            return
        keep_results(session, self._core, report, script, mission)
        known = dict(script.packets.get(report.packet_id, {}))
        if known.get("state") in TERMINAL_PACKETS or report.at_s < known.get("at_s", 0.0):
            self._overtaken(session, report, subject)
            return
        known |= {"state": report.state.value, "at_s": report.at_s, "detail": report.detail}
        if report.state is PacketState.RUNNING:
            known.setdefault("started_at_s", report.at_s)
            known |= _cleared(script, report)
        if report.state in TERMINAL_PACKETS:
            known["finished_at_s"] = report.at_s
        script.packets = {**script.packets, report.packet_id: known}
        is_standing = report.state is PacketState.PAUSED
        hear(script, ScriptState.PAUSED if is_standing else ScriptState.RUNNING, report.at_s)
        if subject.is_current:
            self._note_start(session, mission, report.at_s)
        if told := _told_by(report, script):
            self._beliefs.note_events(session, told, at_s=report.at_s, script=script, mission=mission)
        if subject.is_current and report.state in BEGUN_PACKETS:
            self._contradictions.note(session, mission, subject.scripts)
        if report.state is PacketState.FINISHED:
            self._actions_ended(session, [report.packet_id], report.at_s, subject)
            learn(session, mission.world, script, report.packet_id)
        self._events.append(
            session,
            PacketReported(
                subject=mission.id,
                robot=script.robot,
                packet=report.packet_id,
                state=report.state,
                at_s=report.at_s,
                events=tuple(report.events),
                detail=report.detail,
            ),
        )

    def _overtaken(self, session: Session, report: PacketReport, subject: _Subject) -> None:
        """A later report has arrived before this one, which tells only when the packet began or really ended."""
        known = dict(subject.script.packets[report.packet_id])
        if report.state is PacketState.RUNNING:
            known.setdefault("started_at_s", report.at_s)
            known |= _cleared(subject.script, report)
        elif report.state is PacketState.FINISHED and known.pop("implied", False):
            known["finished_at_s"] = report.at_s
        else:
            return
        subject.script.packets = {**subject.script.packets, report.packet_id: known}
        if subject.is_current and not has_ended(subject.mission):
            self._contradictions.note(session, subject.mission, subject.scripts)

    def _note_start(self, session: Session, mission: MissionRow, at_s: float) -> None:
        """The first report of work starts the mission's expected time."""
        if mission.started_at_s is None:
            mission.started_at_s = at_s
            mission.enquire_at_s = at_s + mission.estimate_s + mission.margin_s
        if begin_work(mission):
            running = MissionRunning(subject=mission.id, started_at_s=at_s, state=MissionState(mission.state))
            self._events.append(session, running)

    def _actions_ended(
        self, session: Session, packets: Iterable[str], at_s: float, subject: _Subject
    ) -> None:
        """The robot has ended its part of actions: apply the effects of those that all their robots have ended."""
        ended = [packet for packet in packets if action_has_ended(subject.scripts, packet)]
        if ended:
            self._beliefs.apply_effects(
                session,
                ended,
                at_s=at_s,
                script=subject.script,
                mission=subject.mission,
                scripts=subject.scripts,
            )
        if subject.is_current:
            renew_clearances(session, self._events, subject.mission, subject.scripts)

    def _script_ended(self, session: Session, report: ScriptReport, subject: _Subject) -> None:
        script = subject.script
        if has_terminated(script):
            return
        end(
            script,
            report.state,
            at_s=report.at_s,
            detail=report.detail,
            category=report.category,
            perceived=[fact.model_dump(mode="json") for fact in report.perceived],
        )
        elsewhere = {
            packet: robot
            for packet, robot in granted_to(script, report.done_by).items()
            if script.packets.get(packet, {}).get("state") != PacketState.FINISHED
        }
        finish_by(script, elsewhere, report.at_s)
        if report.state is ScriptState.FINISHED:
            unreported = _finish_packets(script, report.at_s)
            if subject.is_current:
                self._contradictions.note(session, subject.mission, subject.scripts)
            self._actions_ended(session, [*elsewhere, *unreported], report.at_s, subject)
        else:
            if elsewhere:  # the report that they are done may come later, and then tells nothing new
                self._actions_ended(session, elsewhere, report.at_s, subject)
            self._beliefs.reconcile(session, report, script, subject.mission)
        self._events.append(
            session,
            ScriptReported(
                subject=script.id,
                robot=script.robot,
                mission=subject.mission.id,
                state=report.state,
                at_s=report.at_s,
                detail=report.detail,
            ),
        )

    def _status(self, session: Session, message: Message, report: StatusReport, subject: _Subject) -> None:
        script = subject.script
        note_answer(script, message.in_reply_to)
        script.orders = max(script.orders, report.order)
        if has_terminated(script) or script.delivery == Delivery.REFUSED:
            return
        if report.state is None:
            forget(script, f"{script.robot} no longer has the script")
        elif report.state not in TERMINAL_SCRIPTS:
            # A terminal state is recorded by the script's own report, which has the percepts.
            hear(script, report.state, report.at_s)
            if not _stands_by(report, subject):
                settle_doubt(script)
            if subject.is_current and any(one.doubt for one in subject.scripts if one is not script):
                self._imply_ends(session, report, subject)
        _note_waiting(script, report)
        self._events.append(
            session,
            ScriptStatus(
                subject=script.id,
                robot=script.robot,
                state=None if script.state is None else ScriptState(script.state),
                packet=report.packet_id,
                detail=report.detail,
            ),
        )

    def _speech(self, session: Session, report: SpeechReport, subject: _Subject) -> None:
        """Another robot has spoken to this one. A robot that has restarted may report the same conversation again."""
        one = SpeechHeard(
            subject=subject.mission.id,
            robot=subject.script.robot,
            **{
                name: getattr(report, name)
                for name in (
                    "sender",
                    "performative",
                    "content",
                    "protocol",
                    "sent_at_s",
                    "at_s",
                    "attempt",
                    "answer",
                )
            },
            conversation=report.conversation_id,
            answer_content=report.answer_content,
        )
        known = speech_of(session, subject.mission.id)
        if all(
            (row.data["robot"], row.data["conversation"]) != (one.robot, one.conversation) for row in known
        ):
            self._events.append(session, one)

    def _delegated(self, session: Session, report: DelegationReport, subject: _Subject) -> None:
        """A robot in the field has put a leg to another, or tells how that has ended."""
        ended = self._delegations.note(session, report, subject.script, subject.mission)
        if ended is None:
            return
        if subject.is_current:
            self._note_start(session, subject.mission, report.at_s)
        self._actions_ended(session, ended, report.at_s, subject)
        if report.state is DelegationState.DONE and subject.script.packets:
            self._beliefs.note_positions(
                session, stand_after(report, subject.script.robot), at_s=report.at_s, mission=subject.mission
            )

    def _imply_ends(self, session: Session, report: StatusReport, subject: _Subject) -> None:
        """Another robot's report waits for this one's: what is before the packet that it is at has ended."""
        if report.packet_id not in (packets := packets_of(subject.script)):
            return
        before = packets[: packets.index(report.packet_id)]
        if unreported := _finish_packets(subject.script, report.at_s, before):
            self._contradictions.note(session, subject.mission, subject.scripts)
            self._actions_ended(session, unreported, report.at_s, subject)


def _question_about(script: ScriptRow, refused: str) -> str:
    """The id of the status query after the robot refused an order, by its label, or a clearance."""
    return f"{script.id}:status:{refused}"


def _conclude_refused_cancel(script: ScriptRow, question: str, reason: str) -> None:
    """Take it that a robot that cannot be asked, and refuses to cancel a script that it never took, does not have it.

    :param question: the status query that it was asked, or cannot be asked.
    """
    is_about_cancel = question.startswith(_question_about(script, f"{ControlVerb.CANCEL.value}:"))
    if is_about_cancel and script.stopping and script.delivery == Delivery.PENDING:
        refuse(script, reason)


def _subjects_of(session: Session, messages: Sequence[Message]) -> dict[str, _Subject]:
    """By message, the script that it is about, with its mission, locked; without those that are no script's."""
    script_ids = {_key(message): _script_of(message) for message in messages}
    found = session.scalars(select(ScriptRow).where(ScriptRow.id.in_(set(script_ids.values())))).all()
    if not found:
        return {}
    by_id = {script.id: script for script in found}
    # The missions are locked first: their other scripts change with them.
    in_order = select(MissionRow).where(MissionRow.id.in_({one.mission_id for one in found}))
    locked = in_order.order_by(MissionRow.id).with_for_update().execution_options(populate_existing=True)
    missions = {mission.id: mission for mission in session.scalars(locked)}
    plans = tuple_(ScriptRow.mission_id, ScriptRow.plan_id)
    query = (
        select(ScriptRow)
        .where(plans.in_({(one.mission_id, one.plan_id) for one in found}))
        .order_by(ScriptRow.id)
        .with_for_update()
        .execution_options(populate_existing=True)
    )
    scripts: dict[tuple[str, str], list[ScriptRow]] = defaultdict(list)
    for row in session.scalars(query):
        scripts[row.mission_id, row.plan_id].append(row)
    return {
        _key(message): _Subject(
            script=script,
            mission=missions[script.mission_id],
            scripts=scripts[script.mission_id, script.plan_id],
        )
        for message in messages
        if (script := by_id.get(script_ids[_key(message)])) is not None and script.robot == message.sender
    }


def _may_free(message: Message) -> bool:
    """True if the message may release reservations."""
    match message.body:
        case (
            PacketReport(state=PacketState.FINISHED)
            | ScriptReport(state=ScriptState.FINISHED)
            | DelegationReport(state=DelegationState.DONE)
        ):
            return True
    return False


def _cleared(script: ScriptRow, report: PacketReport) -> dict[str, Any]:
    """What is kept of who has cleared the packet that begins, beside the service."""
    told = told_by_peers(script, report.packet_id, report.cleared_by)
    return {"cleared_by": told} if told else {}


def _told_by(report: PacketReport, script: ScriptRow) -> list[SymbolicFact]:
    """The facts that the report's events stand for, by the robot's script."""
    if not report.events:
        return []
    packets = BehaviourScript.model_validate(script.body).packets
    events = next((packet.events for packet in packets if packet.id == report.packet_id), {})
    return [fact for event in report.events for fact in events.get(event, ())]


def _finish_packets(script: ScriptRow, at_s: float, these: Sequence[str] | None = None) -> list[str]:
    """Record that packets have finished whose reports may not have arrived; returns those.

    :param these: None: all of the script.
    """
    told = {"state": PacketState.FINISHED.value, "at_s": at_s, "finished_at_s": at_s, "implied": True}
    packets = dict(script.packets)
    unreported = [
        packet
        for packet in (packets_of(script) if these is None else these)
        if packets.get(packet, {}).get("state") != PacketState.FINISHED
    ]
    for packet in unreported:
        packets[packet] = {**packets.get(packet, {}), **told}
    script.packets = packets
    return unreported


def _stands_by(report: StatusReport, subject: _Subject) -> bool:
    """True if the robot repeats in its status that it has begun what it is not cleared for."""
    has_begun = report.packet_id is not None and report.packet_state in (*BEGUN_PACKETS, PacketState.PAUSED)
    return (
        has_begun
        and report.packet_id is not None
        and begun_uncleared(report.packet_id, subject.script, subject.scripts) is not None
    )


def _note_waiting(script: ScriptRow, report: StatusReport) -> None:
    """Record what the robot's packet waits for now; the packet's own report may be old or not have arrived."""
    if report.packet_id is None or report.packet_state is not PacketState.INITIALIZING:
        return
    known = script.packets.get(report.packet_id, {"state": PacketState.INITIALIZING.value})
    if known["state"] == PacketState.INITIALIZING:
        script.packets = {**script.packets, report.packet_id: {**known, "detail": report.detail}}


def _script_of(message: Message) -> str:
    """The id of the script that a message is about; empty for others, also if they have a field of that name."""
    return message.body.script_id if isinstance(message.body, OfScript) else ""


def _key(message: Message) -> str:
    """What tells a message from all others of all robots: a robot may not have another's taken for known."""
    key = f"{message.sender}/{message.id}"
    return key if len(key) <= MAX_ID else hashlib.sha256(key.encode()).hexdigest()


def _row(message: Message) -> MessageRow:
    """The message without its images, which are kept as results."""
    body = message.model_dump(mode="json", exclude={"body": {"results": {"__all__": {"data"}}}})
    return MessageRow(id=_key(message), robot=message.sender, kind=message.body.kind, body=body)
