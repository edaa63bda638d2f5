"""The book of robots' reports: each recorded once, with its consequences, in one transaction."""

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.events import (
    ClearanceRefused,
    ControlRefused,
    MissionRunning,
    PacketReported,
    ScriptAcknowledged,
    ScriptRefused,
    ScriptReported,
    ScriptStatus,
)
from app.domain.lifecycles.mission import MissionState, begin_work, is_paused
from app.domain.lifecycles.mission import has_ended as mission_has_ended
from app.domain.lifecycles.script import (
    TERMINAL_SCRIPTS,
    Delivery,
    acknowledge,
    ask,
    end,
    follow_order,
    forget,
    has_terminated,
    hear,
    note_answer,
    order,
    order_label,
    refuse,
    reissue_if_diverged,
    settle_order,
    unanswered_order,
)
from app.missions.belief_updates import BeliefUpdates
from app.missions.clearance import has_ended, renew_clearances, scripts_of
from app.missions.upkeep import note_upkeep
from app.planning.waiting_goals import WaitingGoals
from app.store import MessageRow, MissionRow, ScriptRow
from app.store.durations import learn
from robots.wire import (
    Acknowledgement,
    ControlVerb,
    Message,
    PacketReport,
    PacketState,
    Refusal,
    ScriptReport,
    ScriptState,
    StatusReport,
    UpkeepReport,
)

TERMINAL_PACKETS = frozenset({PacketState.FINISHED, PacketState.FAILED})


