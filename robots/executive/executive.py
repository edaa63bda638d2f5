"""The executive: runs one behaviour script, packet after packet, without needing the link (MACTA §3, fig. 3)."""

from collections import deque
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from robots.conditions.facts import perceived
from robots.contract.known_scripts import ENDED, ScriptStates
from robots.errors import RepertoireError
from robots.executive.delegation import DelegatedLeg, is_awarded, packets_of, to_delegate
from robots.executive.memory import (
    DelegatedMemory,
    ExecutiveMemory,
    NewsMemory,
    OwnMemory,
    ScriptMemory,
    SteeringMemory,
)
from robots.executive.own_packets import AT_MOST_S, OwnPackets, why_held, why_not_now
from robots.executive.packet_run import Change, Outcome, PacketRun
from robots.executive.reports import Report, cancelled_before_arrival_report, packet_report, script_report
from robots.executive.sensing_plan import BehaviourState, StateMachine, schedule
from robots.executive.society import Clearing
from robots.executive.trace import Instant, Trace
from robots.perception.percepts import GRIP, NOTHING, Percepts
from robots.physical.profile import RobotProfile
from robots.reactive.patterns import Responses
from robots.reactive.stall import for_rules
from robots.reactive.synthesis import Motion
from robots.repertoire import Repertoire, load_self_level
from robots.wire import (
    BehaviourPacket,
    BehaviourScript,
    ControlVerb,
    FailureCategory,
    PacketState,
    ScriptState,
    StatusReport,
    UpkeepReport,
)

BEGUN_AGAIN_AT_MOST = 3
"""How often the deliberative level may begin one packet again (our choice)."""
NEWS = 64
LASTED = 16
"""Packets of a kind of which the duration is kept (our choice)."""
DELEGATED = "the leg is put to other robots"


class News(NamedTuple):
    """A new state of a packet, or events that it has raised; without a tag, a script's end."""

    tag: str
    state: PacketState | ScriptState
    events: tuple[str, ...]


