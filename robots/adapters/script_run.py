"""One script on a robot that is driven packet by packet.

What happens is first noted here and saved, and only then told to the driver (`command`): whatever the power's failure
interrupts, the memory says at least what the robot may have been told to do.
"""

from collections.abc import Iterable, Sequence

from robots.adapters.driver import HoldingDriver, PacketDriver, Progress, ProgressState, SensingDriver
from robots.adapters.memory import RunMemory, Stop
from robots.contract.known_scripts import ENDED, ScriptStates
from robots.wire import (
    BehaviourPacket,
    BehaviourScript,
    ControlVerb,
    FailureCategory,
    PacketReport,
    PacketResult,
    PacketState,
    ScriptReport,
    ScriptState,
    SymbolicFact,
)

Report = PacketReport | ScriptReport
STOP_S = 60.0
"""A robot that does not tell within this time that it stands has failed (world's clock, our choice)."""


class ScriptRun:
    """The state machine of one script. Only the first of a robot's scripts is advanced."""

    def __init__(self, memory: RunMemory, driver: PacketDriver, states: ScriptStates) -> None:
        """:param states: those of the robot's scripts, of which this one's is changed here alone."""
        self._memory = memory
        self._driver = driver
        self._states = states
        self._reports: list[Report] = []
        self._perceived: tuple[SymbolicFact, ...] = ()
        self._missing: list[str] = []
        self._was_begun = memory.begun
        self._stopping_s = 0.0
        self._attached = False
        self._told_paused = False
        self._told_cancel = False
        self._objection: str | None = None

    @property
    def script(self) -> BehaviourScript:
        return self._memory.script

    @property
    def state(self) -> ScriptState | None:
        return self._states.of(self.script.id)

    @property
    def has_ended(self) -> bool:
        if self._memory.silent:
            return not self._memory.begun
        return self.state in ENDED

    @property
    def is_silent(self) -> bool:
        return self._memory.silent

    @property
    def is_stopping(self) -> bool:
        """True while the robot is to end its packet and does not stand yet."""
        return self._memory.stop is not None

    @property
    def packet(self) -> BehaviourPacket | None:
        """The current packet; None once the script has ended."""
        return None if self.has_ended else self.script.packets[self._memory.index]

    @property
    def packet_state(self) -> PacketState | None:
        if self.has_ended:
            return None
        return self._shown(self._memory.state)

    @property
    def order(self) -> int:
        """The number of the newest order that was followed."""
        return self._memory.order

    @property
    def perceived(self) -> tuple[SymbolicFact, ...]:
        """The facts that the driver last told."""
        return self._perceived

    @property
    def waits_for(self) -> str:
        """What the current packet waits for, in words; empty once it runs."""
        return "; ".join(self._missing)

    def memory(self) -> RunMemory:
        return self._memory.saved()

    def take_reports(self) -> Sequence[Report]:
        """The reports made since they were last taken, oldest first."""
        reports, self._reports = self._reports, []
        return () if self._memory.silent else reports

    def clear(self, ended: Iterable[str]) -> None:
        """Note that these actions have ended, which packets may wait for, now or later."""
        self._memory.ended |= frozenset(ended)

    def control(self, verb: ControlVerb, number: int, now_s: float) -> str | None:
        """Follow an order, or return the reason against it."""
        memory = self._memory
        if verb is not ControlVerb.CANCEL:
            if number < memory.order:
                return (
                    f"order {number} to {verb} script {self.script.id} was overtaken by order {memory.order}"
                )
            if memory.stop is not None and memory.stop.ends is ScriptState.CANCELLED:
                return f"script {self.script.id} is being cancelled"
        memory.order = max(number, memory.order)
        if verb is ControlVerb.CANCEL:
            self.cancel("cancelled on request", now_s)
        else:
            self._set_paused(verb is ControlVerb.PAUSE, now_s)
        return None

    def cancel(self, reason: str, now_s: float) -> None:
        """End the script once the robot stands; at once if it has not begun a packet."""
        stop = Stop(ends=ScriptState.CANCELLED, category=FailureCategory.CANCELLED, detail=reason)
        if self._memory.begun:
            self._memory.stop = stop
        else:
            self._end(stop, now_s)

    def silence(self) -> None:
        """End the script without any report: its run of the world is over."""
        self._memory.silent = True
        if self._memory.begun:
            self._memory.stop = Stop(
                ends=ScriptState.CANCELLED, category=FailureCategory.CANCELLED, detail="the run is over"
            )

    def advance(self, step_s: float, now_s: float) -> bool:
        """Note what has happened since the last tick. True if that must be saved."""
        if self.has_ended:
            return False
        if self._memory.begun:
            return self._follow(step_s, now_s)
        return not self._memory.paused and self._wait(step_s, now_s)

    def command(self, *, may_start: bool) -> None:
        """Tell the driver what it has not been told yet.

        :param may_start: the memory is saved.
        """
        memory = self._memory
        if not memory.begun or self.has_ended:
            return
        if not self._attached:
            if not may_start:
                return
            self._attached = True
            self._objection = self._driver.start(self._given)
        if self._objection is not None:
            return
        if memory.paused is not self._told_paused:
            self._told_paused = memory.paused
            (self._driver.pause if memory.paused else self._driver.resume)()
        if memory.stop is not None and not self._told_cancel:
            self._told_cancel = True
            self._driver.cancel()

    @property
    def _packet(self) -> BehaviourPacket:
        return self.script.packets[self._memory.index]

    @property
    def _given(self) -> BehaviourPacket:
        """The packet as the driver gets it."""
        return self._packet.model_copy(update={"id": f"{self.script.id}/{self._packet.id}"})

    def _wait(self, step_s: float, now_s: float) -> bool:
        memory = self._memory
        if memory.state is PacketState.WAITING:
            memory.state = PacketState.INITIALIZING
            self._note(ScriptState.RUNNING)
            self._missing = self._unmet()
            self._report(PacketState.INITIALIZING, now_s, detail=self.waits_for)
            return True
        self._missing = self._unmet()
        if not self._missing:
            memory.begun = True
            memory.state = PacketState.RUNNING
            self._was_begun = False
            return True
        if memory.index > 0 and isinstance(self._driver, HoldingDriver):
            held = self._driver.hold(step_s)
            if held.state is ProgressState.FAILED:
                self._perceived = held.perceived or ()
                self._fail(held.category, held.detail, held.events, now_s)
                return True
        memory.waited_s += step_s
        limit_s = self._packet.wait_timeout_s
        if memory.waited_s <= limit_s:
            return False
        category = FailureCategory.DEADLINE if self._uncleared() else FailureCategory.WORLD_CHANGED
        self._fail(category, f"could not start within {limit_s:.0f} s: the robot {self.waits_for}", (), now_s)
        return True

    def _unmet(self) -> list[str]:
        uncleared = self._uncleared()
        words = [f"waits for clearance: {', '.join(uncleared)}"] if uncleared else []
        if isinstance(self._driver, SensingDriver):
            words += [f"does not sense {one}" for one in self._packet.awaits if not self._driver.holds(one)]
        return words

    def _uncleared(self) -> list[str]:
        return [action for action in self._packet.after if action not in self._memory.ended]

    def _follow(self, step_s: float, now_s: float) -> bool:
        """Follow the packet that was begun."""
        memory = self._memory
        if not self._attached:
            return self._drop_unbegun(now_s)
        if self._objection is not None:
            progress = Progress(state=ProgressState.FAILED, detail=self._objection)
        else:
            progress = self._driver.poll()
        if memory.paused and memory.stop is None:
            return False  # its end is told again once the robot goes on
        if progress.perceived is not None:
            self._perceived = progress.perceived
        has_told = self._tell_running(progress, now_s)
        if progress.state is ProgressState.RUNNING:
            return self._run_on(step_s, now_s) or has_told
        if progress.state is ProgressState.FINISHED:
            self._finish(progress, now_s)
        elif memory.stop is None:
            self._fail(
                progress.category, progress.detail or "failed without a reason", progress.events, now_s
            )
        elif memory.stop.ends is ScriptState.FAILED:
            self._fail(memory.stop.category, memory.stop.detail, progress.events, now_s)
        else:
            self._end(memory.stop, now_s)
        return True

    def _drop_unbegun(self, now_s: float) -> bool:
        """A packet that is to be cancelled and was never given to the driver need not be."""
        stop = self._memory.stop
        if stop is None or self._was_begun:
            return False
        self._end(stop, now_s)
        return True

    def _tell_running(self, progress: Progress, now_s: float) -> bool:
        """Report that the packet runs, once, and its events. True if there was something to report."""
        is_first = not self._memory.told_running and self._objection is None
        is_running = progress.state is ProgressState.RUNNING
        if not is_first and not (is_running and progress.events):
            return False
        self._memory.told_running = True
        detail = progress.detail if is_running else ""
        events = progress.events if is_running else ()
        self._report(self._shown(PacketState.RUNNING), now_s, detail=detail, events=events)
        return True

    def _run_on(self, step_s: float, now_s: float) -> bool:
        memory = self._memory
        memory.ran_s += step_s
        if memory.stop is not None:
            self._stopping_s += step_s
            if self._stopping_s > STOP_S:
                reason = f"did not stop within {STOP_S:.0f} s, the robot may still move: {memory.stop.detail}"
                self._fail(FailureCategory.ROBOT, reason, (), now_s)
                return True
        elif memory.ran_s > self._packet.timeout_s:
            memory.stop = Stop(
                ends=ScriptState.FAILED,
                category=FailureCategory.DEADLINE,
                detail=f"did not end within {self._packet.timeout_s:.0f} s",
            )
            return True
        return False

    def _finish(self, progress: Progress, now_s: float) -> None:
        memory = self._memory
        memory.state = PacketState.FINISHED
        if progress.perceived is None:
            self._perceived = self._packet.achieves
        self._report(
            PacketState.FINISHED,
            now_s,
            detail=progress.detail,
            events=progress.events,
            results=progress.results,
        )
        stop = memory.stop
        if stop is not None and stop.ends is ScriptState.CANCELLED:
            self._end(stop, now_s)
        elif memory.index == len(self.script.packets) - 1:
            self._note(ScriptState.RUNNING)  # it may be paused
            self._note(ScriptState.FINISHED)
            self._end_reported(ScriptState.FINISHED, None, "", now_s)
        else:
            self._leave_packet()
            memory.index += 1

    def _fail(self, category: FailureCategory, reason: str, events: tuple[str, ...], now_s: float) -> None:
        self._memory.state = PacketState.FAILED
        detail = f"{self._packet.tag} {reason}"
        self._report(PacketState.FAILED, now_s, detail=detail, events=events)
        self._note(ScriptState.FAILED)
        self._end_reported(ScriptState.FAILED, category, detail, now_s)

    def _end(self, stop: Stop, now_s: float) -> None:
        self._note(stop.ends)
        self._end_reported(stop.ends, stop.category, stop.detail, now_s)

    def _end_reported(
        self, state: ScriptState, category: FailureCategory | None, detail: str, now_s: float
    ) -> None:
        self._reports.append(
            ScriptReport(
                script_id=self.script.id,
                state=state,
                at_s=now_s,
                packet_id=self._packet.id,
                category=category,
                perceived=self._perceived,
                detail=detail,
            )
        )
        self._leave_packet()

    def _leave_packet(self) -> None:
        memory = self._memory
        memory.state = PacketState.WAITING
        memory.begun = False
        memory.waited_s = 0.0
        memory.ran_s = 0.0
        memory.told_running = False
        memory.stop = None
        self._missing = []
        self._perceived = ()
        self._stopping_s = 0.0
        self._attached = False
        self._told_paused = False
        self._told_cancel = False
        self._objection = None

    def _set_paused(self, paused: bool, now_s: float) -> None:
        if self._memory.paused is paused:
            return
        self._memory.paused = paused
        self._note(ScriptState.PAUSED if paused else ScriptState.RUNNING)
        self._report(self._shown(self._memory.state), now_s)

    def _shown(self, state: PacketState) -> PacketState:
        return PacketState.PAUSED if self._memory.paused else state

    def _note(self, state: ScriptState) -> None:
        if not self._memory.silent and self.state is not state:
            self._states.note(self.script.id, state)

    def _report(
        self,
        state: PacketState,
        now_s: float,
        *,
        detail: str = "",
        events: tuple[str, ...] = (),
        results: tuple[PacketResult, ...] = (),
    ) -> None:
        self._reports.append(
            PacketReport(
                script_id=self.script.id,
                packet_id=self._packet.id,
                state=state,
                at_s=now_s,
                perceived=self._perceived,
                events=events,
                detail=detail,
                results=results,
            )
        )