class MissionReports:
    """Records what robots say. A message whose id is known already changes nothing."""

    def __init__(self, core: Core, *, waiting: WaitingGoals) -> None:
        self._core = core
        self._database, self._workflows, self._events = core.database, core.workflows, core.events
        self._holdings, self._believing = core.holdings, BeliefUpdates(core)
        self._waiting = waiting

    def record(self, message: Message, world: str) -> bool:
        """Record a robot's answer or report; False if it was recorded before or concerns no known script.

        :param world: the world that the robot is in.
        """
        with self._database.write() as session:
            self._database.lock(session, message.id)  # another process may hear it, too
            if session.get(MessageRow, message.id) is not None:
                return False
            body = message.body
            if isinstance(body, UpkeepReport):
                session.add(_row(message))
                note_upkeep(session, self._core, world=world, robot=message.sender, report=body)
                return True
            script = session.get(ScriptRow, getattr(body, "script_id", ""))
            if script is None or script.robot != message.sender:
                return False
            # The mission is locked first: its other scripts change with it.
            mission = session.get_one(MissionRow, script.mission_id, with_for_update=True)
            session.refresh(script, with_for_update=True)
            session.add(_row(message))
            before = self._holdings.of_mission(session, mission)
            self._consequences(session, message, script, mission)
            if self._holdings.of_mission(session, mission) != before:
                self._waiting.release(session, mission.world)
            if not mission_has_ended(mission):  # its workflow is over, and may be forgotten
                self._workflows.wake(session, mission.workflow, message.id)
            return True

    def _consequences(
        self, session: Session, message: Message, script: ScriptRow, mission: MissionRow
    ) -> None:
        match message.body:
            case Acknowledgement():
                self._answered(session, message, script, mission, Delivery.ACKNOWLEDGED)
            case Refusal():
                self._answered(session, message, script, mission, Delivery.REFUSED)
            case PacketReport() as report:
                self._packet(session, report, script, mission)
                reissue_if_diverged(script, mission)
            case ScriptReport() as report:
                self._ended(session, report, script, mission)
            case StatusReport() as report:
                self._status(session, message, report, script)
                reissue_if_diverged(script, mission)

    def _answered(
        self, session: Session, message: Message, script: ScriptRow, mission: MissionRow, answer: Delivery
    ) -> None:
        """The robot agreed to or refused a request: of a script, of a control, or a clearance."""
        reason = message.body.reason if isinstance(message.body, Refusal) else ""
        control = unanswered_order(script)
        if message.in_reply_to == f"{script.id}:request":
            if script.delivery == Delivery.PENDING:
                self._delivered(session, script, mission, answer, reason)
        elif control is not None and message.in_reply_to == f"{script.id}:{order_label(control)}":
            if answer is Delivery.ACKNOWLEDGED:
                follow_order(script, control.verb, message.sent_at_s)
            else:
                settle_order(script)
                self._refused(session, script, "control", order_label(control), reason)
        elif script.clearance is not None and message.in_reply_to == f"{script.id}:{script.clearance}":
            clearance = script.clearance
            script.clearance = None
            if answer is Delivery.REFUSED:
                self._refused(session, script, "clearance", clearance, reason)

    def _delivered(
        self, session: Session, script: ScriptRow, mission: MissionRow, answer: Delivery, reason: str
    ) -> None:
        """The robot agreed to or refused the script."""
        if answer is Delivery.REFUSED:
            refuse(script, reason)
        else:
            acknowledge(script)
            if is_paused(mission):  # it was on its way when the operator paused the mission
                order(script, ControlVerb.PAUSE)
        if script.delivery == answer:
            answered = ScriptAcknowledged if answer is Delivery.ACKNOWLEDGED else ScriptRefused
            self._events.append(session, answered(subject=script.id, robot=script.robot, reason=reason))

    def _refused(self, session: Session, script: ScriptRow, kind: str, sent: str, reason: str) -> None:
        """An order or a clearance was refused. The robot is asked why: the script has ended, and its report is on the
        way; or it is not known any more; or the robot has followed an order with a greater number, of a record that was
        lost.
        """
        if not has_terminated(script):
            ask(script, f"{script.id}:status:{sent}")
        script.detail = reason
        if kind == "control":
            self._events.append(
                session,
                ControlRefused(subject=script.id, robot=script.robot, control=sent, reason=reason),
            )
        else:
            self._events.append(
                session,
                ClearanceRefused(subject=script.id, robot=script.robot, clearance=sent, reason=reason),
            )

    def _packet(self, session: Session, report: PacketReport, script: ScriptRow, mission: MissionRow) -> None:
        known = dict(script.packets.get(report.packet_id, {}))
        state = known.get("state")
        if state in TERMINAL_PACKETS or report.at_s < known.get("at_s", 0.0):
            return
        known |= {"state": report.state.value, "at_s": report.at_s, "detail": report.detail}
        if report.state is PacketState.RUNNING:
            known.setdefault("started_at_s", report.at_s)
        if report.state in TERMINAL_PACKETS:
            known["finished_at_s"] = report.at_s
        script.packets = {**script.packets, report.packet_id: known}
        paused = report.state is PacketState.PAUSED
        hear(script, ScriptState.PAUSED if paused else ScriptState.RUNNING, report.at_s)
        if script.plan_id == mission.plan_id:
            self._started(session, mission, report.at_s)
        if report.state is PacketState.FINISHED:
            if has_ended(scripts_of(session, mission, script.plan_id), report.packet_id):
                self._believing.came_true(session, report.packet_id, report.at_s, script, mission)
            learn(session, mission.world, script, report.packet_id, known)
            renew_clearances(session, self._events, mission)
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

    def _started(self, session: Session, mission: MissionRow, at_s: float) -> None:
        """The first report of work starts the mission's expected time."""
        if mission.started_at_s is None:
            mission.started_at_s = at_s
            mission.enquire_at_s = at_s + mission.estimate_s + mission.margin_s
        if begin_work(mission):
            running = MissionRunning(subject=mission.id, started_at_s=at_s, state=MissionState(mission.state))
            self._events.append(session, running)

    def _ended(self, session: Session, report: ScriptReport, script: ScriptRow, mission: MissionRow) -> None:
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
        if report.state is ScriptState.FINISHED:
            self._finish_all(session, report, script, mission)
            renew_clearances(session, self._events, mission)
        else:
            self._believing.reconcile(session, report, script, mission)
        self._events.append(
            session,
            ScriptReported(
                subject=script.id,
                robot=script.robot,
                mission=mission.id,
                state=report.state,
                at_s=report.at_s,
                detail=report.detail,
            ),
        )

    def _finish_all(
        self, session: Session, report: ScriptReport, script: ScriptRow, mission: MissionRow
    ) -> None:
        """A script that has finished has finished each of its packets, though the report of it is still under way."""
        for packet in [one["id"] for one in script.body["packets"]]:
            known = script.packets.get(packet, {})
            if known.get("state") == PacketState.FINISHED:
                continue
            told = {"state": PacketState.FINISHED.value, "at_s": report.at_s, "finished_at_s": report.at_s}
            script.packets = {**script.packets, packet: {**known, **told}}
            if has_ended(scripts_of(session, mission, script.plan_id), packet):
                self._believing.came_true(session, packet, report.at_s, script, mission)

    def _status(self, session: Session, message: Message, report: StatusReport, script: ScriptRow) -> None:
        note_answer(script, message.in_reply_to)
        script.orders = max(script.orders, report.order)
        if has_terminated(script):
            return
        if report.state is None:
            forget(script, f"{script.robot} does not know the script it was given")
        elif report.state not in TERMINAL_SCRIPTS:
            # A terminal state comes with its own report, which says what was perceived.
            hear(script, report.state, report.at_s)
        self._note_waiting(report, script)
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

    def _note_waiting(self, report: StatusReport, script: ScriptRow) -> None:
        """What the robot's packet waits for now; the report that it came up may be old or still under way."""
        if report.packet_id is None or report.packet_state is not PacketState.INITIALIZING:
            return
        known = script.packets.get(report.packet_id, {"state": PacketState.INITIALIZING.value})
        if known["state"] == PacketState.INITIALIZING:
            script.packets = {**script.packets, report.packet_id: {**known, "detail": report.detail}}


def _row(message: Message) -> MessageRow:
    body = message.model_dump(mode="json")
    return MessageRow(id=message.id, robot=message.sender, kind=message.body.kind, body=body)
