"""Keeps the contract with the service for a robot that is driven packet by packet. Call `tick()` at 10 Hz."""

import logging
from collections import OrderedDict
from collections.abc import Callable, Mapping, Set
from typing import Any

from pydantic import ValidationError

from robots.adapters.driver import DriverMemory, PacketDriver, SensingDriver
from robots.adapters.memory import ContractMemory, RunMemory
from robots.adapters.packet_forms import PacketForm, why_refused
from robots.adapters.script_run import ScriptRun
from robots.clock import Clock
from robots.contract.held_link import HeldLink
from robots.contract.known_scripts import ScriptStates, StaleScripts, remember, supersedes
from robots.contract.mailbox import Mailbox
from robots.contract.memory_file import MemoryStore
from robots.contract.telemetry_rate import TELEMETRY_S, is_due
from robots.errors import RobotError
from robots.link import Link
from robots.wire import (
    BehaviourScript,
    Clearance,
    Control,
    ControlVerb,
    Factsheet,
    FactsheetAnswer,
    FailureCategory,
    FaultReport,
    Message,
    MindOrder,
    MindOrderReport,
    MindQuery,
    MindReport,
    MindTransfer,
    MindTransferReport,
    Performative,
    Retune,
    RuleSet,
    RulesReport,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    SetPoint,
    SetPointRefusal,
    StatusQuery,
    StatusReport,
    Telemetry,
    TraceQuery,
    TraceReport,
    TuningReport,
    UpkeepReport,
)

SAVED_EVERY_S = 1.0
"""Interval at which the times of a packet under way are saved."""

logger = logging.getLogger(__name__)


class MemoryUnusable(RobotError):
    """Raised when a robot's persistent memory cannot be used; says what to do."""


