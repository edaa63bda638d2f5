"""Plays the service for one robot, and notes which rules of the contract it keeps."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from pydantic import ValidationError

from app.cli.trials.conformance.line import ANOTHER_RUN, RUN, Heard, Line
from app.cli.trials.conformance.rules import Finding, Rule, Verdict
from robots.link.mqtt.topics import Channel, ConnectionState, Presence
from robots.wire import (
    Acknowledgement,
    BehaviourPacket,
    BehaviourScript,
    Control,
    ControlVerb,
    Factsheet,
    Message,
    NotUnderstood,
    PacketReport,
    PacketState,
    Performative,
    Refusal,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    StatusQuery,
    StatusReport,
    Telemetry,
    new_message_id,
)

STRANGE_TAG = "NO_SUCH_PACKET_EVER"
OTHERS_ACTION = "action-of-another"
NOBODYS = "script-that-nobody-has"
CUT_FACTOR = 1.5
"""The robot is cut off for so many times as long as its packet took before (our choice)."""


class Relay(Protocol):
    """What the robot's connections pass through, so that they can be cut off."""

    @property
    def address(self) -> str: ...

    def cut(self) -> int:
        """End all connections, and refuse new ones until `restore`; returns how many there were."""
        ...

    def restore(self) -> None: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckRequest:
    """What the robot is given to do.

    :param tag: of the packet; None: the first of its factsheet.
    :param arguments: of the packet.
    :param packet_s: how long it is expected to take.
    :param patience_s: how long an answer or a packet may take.
    :param quiet_s: how long is waited for what must not happen.
    """

    tag: str | None = None
    arguments: dict[str, str] = field(default_factory=dict)
    packet_s: float = 3.0
    patience_s: float = 20.0
    quiet_s: float = 2.0


