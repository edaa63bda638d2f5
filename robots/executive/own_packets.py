"""Packets of the robot's own between those of a script: the script's packet stands meanwhile, then goes on.

The script is not changed: its packets keep their order and what they wait for. Own packets do not move the jaws, on
which the script relies, and run while the robot holds something only if they are declared to.
"""

from collections.abc import Sequence

from robots.executive.memory import OwnMemory
from robots.executive.packet_run import Outcome, PacketRun
from robots.executive.sensing_plan import BehaviourState, StateMachine
from robots.perception.percepts import GRIP, NOTHING, Percepts
from robots.physical.profile import RobotProfile
from robots.reactive.synthesis import DegreeOfFreedom
from robots.wire import BehaviourScript, FailureCategory, PacketState, ScriptState

AT_MOST_S = 120.0
"""The longest time that own packets keep a script waiting, and that a packet stays suspended (our choice)."""


class OwnPackets:
    """Own packets that run in place of a script's current packet."""

    def __init__(self, script: BehaviourScript, runs: Sequence[PacketRun], machine: StateMachine) -> None:
        self.script = script
        self._runs = runs
        self._machine = machine
        self._index = 0
        self._left_s = AT_MOST_S

    def memory(self) -> OwnMemory:
        return OwnMemory(
            script=self.script,
            index=self._index,
            packets=tuple(run.memory() for run in self._runs),
            left_s=self._left_s,
        )

    def recall(self, memory: OwnMemory) -> None:
        """Go on from there; of the same script."""
        self._index = memory.index
        self._left_s = memory.left_s
        for run, packet in zip(self._runs, memory.packets, strict=True):
            run.recall(packet)

    @property
    def current(self) -> PacketRun:
        return self._runs[self._index]

    @property
    def behaviour(self) -> BehaviourState:
        return self._machine[self.current.packet.id, self.current.phase]

    def why_not_between(self, profile: RobotProfile, script: BehaviourScript) -> str | None:
        """Why these packets must not run between those of a script; None if they may."""
        needed = NOTHING.union(*(state.needs for state in self._machine.values()))
        if missing := needed - profile.sensors:
            return f"{profile.name} has no {', '.join(sorted(missing))}, which {self.script.id} needs"
        for run in self._runs:
            if any(one.dof is DegreeOfFreedom.GRIP for one in run.content.patterns):
                return f"{run.packet.tag} moves the jaws, on which script {script.id} relies"
        return None

    def step(self, percepts: Percepts, step_s: float) -> tuple[Outcome, ScriptState | None]:
        """One tick, and how they have ended; None while they run."""
        self._left_s -= step_s
        run = self.current
        if self._left_s <= 0:
            reason = f"has kept the script waiting for {AT_MOST_S:.0f} s"
            return run.fail(FailureCategory.DEADLINE, reason, percepts), ScriptState.FAILED
        if not percepts.data.holds(self.behaviour.needs):
            return Outcome(), None
        outcome = run.step(percepts, step_s)
        state = outcome.change.state if outcome.change else None
        if state is PacketState.FAILED:
            return outcome, ScriptState.FAILED
        if state is PacketState.FINISHED and run is self._runs[-1]:
            return outcome, ScriptState.FINISHED
        if state is PacketState.FINISHED:
            self._index += 1
        return outcome, None


def why_not_now(
    current: PacketRun, profile: RobotProfile, percepts: Percepts | None, *, may_carry: bool
) -> str | None:
    """Why the current packet must not be interrupted for others; None if it may."""
    if current.grips:
        return f"{current.packet.tag} moves the jaws"
    if percepts is None:
        return f"{profile.name} senses nothing now"
    return why_held(profile, percepts, may_carry=may_carry)


def why_held(profile: RobotProfile, percepts: Percepts, *, may_carry: bool) -> str | None:
    """Why what the robot holds must not be moved by others than the script's packets; None if it may, or is nothing."""
    held = percepts.holding if percepts.data.holds(GRIP) else percepts.last_held
    if held in profile.lengths_m:
        return f"{profile.name} holds {held} with another robot"
    if held is not None and not may_carry:
        return f"{profile.name} holds {held}: only packets of a CARRY statement may move it"
    return None
