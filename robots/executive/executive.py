"""The executive: carries out one behaviour script, packet after packet, without a link (MACTA §3, fig. 3)."""

from collections.abc import Iterable, Sequence

from robots.conditions.facts import perceived
from robots.errors import RepertoireError
from robots.executive.actions import CYCLIC_ACTIONS
from robots.executive.known_scripts import ENDED, Standing
from robots.executive.memory import ExecutiveMemory, ScriptMemory
from robots.executive.packet_run import Outcome, PacketRun
from robots.executive.plans import task_plan
from robots.executive.reporting import Report, forgone_report, packet_report, script_report
from robots.executive.sensing_plan import BehaviourState, StateMachine, schedule
from robots.executive.trace import Instant, Trace
from robots.perception.percepts import GRIP, Percepts
from robots.physical.profile import RobotProfile
from robots.reactive.patterns import Responses
from robots.reactive.synthesis import Motion
from robots.repertoire import Repertoire, load_self_level
from robots.wire import (
    BehaviourScript,
    ControlVerb,
    FailureCategory,
    PacketState,
    ScriptState,
    StatusReport,
    SymbolicFact,
)


class Executive:
    """Runs at most one script at a time and remembers how the earlier ones ended.

    `task_state` is τ of P-SMPA's model: what the packets finished so far have made of the task.
    """

    def __init__(self, profile: RobotProfile, repertoire: Repertoire) -> None:
        self._profile = profile
        self._repertoire = repertoire
        self._critical = load_self_level().critical
        self._script: BehaviourScript | None = None
        self._runs: list[PacketRun] = []
        self._index, self._order = 0, 0
        self._machine = StateMachine()
        self.task_state: frozenset[SymbolicFact] = frozenset()
        self._standing = Standing()
        self._reports: list[Report] = []
        self.ending = ""
        """Why the last script that ended did, in words; empty if of itself."""
        self.responses = Responses()
        self.trace = Trace()

    @property
    def script_id(self) -> str | None:
        """The script under way, or the last one."""
        return self._script.id if self._script else None

    @property
    def script(self) -> BehaviourScript | None:
        """The script under way."""
        return self._script if self.active else None

    @property
    def state(self) -> ScriptState | None:
        return self._standing.of(self._script.id) if self._script else None

    @property
    def _under_way(self) -> BehaviourScript:
        assert self._script is not None
        return self._script

    @property
    def active(self) -> bool:
        return self.state is not None and self.state not in ENDED

    @property
    def current(self) -> PacketRun | None:
        """The packet under way."""
        return self._runs[self._index] if self.active else None

    @property
    def behaviour(self) -> BehaviourState | None:
        """The state of the machine under way, with the sensor actions beside it; None if there is nothing to do."""
        run = self.current
        return None if run is None or self.state is ScriptState.PAUSED else self._machine.states[run.action]

    def accept(self, script: BehaviourScript) -> str | None:
        """Take on a script, or say why not: busy, not mine, or a packet that does not fit the repertoire.

        The robot's own gives way to it.
        """
        if script.robot != self._profile.name:
            return f"script {script.id} is for {script.robot}, this is {self._profile.name}"
        if self.script is not None and not self.script.is_own:
            return f"{self._profile.name} is busy with script {self.script.id}"
        try:
            runs, machine = self._prepared(script)
        except RepertoireError as error:
            return str(error)
        missing = machine.pre - self._profile.sensors
        if missing:
            return f"{self._profile.name} has no {', '.join(sorted(missing))}, which script {script.id} needs"
        if self.script is not None:
            self._standing.note(self.script.id, ScriptState.CANCELLED)
        self._script, self._runs, self._index, self._machine = script, runs, 0, machine
        self.task_state, self._order = frozenset(), 0
        self._standing.note(script.id, ScriptState.ACCEPTED)
        return None

    def _prepared(self, script: BehaviourScript) -> tuple[list[PacketRun], StateMachine]:
        """A script's packets as they are run, and their states in order.

        :raises RepertoireError: if one does not fit the repertoire.
        """
        profile = self._profile
        runs = [PacketRun(p, self._repertoire.bind(p, profile), profile) for p in script.packets]
        return runs, schedule(task_plan(script, [run.content for run in runs]), CYCLIC_ACTIONS)

    def memory(self) -> ExecutiveMemory:
        script, packets = self._script, tuple(run.memory() for run in self._runs)
        if script is None:
            return ExecutiveMemory()
        place = ScriptMemory(
            script=script, index=self._index, packets=packets, task_state=self.task_state, order=self._order
        )
        return ExecutiveMemory(script=place, states=self._standing.memory())

    def recall(self, memory: ExecutiveMemory, now_s: float) -> None:
        """Go on in the packet that was under way. A script that does not fit the repertoire any more has failed."""
        self._standing.recall(memory.states)
        if memory.script is None:
            return
        self._script, self._index = memory.script.script, memory.script.index
        self.task_state, self._order = memory.script.task_state, memory.script.order
        if not self.active:
            return
        try:
            self._runs, self._machine = self._prepared(self._script)
        except RepertoireError as error:
            why = f"cannot go on after a restart: {error}"
            self._end(ScriptState.FAILED, None, now_s, FailureCategory.ROBOT, why)
            return
        for run, packet in zip(self._runs, memory.script.packets, strict=True):
            run.recall(packet)

    def retune(self, repertoire: Repertoire) -> None:
        """Go on with this repertoire from the next packet on.

        :raises RepertoireError: if a packet that is still to come does not fit it; then nothing changes.
        """
        begun = self._index + 1
        later = [run.rebound(repertoire.bind(run.packet, self._profile)) for run in self._runs[begun:]]
        self._repertoire = repertoire
        self._runs[begun:] = later

    def control(
        self,
        script_id: str,
        verb: ControlVerb,
        percepts: Percepts | None,
        now_s: float,
        why: str = "cancelled on request",
        *,
        number: int = 0,
    ) -> str | None:
        """Cancel, pause or resume the script under way, or say why not. The gripper stays as it is.

        :param number: of the order. Orders overtake each other: a pause or resume older than what was followed last is
            not followed any more. A cancel is, whatever came before it.
        """
        if (stale := self._stale(script_id)) is not None:
            return stale
        if verb is not ControlVerb.CANCEL and number < self._order:
            return f"order {number} to {verb.value} script {script_id} was overtaken by order {self._order}"
        self._order = max(number, self._order)
        if verb is ControlVerb.CANCEL:
            self._end(ScriptState.CANCELLED, percepts, now_s, FailureCategory.CANCELLED, why)
        elif verb is ControlVerb.PAUSE and self.state is not ScriptState.PAUSED:
            self._pause(ScriptState.PAUSED, percepts, now_s)
        elif verb is ControlVerb.RESUME and self.state is ScriptState.PAUSED:
            self._pause(ScriptState.RUNNING, percepts, now_s)
        return None

    def forgo(self, script_id: str, percepts: Percepts | None, now_s: float) -> bool:
        """Report a script that has not come as cancelled; False if it is known here."""
        if script_id in self._standing:
            return False
        self._standing.note(script_id, ScriptState.CANCELLED)
        self._say(forgone_report(script_id, percepts, now_s))
        return True

    def clear(self, script_id: str, ended: Iterable[str]) -> str | None:
        """Note that actions have ended which packets of the script under way come after, or say why not."""
        if (stale := self._stale(script_id)) is not None:
            return stale
        for run in self._runs:
            run.clear(ended)
        return None

    def step(self, percepts: Percepts, step_s: float) -> Motion:
        """Advance the script by one tick. No motion without a script that runs, nor before its first percepts."""
        self.responses = Responses()
        self._spare(percepts)
        run, behaviour = self.current, self.behaviour
        if run is None or behaviour is None or not percepts.data.holds(behaviour.action.percepts):
            return Motion()
        self._standing.note(self._under_way.id, ScriptState.RUNNING)
        outcome = run.step(percepts, step_s)
        self.responses = outcome.responses
        self.trace.record(Instant(percepts.time_s, run.packet.id, outcome.responses, outcome.motion))
        self._follow(run, outcome, percepts)
        return outcome.motion

    def _spare(self, percepts: Percepts) -> None:
        """With the battery nearly empty a script is broken off, but not while the jaws are at work, nor while it holds
        what takes two robots.
        """
        run = self.current
        if run is None or self._under_way.is_own or run.grips or percepts.battery >= self._critical:
            return
        if percepts.data.holds(GRIP) and percepts.holding in self._profile.lengths_m:
            return
        why = f"broke off: battery at {percepts.battery:.0%}"
        self._follow(run, run.fail(FailureCategory.ROBOT, why, None), percepts)

    def fault(self, why: str, last: Percepts | None, now_s: float) -> None:
        """A sensor cannot be relied on: the script fails. `last`: what was perceived before."""
        run = self.current
        if run is not None:
            self._follow(run, run.fault(why, last), None, now_s)

    def status(self, script_id: str, percepts: Percepts | None, now_s: float) -> StatusReport:
        """How a script stands; state None for one that is not known."""
        run = self.current if script_id == self.script_id else None
        return StatusReport(
            script_id=script_id,
            state=self._standing.of(script_id),
            at_s=now_s,
            packet_id=run.packet.id if run else None,
            packet_state=self.packet_state if run else None,
            perceived=perceived(percepts),
            detail=run.waits_for if run else "",
            order=self._order if run else 0,
        )

    @property
    def packet_state(self) -> PacketState | None:
        if (run := self.current) is None:
            return None
        return PacketState.PAUSED if self.state is ScriptState.PAUSED else run.state

    def take_reports(self) -> Sequence[Report]:
        """The reports made since they were last taken, oldest first."""
        reports, self._reports = self._reports, []
        return reports

    def _stale(self, script_id: str) -> str | None:
        """Why an order on the script cannot be followed; None if it is under way."""
        if self.active and script_id == self.script_id:
            return None
        return self._standing.why_not(script_id)

    def _follow(
        self, run: PacketRun, outcome: Outcome, percepts: Percepts | None, now_s: float = 0.0
    ) -> None:
        if (change := outcome.change) is None:
            return
        at_s = percepts.time_s if percepts else now_s
        script = self._under_way
        self._say(packet_report(script, run, change.state, percepts, at_s, change.detail, change.events))
        if change.state is PacketState.FINISHED:
            self.task_state = self._machine.states[run.action].action.apply(self.task_state)
        if change.state is PacketState.FAILED:
            self._end(ScriptState.FAILED, percepts, at_s, change.category, change.detail)
        elif change.state is PacketState.FINISHED and run is self._runs[-1]:
            self._end(ScriptState.FINISHED, percepts, at_s)
        elif change.state is PacketState.FINISHED:
            self._index += 1

    def _pause(self, state: ScriptState, percepts: Percepts | None, now_s: float) -> None:
        self._standing.note(self._under_way.id, state)
        run = self.current
        if run is not None:
            self._say(packet_report(self._under_way, run, self.packet_state or run.state, percepts, now_s))

    def _say(self, reports: Iterable[Report]) -> None:
        self._reports.extend(reports)

    def _end(
        self,
        state: ScriptState,
        percepts: Percepts | None,
        at_s: float,
        category: FailureCategory | None = None,
        detail: str = "",
    ) -> None:
        self.ending = detail
        self._standing.note(self._under_way.id, state)
        self._say(script_report(self._under_way, self._index, state, percepts, at_s, category, detail))