class Executive:
    """Runs at most one script at a time and keeps the final states of earlier ones."""

    def __init__(self, profile: RobotProfile, repertoire: Repertoire) -> None:
        self._profile = profile
        self._repertoire = repertoire
        self._critical = load_self_level().critical
        self._script: BehaviourScript | None = None
        self._runs: list[PacketRun] = []
        self._index = 0
        self._newest_order = 0
        self._machine: StateMachine = {}
        self._states = ScriptStates()
        self._state: ScriptState | None = None
        """The current script's, or the last one's."""
        self._reports: list[Report] = []
        self._own: OwnPackets | None = None
        """Packets of the robot's own that run in place of the current packet."""
        self._suspended_s: float | None = None
        """How long the current packet stays suspended at most; None if it is not."""
        self._begun_again: dict[str, int] = {}
        """How often packets of the script were begun again, by their ids."""
        self._delegated: DelegatedMemory | None = None
        """The leg of the current packet, which has failed, while it is put to other robots."""
        self.delegates = False
        """Whether the robot puts legs to others that it may."""
        self.news: deque[News] = deque(maxlen=NEWS)
        """What has become of packets and scripts, oldest first; for the deliberative level, which takes them."""
        self.left_to_rules = frozenset[str]()
        """Events of the service's packets on which rules act in place of the packets' own retries and limits."""
        self.end_reason = ""
        """Why the last script ended, in words; empty if it finished."""
        self.own_reason = ""
        """Likewise the last own packets between a script's."""
        self._lasted: dict[str, deque[float]] = {}
        """How long packets have acted that have finished, by their tags."""
        self.responses = Responses()
        self.trace = Trace()

    @property
    def script_id(self) -> str | None:
        """The current script, or the last one."""
        return self._script.id if self._script else None

    @property
    def script(self) -> BehaviourScript | None:
        """The current script; None if none is active."""
        return self._script if self.active else None

    def packet(self, script_id: str, packet_id: str) -> BehaviourPacket | None:
        """A packet of the current script, or the last one; None if it is of another."""
        if self._script is None or script_id != self._script.id:
            return None
        return next((one for one in self._script.packets if one.id == packet_id), None)

    @property
    def state(self) -> ScriptState | None:
        return self._state

    @property
    def _active_script(self) -> BehaviourScript:
        assert self._script is not None
        return self._script

    @property
    def active(self) -> bool:
        return self._state is not None and self._state not in ENDED

    @property
    def current(self) -> PacketRun | None:
        """The current packet."""
        return self._runs[self._index] if self.active else None

    @property
    def behaviour(self) -> BehaviourState | None:
        """The current state of the script's state machine; None if no packet runs."""
        run = self.current
        if run is None or self.state is ScriptState.PAUSED or self._suspended_s is not None:
            return None
        if self._own is not None:
            return self._own.behaviour
        if self._delegated is not None:
            return None
        return self._machine[run.packet.id, run.phase]

    @property
    def wanted(self) -> tuple[str, ...]:
        """What the current packet of the script names but its relations, to be looked for; nothing without one."""
        run = self.current
        given = {} if run is None else run.packet.arguments
        return tuple(dict.fromkeys(value for name, value in given.items() if not name.startswith("rel")))

    @property
    def left_s(self) -> float:
        """Seconds until the current script should end, by its schedule from the current packet on; 0 without one.

        A packet that is late leaves at least the expected durations of those after it.
        """
        if (run := self.current) is None:
            return 0.0
        first, *later = self._active_script.packets[self._index :]
        ends_s = max(one.expected_start_s + one.expected_duration_s for one in (first, *later))
        planned_s = ends_s - first.expected_start_s - run.elapsed_s
        return max(planned_s, sum(one.expected_duration_s for one in later))

    def lasted_s(self, tag: str) -> float | None:
        """How long the last packets of this kind that have finished have acted, in the mean; None before the first."""
        lasted = self._lasted.get(tag)
        return sum(lasted) / len(lasted) if lasted else None

    def state_of(self, script_id: str) -> ScriptState | None:
        """The state of one of the last scripts, or of own packets between a script's; None for one not known."""
        return self._states.of(script_id)

    def why_ended(self, script_id: str) -> str:
        """Why a script has ended, in words; empty if it has finished, or another has ended since."""
        if self._script is None or self._script.id == script_id:
            return self.end_reason
        is_cancelled = self._states.of(script_id) is ScriptState.CANCELLED
        return f"the robot took up script {self._script.id}" if is_cancelled else ""

    def accept(self, script: BehaviourScript) -> str | None:
        """Accept a script, or return the reason against it. The robot's own script is cancelled for it."""
        if script.robot != self._profile.name:
            return f"script {script.id} is for {script.robot}, this is {self._profile.name}"
        if self.script is not None and (not self.script.is_own or is_awarded(self.script)):
            return f"{self._profile.name} is busy with script {self.script.id}"
        if (unable := self.why_unable(script)) is not None:
            return unable
        runs, machine = self._prepare(script)
        if self.script is not None:
            self._note(ScriptState.CANCELLED)
        self._script = script
        self._runs = runs
        self._index = 0
        self._machine = machine
        self._newest_order = 0
        self._suspended_s = None
        self._begun_again = {}
        self._delegated = None
        self._note(ScriptState.ACCEPTED)
        return None

    def begin_own(self, own: BehaviourScript, percepts: Percepts | None, now_s: float) -> str | None:
        """Run a script of the robot's own while there is no other; or report, and return, the reason against it."""
        reason = self.accept(own)
        if reason is not None:
            tag = own.packets[0].tag
            failed = UpkeepReport(tag=tag, state=PacketState.FAILED, at_s=now_s, detail=reason)
            self._reports.append(failed)
        return reason

    def why_unable(self, script: BehaviourScript) -> str | None:
        """Why the robot could not carry out a script, idle as it might be; None if it could."""
        try:
            _, machine = self._prepare(script)
        except RepertoireError as error:
            return str(error)
        needed = NOTHING.union(*(state.needs for state in machine.values()))
        if missing := needed - self._profile.sensors:
            return f"{self._profile.name} has no {', '.join(sorted(missing))}, which script {script.id} needs"
        return None

    def interpose(
        self, own: BehaviourScript, percepts: Percepts | None, now_s: float, *, may_carry: bool, because: str
    ) -> str | None:
        """Run own packets in place of the current packet, which then goes on; or return the reason against it.

        :param may_carry: also while the robot holds something. :param because: for the report.
        """
        run = self.current
        if run is None or self._active_script.is_own:
            return f"{self._profile.name} has no script to interrupt"
        if self.state is ScriptState.PAUSED or self._suspended_s is not None or self._own is not None:
            return f"script {self.script_id} is interrupted already"
        reason = DELEGATED if self._delegated is not None else None
        reason = reason or why_not_now(run, self._profile, percepts, may_carry=may_carry)
        if reason is not None:
            return reason
        if (reason := self._begin_own(own)) is not None:
            return reason
        self._remark(run, f"stands for {own.packets[0].tag} of {because}", percepts, now_s)
        return None

    def withdraw_own(self, script_id: str, percepts: Percepts | None, now_s: float) -> None:
        """End own packets; the script's packet goes on."""
        if self._own is not None and self._own.script.id == script_id:
            self._end_own(ScriptState.CANCELLED, "withdrawn", percepts, now_s)
        elif self.script is not None and self.script.is_own and self.script_id == script_id:
            self._end(ScriptState.CANCELLED, percepts, now_s, FailureCategory.CANCELLED, "withdrawn")

    def suspend(self, reason: str, percepts: Percepts | None, now_s: float) -> str | None:
        """Let the robot stand until `resume_suspended`, or return the reason against it."""
        run = self._steerable()
        if isinstance(run, str):
            return run
        if self._suspended_s is None:
            self._suspended_s = AT_MOST_S
            self._remark(run, f"is suspended: {reason}", percepts, now_s)
        return None

    def resume_suspended(self, percepts: Percepts | None, now_s: float) -> str | None:
        """Go on with a suspended packet, or return the reason against it."""
        run = self.current
        if run is None or self._suspended_s is None:
            return "no packet is suspended"
        self._suspended_s = None
        self._remark(run, "goes on", percepts, now_s)
        return None

    def begin_again(self, reason: str, percepts: Percepts | None, now_s: float) -> str | None:
        """Begin the current packet again, or return the reason against it."""
        run = self._steerable()
        if isinstance(run, str):
            return run
        if self._own is not None:
            return f"script {self.script_id} is interrupted already"
        count = self._begun_again.get(run.packet.id, 0)
        if count >= BEGUN_AGAIN_AT_MOST:
            return f"{run.packet.tag} was begun again {count} times"
        self._begun_again[run.packet.id] = count + 1
        self._suspended_s = None
        self._remark(run, f"begins again: {reason}", percepts, now_s)
        self._runs[self._index] = run.rebound(run.content)
        return None

    def give_up(self, reason: str, percepts: Percepts | None, now_s: float) -> str | None:
        """Fail the current packet and its script, or return the reason against it."""
        run = self._steerable()
        if isinstance(run, str):
            return run
        category = FailureCategory.WORLD_CHANGED if run.is_missing_something else FailureCategory.ROBOT
        self._apply(run, run.fail(category, f"was given up: {reason}", percepts), percepts, now_s)
        return None

    def _steerable(self) -> PacketRun | str:
        """The current packet, if rules may act on it: of a script of the service; or the reason why they may not."""
        run = self.current
        if run is None:
            return "no packet is under way"
        if self._active_script.is_own:
            return f"{run.packet.tag} is of no script of the service"
        if self.state is ScriptState.PAUSED:
            return f"script {self.script_id} is paused"
        if self._delegated is not None:
            return DELEGATED
        return f"{run.packet.tag} moves the jaws" if run.grips else run

    @property
    def unsafe(self) -> str:
        """Why what is under way could not go on in another body, in words; empty if it could."""
        run = self.current
        if run is not None and run.grips:
            return f"{run.packet.tag} moves the jaws"
        if self._own is not None:
            return f"{self._own.current.packet.tag} of its own runs between packets of its script"
        return ""

    def go_on(self) -> None:
        """Go on after a rest: what happened meanwhile is not the current packet's way."""
        if (run := self.current) is not None:
            run.resume_after_own()

    @property
    def delegated(self) -> DelegatedLeg | None:
        """The leg that is put to other robots now; None if there is none."""
        kept = self._delegated
        if kept is None or not self.active:
            return None
        script = self._active_script
        leg = next(one for one in script.delegable if one.id == kept.leg)
        return DelegatedLeg(script_id=script.id, leg=leg, packets=packets_of(script, leg), why=kept.detail)

    def make_way(self, own: BehaviourScript) -> str | None:
        """Run own packets while a leg is put to others, or return the reason against it."""
        if self._delegated is None or self._own is not None:
            return "no leg is put to others"
        return self._begin_own(own)

    def _begin_own(self, own: BehaviourScript) -> str | None:
        """Begin own packets between those of the script, or return the reason against it."""
        try:
            packets = OwnPackets(own, *self._prepare(own))
        except RepertoireError as error:
            return str(error)
        if (reason := packets.why_not_between(self._profile, self._active_script)) is not None:
            return reason
        self._own = packets
        self.own_reason = ""
        self._states.note(own.id, ScriptState.ACCEPTED)
        self._states.note(own.id, ScriptState.RUNNING)
        return None

    def end_delegated(self, robot: str, percepts: Percepts | None, now_s: float) -> None:
        """Another robot has done the leg: go on after it."""
        kept = self.delegated
        self._delegated = None
        if kept is None:
            return
        self._note(ScriptState.RUNNING)  # also if its first packet was given up before it had begun
        ids = [run.packet.id for run in self._runs]
        for run in self._runs:
            if run.packet.id in kept.leg.packets and run.state is not PacketState.FINISHED:
                run.end_by(robot)
        last = ids.index(kept.packets[-1].id)
        if last == len(ids) - 1:
            self._index = last
            self._end(ScriptState.FINISHED, percepts, now_s)
        else:
            self._index = last + 1

    def take_back(self, reason: str, percepts: Percepts | None, now_s: float) -> None:
        """No other robot does the leg: the packet and the script have failed."""
        kept = self._delegated
        run = self.current
        self._delegated = None
        if kept is None or run is None:
            return
        detail = f"{kept.detail}; {reason}"
        script = self._active_script
        self._reports.extend(packet_report(script, run, PacketState.FAILED, percepts, now_s, detail))
        self._tell(run, Change(state=PacketState.FAILED))
        self._end(ScriptState.FAILED, percepts, now_s, kept.category, detail)

    def moves_jaws(self, packet: BehaviourPacket) -> bool:
        """True if a packet takes something or puts it down; also if it is not in the repertoire."""
        try:
            content = self._repertoire.bind(packet, self._profile)
        except RepertoireError:
            return True
        return PacketRun(packet, content, self._profile).moves_jaws

    def packets_ended(self, script_id: str) -> int | None:
        """How many packets of the current script, or the last one, have finished; None if that is not known."""
        if self.script_id != script_id or not self._runs:
            return None
        return sum(run.state is PacketState.FINISHED for run in self._runs)

    def _prepare(self, script: BehaviourScript) -> tuple[list[PacketRun], StateMachine]:
        """The runs of a script's packets, and its state machine.

        :raises RepertoireError: if a packet does not fit the repertoire.
        """
        profile = self._profile
        runs = [PacketRun(p, self._repertoire.bind(p, profile), profile) for p in script.packets]
        return runs, schedule(script, [run.content for run in runs])

    def memory(self) -> ExecutiveMemory:
        if self._script is None:
            return ExecutiveMemory()
        script = ScriptMemory(
            script=self._script,
            index=self._index,
            packets=tuple(run.memory() for run in self._runs),
            order=self._newest_order,
            delegated=self._delegated,
        )
        return ExecutiveMemory(script=script, states=self._states.memory())

    def hand_over(self) -> ExecutiveMemory:
        """The memory with what rules have made of the script, for another program."""
        steering = SteeringMemory(
            suspended_s=self._suspended_s,
            begun_again=dict(self._begun_again),
            lasted_s={tag: tuple(lasted) for tag, lasted in self._lasted.items()},
            end_reason=self.end_reason,
            own_reason=self.own_reason,
            own=None if self._own is None else self._own.memory(),
            news=tuple(NewsMemory(tag=one.tag, state=one.state, events=one.events) for one in self.news),
        )
        return self.memory().model_copy(update={"steering": steering})

    def recall(self, memory: ExecutiveMemory, now_s: float) -> None:
        """Restore the current packet. A script that no longer fits the repertoire has failed."""
        self._states.recall(memory.states)
        if (steering := memory.steering) is not None:
            self._suspended_s = steering.suspended_s
            self._begun_again = dict(steering.begun_again)
            for tag, lasted_s in steering.lasted_s.items():
                self._lasted[tag] = deque(lasted_s, maxlen=LASTED)
            self.end_reason = steering.end_reason
            self.own_reason = steering.own_reason
            self.news.extend(News(one.tag, one.state, one.events) for one in steering.news)
        if memory.script is None:
            return
        self._script = memory.script.script
        self._state = self._states.of(self._script.id)
        self._index = memory.script.index
        self._newest_order = memory.script.order
        self._delegated = memory.script.delegated
        if not self.active:
            return
        try:
            self._runs, self._machine = self._prepare(self._script)
        except RepertoireError as error:
            reason = f"cannot go on after a restart: {error}"
            self._end(ScriptState.FAILED, None, now_s, FailureCategory.ROBOT, reason)
            return
        for run, packet in zip(self._runs, memory.script.packets, strict=True):
            run.recall(packet)
        if memory.steering is not None and (own := memory.steering.own) is not None:
            self._recall_own(own)

    def _recall_own(self, memory: OwnMemory) -> None:
        """Go on with own packets between the script's; those that no longer fit the repertoire are cancelled."""
        try:
            own = OwnPackets(memory.script, *self._prepare(memory.script))
        except RepertoireError:
            self._states.note(memory.script.id, ScriptState.CANCELLED)
            return
        own.recall(memory)
        self._own = own

    def retune(self, repertoire: Repertoire) -> None:
        """Use this repertoire from the next packet on.

        :raises RepertoireError: if a later packet does not fit it; then nothing changes.
        """
        first = self._index + 1
        later = [run.rebound(repertoire.bind(run.packet, self._profile)) for run in self._runs[first:]]
        self._repertoire = repertoire
        self._runs[first:] = later

    def control(
        self,
        script_id: str,
        verb: ControlVerb,
        percepts: Percepts | None,
        now_s: float,
        reason: str = "cancelled on request",
        *,
        number: int = 0,
    ) -> str | None:
        """Cancel, pause or resume the current script, or return the reason against it. The gripper is not moved.

        :param number: the order's number. A pause or resume with a lower number than the newest order is refused; a
            cancel never is.
        """
        if (objection := self._not_current(script_id)) is not None:
            return objection
        if verb is not ControlVerb.CANCEL and number < self._newest_order:
            return f"order {number} to {verb.value} script {script_id} was overtaken by order {self._newest_order}"
        self._newest_order = max(number, self._newest_order)
        if verb is ControlVerb.CANCEL:
            self._end(ScriptState.CANCELLED, percepts, now_s, FailureCategory.CANCELLED, reason)
        elif verb is ControlVerb.PAUSE and self.state is not ScriptState.PAUSED:
            self._set_paused(ScriptState.PAUSED, percepts, now_s)
        elif verb is ControlVerb.RESUME and self.state is ScriptState.PAUSED:
            self._set_paused(ScriptState.RUNNING, percepts, now_s)
        return None

    def cancel_before_arrival(self, script_id: str, percepts: Percepts | None, now_s: float) -> bool:
        """Report a script that has not arrived as cancelled; False if it has arrived."""
        if script_id in self._states:
            return False
        self._states.note(script_id, ScriptState.CANCELLED)
        self._reports.append(cancelled_before_arrival_report(script_id, percepts, now_s))
        return True

    def clear(self, script_id: str, ended: Iterable[str]) -> str | None:
        """Note that actions have ended that packets of the current script wait for, or return the reason against it."""
        if (objection := self._not_current(script_id)) is not None:
            return objection
        for run in self._runs:
            run.clear(ended)
        return None

    def clear_by(self, script_id: str, action: str, robot: str) -> Clearing:
        """Note that another robot says to have ended its part of an action; it is believed if the script names it."""
        if not self.active or script_id != self.script_id:
            return Clearing.SCRIPT_ENDED if script_id in self._states else Clearing.UNKNOWN_SCRIPT
        taken = [run.clear_by(action, robot) for run in self._runs]
        return Clearing.NOTED if any(taken) else Clearing.NOT_NAMED

    def step(self, percepts: Percepts, step_s: float) -> Motion:
        """Advance the script by one tick. No motion without a running script, nor before its sensors have read."""
        self.responses = Responses()
        self._stop_on_low_battery(percepts)
        if self._suspended_s is not None and self.active and self.state is not ScriptState.PAUSED:
            self._suspended_s -= step_s
            if self._suspended_s <= 0:
                self.resume_suspended(percepts, percepts.time_s)
            return Motion()
        if self._own is not None and self.state is not ScriptState.PAUSED:
            return self._step_own(self._own, percepts, step_s)
        run = self.current
        behaviour = self.behaviour
        if run is None or behaviour is None or not percepts.data.holds(behaviour.needs):
            return Motion()
        self._note(ScriptState.RUNNING)
        outcome = run.step(percepts, step_s, left_to_rules=self._left_to_rules(run, percepts))
        self.responses = outcome.responses
        self.trace.record(Instant(percepts.time_s, run.packet.id, outcome.responses, outcome.motion))
        self._apply(run, outcome, percepts)
        return outcome.motion

    def _left_to_rules(self, run: PacketRun, percepts: Percepts) -> frozenset[str]:
        if not self.left_to_rules or self._active_script.is_own:
            return frozenset()
        return (
            self.left_to_rules if why_held(self._profile, percepts, may_carry=True) is None else frozenset()
        )

    def _step_own(self, own: OwnPackets, percepts: Percepts, step_s: float) -> Motion:
        """One tick of own packets; the script's packet goes on when they have ended."""
        run = own.current
        outcome, ended = own.step(percepts, step_s)
        self.responses = outcome.responses
        self.trace.record(Instant(percepts.time_s, run.packet.id, outcome.responses, outcome.motion))
        if outcome.change is not None:
            self._tell(run, outcome.change)
        if ended is not None:
            detail = outcome.change.detail if outcome.change else ""
            self._end_own(ended, detail, percepts, percepts.time_s)
            return Motion()
        return outcome.motion

    def _end_own(self, state: ScriptState, detail: str, percepts: Percepts | None, now_s: float) -> None:
        own = self._own
        run = self.current
        self._own = None
        if own is None:
            return
        self._states.note(own.script.id, state)
        self.own_reason = detail
        if run is not None:
            run.resume_after_own()
        if run is not None and self._delegated is None:
            words = f": {detail}" if detail else ""
            self._remark(run, f"goes on, {own.current.packet.tag} has {state.value}{words}", percepts, now_s)

    def _remark(self, run: PacketRun, words: str, percepts: Percepts | None, now_s: float) -> None:
        """Report something about a packet that does not change its state."""
        detail = f"{run.packet.tag} {words}"
        state = run.state if self._delegated is None else PacketState.RETRIABLE
        self._reports.extend(packet_report(self._active_script, run, state, percepts, now_s, detail))

    def _tell(self, run: PacketRun, change: Change) -> None:
        if change.state is PacketState.FINISHED:
            self._lasted.setdefault(run.packet.tag, deque(maxlen=LASTED)).append(run.elapsed_s)
        events = for_rules(change.events, self.left_to_rules)
        self.news.append(News(run.packet.tag, change.state, events))

    def _stop_on_low_battery(self, percepts: Percepts) -> None:
        """Fail the script at a critical battery level, but not while the jaws move or hold a long object."""
        run = self.current
        if run is None or self._delegated is not None or run.grips or percepts.battery >= self._critical:
            return
        script = self._active_script
        if script.is_own and not script.is_for_person and not is_awarded(script):
            return
        if percepts.data.holds(GRIP) and percepts.holding in self._profile.lengths_m:
            return
        reason = f"broke off: battery at {percepts.battery:.0%}"
        self._apply(run, run.fail(FailureCategory.ROBOT, reason, None), percepts)

    def fault(self, reason: str, last: Percepts | None, now_s: float) -> None:
        """Fail the script because of a sensor fault. `last`: the percepts before the fault."""
        run = self.current
        if run is not None and self._delegated is None:
            self._apply(run, run.fault(reason, last), None, now_s)

    def status(self, script_id: str, percepts: Percepts | None, now_s: float) -> StatusReport:
        """The state of a script; None for one that is not known."""
        run = self.current if script_id == self.script_id else None
        return StatusReport(
            script_id=script_id,
            state=self._states.of(script_id),
            at_s=now_s,
            packet_id=run.packet.id if run else None,
            packet_state=self.packet_state if run else None,
            perceived=perceived(percepts),
            detail=run.waits_for if run else "",
            order=self._newest_order if run else 0,
        )

    @property
    def packet_state(self) -> PacketState | None:
        if (run := self.current) is None:
            return None
        if self._delegated is not None and self.state is not ScriptState.PAUSED:
            return PacketState.RETRIABLE
        return PacketState.PAUSED if self.state is ScriptState.PAUSED else run.state

    def take_reports(self) -> Sequence[Report]:
        """The reports made since they were last taken, oldest first."""
        reports = self._reports
        self._reports = []
        return reports

    def _not_current(self, script_id: str) -> str | None:
        """The reason against an order on a script that is not current; None if it is."""
        if self.active and script_id == self.script_id:
            return None
        return self._states.why_not_active(script_id)

    def _apply(self, run: PacketRun, outcome: Outcome, percepts: Percepts | None, now_s: float = 0.0) -> None:
        if (change := outcome.change) is None:
            return
        at_s = percepts.time_s if percepts else now_s
        script = self._active_script
        if change.state is PacketState.FAILED and self._delegate(run, change, percepts, at_s):
            return
        self._tell(run, change)
        self._reports.extend(
            packet_report(
                script, run, change.state, percepts, at_s, change.detail, change.events, change.results
            )
        )
        if change.state is PacketState.FAILED:
            self._end(ScriptState.FAILED, percepts, at_s, change.category, change.detail)
        elif change.state is PacketState.FINISHED and run is self._runs[-1]:
            self._end(ScriptState.FINISHED, percepts, at_s)
        elif change.state is PacketState.FINISHED:
            self._index += 1

    def _delegate(self, run: PacketRun, change: Change, percepts: Percepts | None, at_s: float) -> bool:
        """Put the leg of a packet that has failed to others; False if none may do it."""
        script = self._active_script
        leg = to_delegate(script, self._runs, run, percepts) if self.delegates else None
        if leg is None:
            return False
        self._end_interruption()
        self._delegated = DelegatedMemory(leg=leg.id, category=change.category, detail=change.detail)
        self._remark(run, f"is put to other robots: {change.detail}", percepts, at_s)
        return True

    def _end_interruption(self) -> None:
        """What rules have put in the current packet's way ends with the packet."""
        if self._own is not None:
            self._states.note(self._own.script.id, ScriptState.CANCELLED)
            self._own = None
        self._suspended_s = None

    def _note(self, state: ScriptState) -> None:
        """The current script's new state."""
        self._states.note(self._active_script.id, state)
        self._state = state

    def _set_paused(self, state: ScriptState, percepts: Percepts | None, now_s: float) -> None:
        self._note(state)
        run = self.current
        if run is not None:
            self._reports.extend(
                packet_report(self._active_script, run, self.packet_state or run.state, percepts, now_s)
            )

    def _end(
        self,
        state: ScriptState,
        percepts: Percepts | None,
        at_s: float,
        category: FailureCategory | None = None,
        detail: str = "",
    ) -> None:
        self.end_reason = detail
        self._end_interruption()
        self._delegated = None
        self._note(state)
        self.news.append(News("", state, ()))
        self._reports.extend(
            script_report(
                self._active_script, self._runs, self._index, state, percepts, at_s, category, detail
            )
        )