class RobotCheck:
    """One run of the check."""

    def __init__(self, line: Line, request: CheckRequest, *, relay: Relay | None = None) -> None:
        """:param relay: None: the robot is not cut off, and what depends on that is not tried."""
        self._line = line
        self._request = request
        self._relay = relay
        self._took_s = request.packet_s
        """How long the first packet took at most."""
        self._found: dict[Rule, Finding] = {}
        self._tag = request.tag or ""

    def run(self) -> Sequence[Finding]:
        """The findings, one for each rule."""
        if self._meets():
            self._try_queries()
            self._try_refusal()
            self._try_script()
            self._try_orders()
            self._try_stale()
            self._try_cut_off()
            self._judge_all_heard()
        else:
            why = "it did not appear" if not self._line.heard else "no packet to give it is known: say --tag"
            self._skip(why, *Rule)
        return [
            self._found.get(rule)
            or Finding(rule=rule, verdict=Verdict.UNTRIED, detail=_WHY_UNTRIED.get(rule, "nothing led to it"))
            for rule in Rule
        ]

    def _note(self, rule: Rule, kept: object, fault: str = "", seen: str = "") -> bool:
        """Note a verdict, once; a rule that was broken stays so."""
        is_kept = bool(kept)
        before = self._found.get(rule)
        if before is None or (before.verdict is not Verdict.BROKEN and not is_kept):
            verdict = Verdict.KEPT if is_kept else Verdict.BROKEN
            self._found[rule] = Finding(rule=rule, verdict=verdict, detail=seen if is_kept else fault)
        return is_kept

    def _skip(self, why: str, *rules: Rule) -> None:
        for rule in rules:
            self._found.setdefault(rule, Finding(rule=rule, verdict=Verdict.UNTRIED, detail=why))

    def _keeps(self, rule: Rule) -> bool:
        return rule in self._found and self._found[rule].verdict is Verdict.KEPT

    def _until(self, holds: Callable[[], Any]) -> bool:
        return self._line.until(holds, self._request.patience_s)

    def _meets(self) -> bool:
        """Wait for the robot; False if it does not appear at all."""
        self._until(lambda: self._sheet() is not None and self._is_online())
        self._note(Rule.CONNECTION, self._is_online(), "no `online` on its connection topic was heard")
        sheet = self._sheet()
        self._note(Rule.ANNOUNCES, sheet is not None, "no well-formed factsheet of this run was heard")
        if sheet is None or not isinstance(body := sheet.body, Factsheet):
            return any(one.channel is not Channel.CONNECTION for one in self._line.heard) and bool(self._tag)
        self._tag = self._tag or next(iter(body.repertoire), "")
        answer = {"kind": "factsheet_answer", "state": "in_force", "reason": ""}
        self._line.send(Performative.CONFIRM, answer, reply=sheet.id)
        return bool(self._tag)

    def _sheet(self) -> Message | None:
        return next(
            (
                one.message
                for one in self._line.heard
                if one.message is not None
                and one.channel is Channel.FACTSHEET
                and one.publication.run == RUN
                and isinstance(one.message.body, Factsheet)
            ),
            None,
        )

    def _is_online(self, since: int = 0) -> bool:
        return self._has_shown(ConnectionState.ONLINE, since)

    def _has_shown(self, state: ConnectionState, since: int) -> bool:
        return any(
            _presence(one) is state for one in self._line.heard[since:] if one.channel is Channel.CONNECTION
        )

    def _ask(
        self, performative: Performative, body: Any, *, within_s: float | None = None, **kwargs: Any
    ) -> Message | None:
        """Send a request, and return its answer; None if there is none."""
        asked = self._line.send(performative, body, **kwargs)
        self._line.until(lambda: self._line.answer(asked), within_s or self._request.patience_s)
        return self._line.answer(asked)

    def _status(self, script: str, **extra: Any) -> StatusReport | None:
        query = StatusQuery(script_id=script).model_dump() | extra
        answer = self._ask(Performative.QUERY, query)
        return answer.body if answer is not None and isinstance(answer.body, StatusReport) else None

    def _try_queries(self) -> None:
        unknown = self._status(NOBODYS)
        is_right = unknown is not None and unknown.state is None
        words = (
            "no status report came" if unknown is None else f"of an unknown script it says {unknown.state}"
        )
        if self._note(Rule.STATUS, is_right, words):
            extra = self._status(NOBODYS, of_tomorrow={"level": [1, 2]})
            self._note(Rule.UNKNOWN_FIELDS, extra is not None, "a query with a field more is not answered")
            stray = StatusQuery(script_id="script-of-another-run")
            asked = self._ask(Performative.QUERY, stray, within_s=self._request.quiet_s, run=ANOTHER_RUN)
            self._note(Rule.OTHER_RUNS, asked is None, "it answers a message of another run")
        else:
            self._skip("it answers no status queries", Rule.UNKNOWN_FIELDS, Rule.OTHER_RUNS)
        dance = self._ask(Performative.REQUEST, {"kind": "dance_of_tomorrow", "steps": 3})
        understood = (
            dance is not None
            and dance.performative is Performative.NOT_UNDERSTOOD
            and isinstance(dance.body, NotUnderstood)
        )
        self._note(Rule.UNKNOWN_KINDS, understood, "it does not answer a message of an unknown kind with it")

    def _packet(self, packet_id: str, *, tag: str = "", after: tuple[str, ...] = ()) -> BehaviourPacket:
        return BehaviourPacket(
            id=packet_id,
            tag=tag or self._tag,
            arguments=self._request.arguments,
            after=after,
            expected_start_s=0.0,
            expected_duration_s=self._request.packet_s,
            timeout_s=10 * self._request.packet_s + self._request.patience_s,
            wait_timeout_s=10 * self._request.patience_s,
            description="a packet of the check",
        )

    def _script(self, *packets: BehaviourPacket) -> BehaviourScript:
        script = f"check-{new_message_id()[:8]}"
        return BehaviourScript(id=script, mission_id=f"of-{script}", robot=self._line.robot, packets=packets)

    def _give(self, script: BehaviourScript) -> Message | None:
        request = ScriptRequest(script=script)
        return self._ask(
            Performative.REQUEST, request, message_id=f"{script.id}:request", channel=Channel.ORDER
        )

    def _try_refusal(self) -> None:
        script = self._script(self._packet("a1", tag=STRANGE_TAG))
        answer = self._give(script)
        refused = answer is not None and isinstance(answer.body, Refusal) and answer.body.reason
        self._note(Rule.REFUSES, refused, f"it does not refuse a script with the packet {STRANGE_TAG}")
        if not refused:
            self._order(script, ControlVerb.CANCEL, 1)

    def _reports(self, script: BehaviourScript) -> list[PacketReport]:
        """The reports on the script's packets, each once."""
        said = {message.id: message.body for message in self._line.messages()}
        return [
            body for body in said.values() if isinstance(body, PacketReport) and body.script_id == script.id
        ]

    def _has(self, script: BehaviourScript, packet: str, state: PacketState) -> bool:
        return any(one.packet_id == packet and one.state is state for one in self._reports(script))

    def _duration_s(self, script: BehaviourScript, packet: str) -> float:
        """How long a packet took by the robot's reports; 0 if it has not ended."""
        at_s = {one.state: one.at_s for one in self._reports(script) if one.packet_id == packet}
        ended_s = at_s.get(PacketState.FINISHED, 0.0)
        return ended_s - at_s.get(PacketState.RUNNING, ended_s)

    def _end(self, script: BehaviourScript) -> ScriptReport | None:
        bodies = (message.body for message in self._line.messages())
        return next(
            (one for one in bodies if isinstance(one, ScriptReport) and one.script_id == script.id), None
        )

    def _try_script(self) -> None:
        script = self._script(self._packet("a1"), self._packet("a2", after=(OTHERS_ACTION,)))
        self._line.withholds_receipts = True
        answer = self._give(script)
        agreed = answer is not None and isinstance(answer.body, Acknowledgement)
        why = "" if answer is None else f": {getattr(answer.body, 'reason', answer.body.kind)}"
        if not self._note(Rule.ACKNOWLEDGES, agreed, f"a script was not acknowledged{why}"):
            self._line.withholds_receipts = False
            return
        self._try_repetition(script)
        self._try_receipts()
        began = self._until(lambda: self._has(script, "a1", PacketState.FINISHED))
        self._took_s = max(self._took_s, self._duration_s(script, "a1"))
        self._line.listen(self._request.quiet_s)
        early = self._has(script, "a2", PacketState.RUNNING) or self._has(script, "a2", PacketState.FINISHED)
        if self._keeps(Rule.STATUS) and began and not early:
            status = self._status(script.id)
            is_right = status is not None and status.state in (ScriptState.RUNNING, ScriptState.ACCEPTED)
            self._note(Rule.STATUS, is_right, f"of its script it says {status and status.state}")
        cleared = self._clear(script)
        ended = self._until(lambda: self._end(script) is not None)
        if began:
            ran_on = cleared is not None and isinstance(cleared.body, Acknowledgement) and ended
            fault = "it began before the clearance" if early else "it did not go on after the clearance"
            self._note(Rule.CLEARANCE, ran_on and not early, fault)
        self._judge_order(script)

    def _try_repetition(self, script: BehaviourScript) -> None:
        self._until(lambda: self._has(script, "a1", PacketState.RUNNING))
        before = len(self._line.heard)
        request = f"{script.id}:request"
        self._line.send(
            Performative.REQUEST, ScriptRequest(script=script), message_id=request, channel=Channel.ORDER
        )
        answered = self._line.until(
            lambda: any(one.in_reply_to == request for one in self._line.messages(before)),
            self._request.patience_s,
        )
        again = [one for one in self._line.messages(before) if one.in_reply_to == request]
        agrees = answered and all(isinstance(one.body, Acknowledgement) for one in again)
        self._note(Rule.ONCE, agrees, "a repeated request does not get its answer again")

    def _try_receipts(self) -> None:
        """Reports get no receipts: one of them must come again. Then all get theirs."""

        def repeated() -> set[str]:
            ids = [m.id for m in self._line.messages() if isinstance(m.body, PacketReport)]
            return {one for one in ids if ids.count(one) > 1}

        came_again = self._until(repeated)
        self._line.withholds_receipts = False
        known = {m.id for m in self._line.messages() if m.in_reply_to is None}
        for one in known:
            self._line.confirm(one)
        # What the robot sends until it answers may be from before it has read the receipts.
        self._status(NOBODYS)
        self._line.listen(self._request.quiet_s)
        before = len(self._line.heard)
        self._line.listen(self._request.quiet_s + 2.0)
        late = [m for m in self._line.messages(before) if m.id in known]
        fault = (
            "no report came again without its receipt" if not came_again else "it repeats what has a receipt"
        )
        self._note(Rule.RECEIPTS, came_again and not late, fault)

    def _judge_order(self, script: BehaviourScript) -> None:
        seen = [
            (one.packet_id, one.state)
            for one in self._reports(script)
            if one.state in (PacketState.RUNNING, PacketState.FINISHED)
        ]
        runs = [one for one in seen if one[1] is PacketState.RUNNING]
        if len(runs) > len(set(runs)):
            self._note(Rule.ONCE, False, "it followed a repeated request twice")
            return
        right = [
            (packet.id, state)
            for packet in script.packets
            for state in (PacketState.RUNNING, PacketState.FINISHED)
        ]
        end = self._end(script)
        fault = f"it reported {', '.join(f'{p} {s.value}' for p, s in seen) or 'nothing'}"
        if self._found.get(Rule.CLEARANCE, None) is None or self._keeps(Rule.CLEARANCE):
            finished = end is not None and end.state is ScriptState.FINISHED
            self._note(
                Rule.IN_ORDER, seen == right and finished, fault + ("" if end else "; no script report")
            )

    def _order(self, script: BehaviourScript, verb: ControlVerb, number: int) -> Message | None:
        cancels = verb is ControlVerb.CANCEL
        return self._ask(
            Performative.CANCEL if cancels else Performative.REQUEST,
            Control(script_id=script.id, verb=verb, number=number),
        )

    def _try_orders(self) -> None:
        rules = (Rule.PAUSES, Rule.RESUMES, Rule.ORDER_NUMBERS, Rule.CANCELS)
        if not self._keeps(Rule.ACKNOWLEDGES):
            self._skip("it acknowledges no script", *rules)
            return
        script = self._script(self._packet("a1"), self._packet("a2", after=(OTHERS_ACTION,)))
        if (answer := self._give(script)) is None or not isinstance(answer.body, Acknowledgement):
            self._skip("it did not acknowledge another script", *rules)
            return
        self._until(lambda: self._has(script, "a1", PacketState.RUNNING))
        self._try_pause(script)
        cancelled = self._order(script, ControlVerb.CANCEL, 9)
        agreed = cancelled is not None and isinstance(cancelled.body, Acknowledgement)
        self._until(lambda: self._end(script) is not None)
        end = self._end(script)
        ended = end is not None and end.state is ScriptState.CANCELLED
        fault = (
            "it does not agree to a cancel" if not agreed else "it does not report the script as cancelled"
        )
        if not self._note(Rule.CANCELS, agreed and ended, fault) and end is None:
            self._clear(script)
            self._until(lambda: self._end(script) is not None)

    def _clear(self, script: BehaviourScript) -> Message | None:
        clearance = {"kind": "clearance", "script_id": script.id, "ended": [OTHERS_ACTION]}
        return self._ask(Performative.REQUEST, clearance)

    def _try_pause(self, script: BehaviourScript) -> None:
        answer = self._order(script, ControlVerb.PAUSE, 3)
        if answer is not None and isinstance(answer.body, Refusal):
            self._note(Rule.PAUSES, False, f"it refuses to pause: {answer.body.reason}")
            self._skip("it does not pause", Rule.RESUMES, Rule.ORDER_NUMBERS)
            return
        agreed = answer is not None and isinstance(answer.body, Acknowledgement)
        paused = agreed and self._until(
            lambda: any(one.state is PacketState.PAUSED for one in self._reports(script))
        )
        fault = "no packet report says paused" if agreed else "it does not agree to a pause"
        if not self._note(Rule.PAUSES, paused, fault):
            self._skip("it does not pause", Rule.RESUMES, Rule.ORDER_NUMBERS)
            return
        old = self._order(script, ControlVerb.RESUME, 2)
        is_refused = old is not None and isinstance(old.body, Refusal)
        self._note(Rule.ORDER_NUMBERS, is_refused, "it follows an order with a lower number")
        before = len(self._reports(script))
        answer = self._order(script, ControlVerb.RESUME, 4)
        agreed = answer is not None and isinstance(answer.body, Acknowledgement)
        resumed = agreed and (
            not is_refused
            or self._until(
                lambda: any(one.state is not PacketState.PAUSED for one in self._reports(script)[before:])
            )
        )
        self._note(Rule.RESUMES, resumed, "it does not go on after a resume")

    def _try_stale(self) -> None:
        if not self._keeps(Rule.CANCELS):
            self._skip("it does not cancel", Rule.STALE)
            return
        script = self._script(self._packet("a1", after=(OTHERS_ACTION,)))
        self._order(script, ControlVerb.CANCEL, 1)
        answer = self._give(script)
        refused = answer is not None and isinstance(answer.body, Refusal)
        self._note(Rule.STALE, refused, "it takes a script that was cancelled before it arrived")
        if not refused:
            self._ask(Performative.CANCEL, Control(script_id=script.id, verb=ControlVerb.CANCEL, number=2))

    def _try_cut_off(self) -> None:
        rules = (Rule.LAST_WILL, Rule.RECONNECTS)
        if self._relay is None:
            self._skip("it was not cut off: give --relay, and let the robot connect there", *rules)
            return
        script = self._script(self._packet("a1"), self._packet("a2", after=(OTHERS_ACTION,)))
        answer = self._give(script) if self._keeps(Rule.ACKNOWLEDGES) else None
        if answer is None or not isinstance(answer.body, Acknowledgement):
            self._skip("it did not acknowledge a script to be cut off with", *rules)
            return
        self._until(lambda: self._has(script, "a1", PacketState.RUNNING))
        since = len(self._line.heard)
        if not self._relay.cut():
            self._skip(f"it did not connect through the relay at {self._relay.address}", *rules)
            self._relay.restore()
            self._order(script, ControlVerb.CANCEL, 1)
            return
        cut_s = CUT_FACTOR * self._took_s + self._request.quiet_s
        self._line.listen(cut_s)
        is_told = self._has_shown(ConnectionState.CONNECTION_BROKEN, since)
        self._note(Rule.LAST_WILL, is_told, "its connection was lost, and no `connection_broken` was heard")
        since = len(self._line.heard)
        self._relay.restore()
        if not self._keeps(Rule.RECEIPTS):
            self._skip("it does not repeat its reports until their receipts", Rule.RECONNECTS)
            self._order(script, ControlVerb.CANCEL, 1)
            return
        fault = self._fault_after_cut(script, since, self._line.now_s())
        self._note(Rule.RECONNECTS, not fault, fault, f"cut off for {cut_s:.1f} s")
        if fault:
            self._order(script, ControlVerb.CANCEL, 1)

    def _fault_after_cut(self, script: BehaviourScript, since: int, restored_s: float) -> str:
        """What is wrong with a robot that was cut off while it carried out its first packet; empty if nothing is."""
        if not self._until(lambda: self._is_online(since)):
            return "it did not say again that it is online"
        if not self._until(lambda: self._has(script, "a1", PacketState.FINISHED)):
            return "it did not report the packet that it had under way"
        finished_s = max(one.at_s for one in self._reports(script) if one.state is PacketState.FINISHED)
        if finished_s > restored_s:
            return (
                f"it stood still without a connection: its packet, which takes {self._took_s:.1f} s, ended "
                f"{finished_s - restored_s:.1f} s after that was restored"
            )
        self._clear(script)
        if not self._until(lambda: self._end(script) is not None):
            return "it did not end its script after that"
        runs = [one.packet_id for one in self._reports(script) if one.state is PacketState.RUNNING]
        return "it began a packet twice" if len(runs) > len(set(runs)) else ""

    def _judge_all_heard(self) -> None:
        faults = [self._fault_of(one) for one in self._line.heard]
        wrong = [fault for fault in faults if fault]
        self._note(Rule.WELL_FORMED, not wrong, wrong[0] if wrong else "")
        for rule, faults_of in ((Rule.RETAINED, _retention_fault), (Rule.QOS, _qos_fault)):
            found = [words for one in self._line.heard if (words := faults_of(one))]
            self._note(rule, not found, found[0] if found else "")
        shown = [one for one in self._line.heard if one.channel is Channel.VISUALIZATION]
        if shown:
            bad = [words for one in shown if (words := _telemetry_fault(one))]
            self._note(Rule.TELEMETRY, not bad, bad[0] if bad else "")

    def _fault_of(self, heard: Heard) -> str:
        if heard.channel in (Channel.VISUALIZATION, Channel.CONNECTION):
            return ""
        if heard.fault:
            return f"{heard.channel.value}: {heard.fault}"
        if heard.message is None:
            return ""
        if heard.message.sender != self._line.robot:
            return f"{heard.channel.value}: its sender is {heard.message.sender}"
        # The factsheet of an earlier run stays at the broker until there is another.
        if heard.publication.run != RUN and heard.channel is not Channel.FACTSHEET:
            return f"{heard.channel.value}: a {heard.message.body.kind} without the run as user property"
        return ""


_WHY_UNTRIED = {Rule.TELEMETRY: "no telemetry was heard"}
_RETAINED = (Channel.CONNECTION, Channel.FACTSHEET)


def _retention_fault(heard: Heard) -> str:
    if heard.publication.retain == (heard.channel in _RETAINED):
        return ""
    return f"{heard.channel.value}: published {'' if heard.publication.retain else 'not '}retained"


def _qos_fault(heard: Heard) -> str:
    if heard.publication.qos == heard.channel.qos:
        return ""
    return f"{heard.channel.value}: published with QoS {heard.publication.qos}, not {heard.channel.qos}"


def _presence(heard: Heard) -> ConnectionState | None:
    try:
        return Presence.model_validate_json(heard.publication.payload).state
    except ValidationError:
        return None


def _telemetry_fault(heard: Heard) -> str:
    try:
        Telemetry.model_validate_json(heard.publication.payload)
    except ValidationError as error:
        fault = error.errors(include_url=False, include_input=False)[0]
        return f"{'.'.join(map(str, fault['loc'])) or 'payload'}: {fault['msg']}"
    return ""
