"""The software of a door, hatch or lift: it keeps the contract as a robot does, over a mechanism that moves panels."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from robots.adapters.contract_robot import ContractRobot
from robots.adapters.driver import Progress, ProgressState
from robots.adapters.packet_forms import PacketForm
from robots.clock import Clock
from robots.contract.memory_file import MemoryStore
from robots.link import Link
from robots.wire import BehaviourPacket, PacketState, SymbolicFact, Telemetry, UpkeepReport

OPEN = "open"
CLOSED = "closed"
GOALS = {"OPEN": OPEN, "CLOSE": CLOSED}
"""Where a door's packets take it; a lift's go to their `level2`."""
HELD_S = 30.0
"""World seconds in which one that was moved by somebody else must be back where its script has it (our choice)."""


class Mechanism(Protocol):
    """What moves: a door's panel, or a lift with its doors. Never blocks."""

    @property
    def state(self) -> str:
        """`open` or `closed`, of a lift its level; empty while it moves, or where it got stuck."""
        ...

    @property
    def fault(self) -> str:
        """Why it does not get where it is to go, in words; empty if it does, or is there."""
        ...

    def go_to(self, state: str) -> None:
        """Begin to go to this state; nothing happens if it is there or on its way."""
        ...

    def stop(self) -> None:
        """Stand still; a door or lift that cannot stop half-way goes where it was going."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class PeripheralProfile:
    """A door's or hatch's, or with `levels` a lift's, name and place in metres.

    `closes_after_s`: how long it stays open once no script needs it; None: it stays so.
    """

    name: str
    x_m: float
    y_m: float
    levels: tuple[str, ...] = ()
    closes_after_s: float | None = None

    def fact(self, state: str) -> SymbolicFact:
        """What holds in this state, the empty one included."""
        if not state:
            return SymbolicFact(predicate="half_way", args=(self.name,))
        if self.levels:
            return SymbolicFact(predicate="lift_at", args=(self.name, state))
        return SymbolicFact(predicate="opened" if state == OPEN else "closed", args=(self.name,))

    @property
    def packets(self) -> Mapping[str, PacketForm]:
        if self.levels:
            levels = frozenset(self.levels)
            return {"MOVE_TO_LEVEL": PacketForm(arguments=("level2",), choices={"level2": levels})}
        return {tag: PacketForm() for tag in GOALS}


class PeripheralDriver:
    """Carries the packets of a door, hatch or lift out. Implements `PacketDriver`, `HoldingDriver`, `DriverMemory`."""

    def __init__(self, profile: PeripheralProfile, mechanism: Mechanism) -> None:
        self._profile = profile
        self._mechanism = mechanism
        self._wanted = ""
        self._away_s = 0.0
        self._is_paused = False
        self._is_cancelled = False

    def start(self, packet: BehaviourPacket) -> str | None:
        self._wanted = GOALS.get(packet.tag) or packet.arguments["level2"]
        self._is_paused = False
        self._is_cancelled = False
        self._mechanism.go_to(self._wanted)
        return None

    def poll(self) -> Progress:
        perceived = self.perceived()
        if self._mechanism.state == self._wanted:
            return Progress(state=ProgressState.FINISHED, perceived=perceived)
        if self._is_cancelled:
            return Progress(state=ProgressState.FAILED, detail="cancelled", perceived=perceived)
        if fault := self._mechanism.fault:
            return Progress(state=ProgressState.FAILED, detail=fault, perceived=perceived)
        return Progress(perceived=perceived)

    def pause(self) -> None:
        self._is_paused = True
        self._mechanism.stop()

    def resume(self) -> None:
        if self._is_paused:
            self._is_paused = False
            self._mechanism.go_to(self._wanted)

    def cancel(self) -> None:
        self._is_cancelled = True
        self._mechanism.stop()

    def hold(self, step_s: float) -> Progress:
        """Go back to where the last packet took it: others rely on that until the next one."""
        perceived = self.perceived()
        if self._wanted in ("", self._mechanism.state):
            self._away_s = 0.0
            return Progress(perceived=perceived)
        self._away_s += step_s
        self._mechanism.go_to(self._wanted)
        fault = self._mechanism.fault
        if not fault and self._away_s > HELD_S:
            where = f"at {self._wanted}" if self._profile.levels else self._wanted
            fault = f"it is no longer {where}, for {HELD_S:.0f} s"
        return (
            Progress(state=ProgressState.FAILED, detail=fault, perceived=perceived)
            if fault
            else Progress(perceived=perceived)
        )

    def memory(self) -> Mapping[str, Any]:
        return {"wanted": self._wanted}

    def recall(self, memory: Mapping[str, Any]) -> None:
        self._wanted = memory.get("wanted", "")

    def perceived(self) -> tuple[SymbolicFact, ...]:
        """How it stands."""
        return (self._profile.fact(self._mechanism.state),)

    def telemetry(self) -> Telemetry:
        here = self._profile
        return Telemetry(at_s=0.0, x_m=here.x_m, y_m=here.y_m, heading_rad=0.0)


class PeripheralAgent:
    """A door, hatch or lift on the link. Call `tick()` at 10 Hz.

    It stays open as long as a script of it has not ended: the script's CLOSE comes once everybody is through. What it
    does of itself it reports as upkeep.
    """

    def __init__(
        self,
        profile: PeripheralProfile,
        *,
        mechanism: Mechanism,
        link: Link,
        clock: Clock,
        store: MemoryStore | None = None,
        run: str | None = None,
        round_trip_s: float = 0.0,
    ) -> None:
        """:param store: its persistent memory; None: it forgets everything at a restart. :param run: of the world."""
        self._profile = profile
        self._mechanism = mechanism
        self._clock = clock
        self._driver = PeripheralDriver(profile, mechanism)
        self._idle_since_s: float | None = None
        self._told = mechanism.state
        self._contract = ContractRobot(
            profile.name,
            driver=self._driver,
            packets=profile.packets,
            link=link,
            clock=clock,
            store=store,
            run=run,
            round_trip_s=round_trip_s,
        )

    @property
    def contract(self) -> ContractRobot:
        """What it has been asked and has to tell."""
        return self._contract

    def tick(self) -> None:
        """One cycle: messages, mechanism, reports; then what it does of itself."""
        had_script = self._contract.script_id is not None
        self._contract.tick()
        now_s = self._clock.now_s()
        if had_script or self._contract.script_id is not None:
            self._idle_since_s = None
            self._told = self._mechanism.state
            return
        if self._idle_since_s is None:
            self._idle_since_s = now_s
        closes_after_s = self._profile.closes_after_s
        is_due = closes_after_s is not None and now_s - self._idle_since_s >= closes_after_s
        if is_due and self._mechanism.state != CLOSED:
            self._mechanism.go_to(CLOSED)
        self._tell_change(now_s)

    def _tell_change(self, now_s: float) -> None:
        """Report a state that it has come to without a script, by itself or by somebody's hand."""
        state = self._mechanism.state
        if not state or state == self._told:
            return
        self._told = state
        tag = "MOVE_TO_LEVEL" if self._profile.levels else "OPEN" if state == OPEN else "CLOSE"
        self._contract.report_upkeep(
            UpkeepReport(
                tag=tag, state=PacketState.FINISHED, at_s=now_s, perceived=(self._profile.fact(state),)
            )
        )


__all__ = ["CLOSED", "OPEN", "Mechanism", "PeripheralAgent", "PeripheralDriver", "PeripheralProfile"]