class ContractRobot:
    """Receives scripts, has a driver carry out their packets, reports. One thread calls it."""

    def __init__(
        self,
        name: str,
        *,
        driver: PacketDriver,
        packets: Mapping[str, PacketForm],
        link: Link,
        clock: Clock,
        store: MemoryStore | None = None,
        factsheet: Factsheet | None = None,
        objection: Callable[[BehaviourScript], str | None] = lambda script: None,
        run: str | None = None,
        round_trip_s: float = 0.0,
    ) -> None:
        """
        :param packets: the forms of the packets that it takes, by tag.
        :param store: its persistent memory; None: it forgets everything at a restart, and must stand still then.
        :param factsheet: what the robot tells of itself, at its start if it has changed.
        :param objection: why the driver cannot carry a script out that is otherwise fit, None if it can.
        :param run: of the world; None: that which the memory is of, until `enter_run`.
        :param round_trip_s: the longest travel time of a report and its receipt together.
        :raises MemoryUnusable: if the memory cannot be read, or is another robot's.
        """
        self.name = name
        self._driver = driver
        self._packets = packets
        self._clock = clock
        self._store = store
        self._objection = objection
        self._factsheet = factsheet
        self._link = HeldLink(link)
        self._round_trip_s = round_trip_s
        self._last_s: float | None = None
        self._telemetry_s = float("-inf")
        self._sent_telemetry: Telemetry | None = None
        self._saved_s = float("-inf")
        self._saved_changes = -1
        self._saved_driver: Mapping[str, Any] = {}
        self._complaint = ""
        self.factsheet_answer: FactsheetAnswer | None = None
        """What the service last told of the factsheet."""
        self._runs: list[ScriptRun] = []
        """The current script first, then the one that supersedes it."""
        self._faults: FaultReport | None = None
        self._begin(ContractMemory(robot=name, run=run or ""))
        memory = self._load()
        if memory is not None:
            self._recall(memory)
            self.enter_run(memory.run if run is None else run)

    @property
    def run(self) -> str:
        """The world's run that its scripts belong to."""
        return self._run

    @property
    def complaint(self) -> str:
        """Why the memory cannot be saved, in words; empty if it can. Until then nothing is answered or begun."""
        return self._complaint

    @property
    def script_id(self) -> str | None:
        """The current script; None if there is none."""
        run = self._current
        return run.script.id if run is not None and not run.is_silent else None

    def enter_run(self, run: str) -> None:
        """Take orders of this run of the world from now on. With another run, scripts and reports are forgotten."""
        if run == self._run:
            return
        leaving = self._current
        self._begin(ContractMemory(robot=self.name, run=run))
        if leaving is not None:
            leaving.silence()
            self._runs = [leaving]
        self._changed = True

    def report_faults(self, report: FaultReport) -> None:
        """Report at the next tick what faults the robot has; kept until the service has it."""
        self._faults = report

    def report_upkeep(self, report: UpkeepReport) -> None:
        """Report at the next tick what the robot did of itself; kept until the service has it."""
        self._upkeep.append(report)

    def tick(self) -> None:
        """Follow the packet, handle messages, report, save, and only then send and begin."""
        now_s = self._clock.now_s()
        step_s = max(0.0, now_s - self._last_s) if self._last_s is not None else 0.0
        self._last_s = now_s
        self._advance(step_s, now_s)
        for message in self._mailbox.collect(now_s):
            self._handle(message, now_s)
        self._announce(now_s)
        self._send_reports(now_s)
        self._send_telemetry(now_s)
        self._mailbox.resend(now_s)
        is_saved = self._save(now_s)
        if is_saved:
            self._link.release()
        else:
            self._link.discard()
        if (run := self._current) is not None:
            run.command(may_start=is_saved)
        self._save(now_s)

    def _begin(self, memory: ContractMemory) -> None:
        self._run = memory.run
        self._mailbox = Mailbox(self.name, self._link, round_trip_s=self._round_trip_s)
        self._states = ScriptStates()
        self._stale = StaleScripts()
        self._verdicts: OrderedDict[str, str | None] = OrderedDict(memory.verdicts)
        self._announced = memory.announced
        self._runs = []
        self._reports: list[ScriptReport] = []
        self._upkeep: list[UpkeepReport] = []
        self._faults = None
        self._changed = False

    def _recall(self, memory: ContractMemory) -> None:
        self._begin(memory)
        self._mailbox.recall(memory.mailbox, self._clock.now_s())
        self._states.recall(memory.states)
        self._stale.recall(memory.stale)
        if isinstance(self._driver, DriverMemory):
            self._driver.recall(memory.driver)
        self._runs = [ScriptRun(one.saved(), self._driver, self._states) for one in memory.runs]

    def _load(self) -> ContractMemory | None:
        if self._store is None:
            return None
        try:
            text = self._store.load()
            memory = None if text is None else ContractMemory.model_validate_json(text)
        except (OSError, ValidationError, ValueError) as error:
            raise MemoryUnusable(
                f"the memory of {self.name}, {self._store}, cannot be read: {error}; if the robot stands still and its "
                "mission has ended, move the file away and start again"
            ) from error
        if memory is not None and memory.robot != self.name:
            raise MemoryUnusable(
                f"{self._store} is the memory of {memory.robot}, this is {self.name}; give each robot a file of its own"
            )
        return memory

    def _memory(self) -> ContractMemory:
        return ContractMemory(
            robot=self.name,
            run=self._run,
            mailbox=self._mailbox.memory(),
            runs=tuple(run.memory() for run in self._runs if not run.has_ended),
            states=self._states.memory(),
            verdicts=dict(self._verdicts),
            stale=self._stale.memory(),
            announced=self._announced,
            driver=dict(self._saved_driver),
        )

    def _save(self, now_s: float) -> bool:
        """True if the memory is on the disk as it is."""
        if self._store is None:
            return True
        own = self._driver.memory() if isinstance(self._driver, DriverMemory) else {}
        is_under_way = self._current is not None and now_s - self._saved_s >= SAVED_EVERY_S
        has_changed = (
            self._changed or self._mailbox.changes != self._saved_changes or own != self._saved_driver
        )
        if not has_changed and not is_under_way:
            return True
        self._saved_driver = dict(own)
        try:
            self._store.save(self._memory().model_dump_json())
        except OSError as error:
            if not self._complaint:
                logger.error("%s: the memory %s cannot be saved: %s", self.name, self._store, error)
            self._complaint = f"the memory {self._store} cannot be saved: {error}"
            self._changed = True
            return False
        self._complaint = ""
        self._changed = False
        self._saved_changes = self._mailbox.changes
        self._saved_s = now_s
        return True

    @property
    def _current(self) -> ScriptRun | None:
        return self._runs[0] if self._runs else None

    def _advance(self, step_s: float, now_s: float) -> None:
        """Nothing goes on while it cannot be remembered."""
        if (run := self._current) is not None and not self._complaint:
            self._changed |= run.advance(step_s, now_s)

    def _handle(self, message: Message, now_s: float) -> None:
        match message.body:
            case ScriptRequest(script=script):
                if script.id not in self._verdicts:
                    remember(self._verdicts, script.id, self._accept(script, now_s))
                self._mailbox.agree_or_refuse(message, script.id, self._verdicts[script.id], now_s)
            case Control() as order:
                self._mailbox.agree_or_refuse(message, order.script_id, self._control(order, now_s), now_s)
            case Clearance(script_id=script_id, ended=ended):
                run = self._active(script_id)
                if run is not None:
                    run.clear(ended)
                reason = self._states.why_not_active(script_id) if run is None else None
                self._mailbox.agree_or_refuse(message, script_id, reason, now_s)
            case StatusQuery(script_id=script_id):
                self._mailbox.answer(message, Performative.INFORM, self._status(script_id, now_s), now_s)
            case FactsheetAnswer() as answer:
                self.factsheet_answer = answer
            case _:
                self._decline(message, now_s)
        self._changed = True

    def _decline(self, message: Message, now_s: float) -> None:
        """Answer what only robots with behaviour patterns can do."""
        match message.body:
            case Retune(version=version):
                report = TuningReport(version=version, reason=f"{self.name} has no patterns to tune")
                self._mailbox.answer(message, Performative.REFUSE, report, now_s)
            case RuleSet(version=version):
                followed = RulesReport(version=version, reason=f"{self.name} follows no rules")
                self._mailbox.answer(message, Performative.REFUSE, followed, now_s)
            case MindOrder() as order:
                stays = MindOrderReport(
                    verb=order.verb, fence=order.fence, reason=f"{self.name} has a body of its own"
                )
                self._mailbox.answer(message, Performative.REFUSE, stays, now_s)
            case MindTransfer(fence=fence, mind=mind):
                kept = MindTransferReport(
                    fence=fence,
                    digest=mind.digest,
                    number=mind.number,
                    reason=f"{self.name} is driven packet by packet and takes no minds",
                )
                self._mailbox.answer(message, Performative.REFUSE, kept, now_s)
            case SetPoint(driver=driver):
                refusal = SetPointRefusal(
                    driver=driver, reason=f"{self.name} cannot be driven by an operator"
                )
                self._mailbox.tell(message, refusal, now_s, Performative.REFUSE)
            case TraceQuery():
                self._mailbox.tell(message, TraceReport(at_s=now_s), now_s)
            case MindQuery():
                self._mailbox.tell(message, MindReport(at_s=now_s), now_s)

    def _accept(self, script: BehaviourScript, now_s: float) -> str | None:
        """Accept a script and end the one it supersedes, or return the reason against it."""
        if (stale := self._stale.refusal(script)) is not None:
            return stale
        older = [run for run in self._runs if supersedes(script, run.script) and not run.is_silent]
        for run in older:
            run.cancel(f"superseded by revision {script.revision} of its mission", now_s)
        busy = next((run for run in self._runs if not (run in older or run.has_ended or run.is_silent)), None)
        if busy is not None:
            return f"{self.name} is busy with script {busy.script.id}"
        senses: Set[str] = self._driver.senses if isinstance(self._driver, SensingDriver) else frozenset()
        reason = why_refused(script, self.name, self._packets, senses) or self._objection(script)
        if reason is not None:
            return reason
        self._states.note(script.id, ScriptState.ACCEPTED)
        self._runs.append(ScriptRun(RunMemory(script=script), self._driver, self._states))
        return None

    def _control(self, order: Control, now_s: float) -> str | None:
        """Follow an order on a script, or return the reason against it. A cancel may arrive before its script."""
        script_id = order.script_id
        if (run := self._active(script_id)) is not None:
            return run.control(order.verb, order.number, now_s)
        is_early = order.verb is ControlVerb.CANCEL and script_id not in self._verdicts
        if not is_early or script_id in self._states:
            return self._states.why_not_active(script_id)
        self._stale.cancel(script_id)
        self._states.note(script_id, ScriptState.CANCELLED)
        self._reports.append(
            ScriptReport(
                script_id=script_id,
                state=ScriptState.CANCELLED,
                at_s=now_s,
                category=FailureCategory.CANCELLED,
                detail="cancelled before it arrived",
            )
        )
        return None

    def _active(self, script_id: str) -> ScriptRun | None:
        """The run of a script that has not ended; None if there is none."""
        runs = (run for run in self._runs if run.script.id == script_id and not run.is_silent)
        return next((run for run in runs if not run.has_ended), None)

    def _status(self, script_id: str, now_s: float) -> StatusReport:
        run = self._active(script_id)
        packet = run.packet if run is not None else None
        return StatusReport(
            script_id=script_id,
            state=self._states.of(script_id),
            at_s=now_s,
            packet_id=packet.id if packet else None,
            packet_state=run.packet_state if run else None,
            perceived=run.perceived if run else (),
            detail=run.waits_for if run else "",
            order=run.order if run else 0,
        )

    def _announce(self, now_s: float) -> None:
        """Send the factsheet once, unless the last one said the same."""
        told = self._announced
        if self._factsheet is None or (told is not None and told.content == self._factsheet.content):
            return
        number = 0 if told is None else told.number + 1
        self._announced = self._factsheet.model_copy(update={"number": number})
        self._mailbox.report(Performative.INFORM, self._announced, now_s)

    def _send_reports(self, now_s: float) -> None:
        reports = [*self._reports, *(report for run in self._runs for report in run.take_reports())]
        self._reports = []
        for report in reports:
            ended_badly = isinstance(report, ScriptReport) and report.state is not ScriptState.FINISHED
            self._mailbox.report(Performative.FAILURE if ended_badly else Performative.INFORM, report, now_s)
        for upkeep in self._upkeep:
            self._mailbox.report(Performative.INFORM, upkeep, now_s)
        self._upkeep = []
        if self._faults is not None:
            self._mailbox.report(Performative.INFORM, self._faults, now_s)
            self._faults = None
        if any(run.has_ended for run in self._runs):
            self._runs = [run for run in self._runs if not run.has_ended]
            self._changed = True

    def _send_telemetry(self, now_s: float) -> None:
        if now_s - self._telemetry_s < TELEMETRY_S - 1e-6 or (known := self._driver.telemetry()) is None:
            return
        self._telemetry_s = now_s
        run = self._current if self.script_id is not None else None
        packet = run.packet if run else None
        body = known.model_copy(
            update={
                "at_s": now_s,
                "script_id": self.script_id,
                "script_state": run.state if run else None,
                "packet_id": packet.id if packet else None,
                "packet_tag": packet.tag if packet else None,
                "packet_state": run.packet_state if run else None,
            }
        )
        if is_due(body, self._sent_telemetry):
            self._sent_telemetry = body
            self._mailbox.post(body, now_s)
