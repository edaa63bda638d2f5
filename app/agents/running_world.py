"""A world and the link to its robots, as passed to the composition root."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol, runtime_checkable

from app.agents.late_simulation import LateSimulation
from robots.clock import Clock
from robots.executive.breakpoints import Debugging
from robots.link import Link
from robots.link.mqtt.inbox import Rejected
from robots.link.mqtt.service import Guard, LinkFault, Listener
from robots.link.mqtt.signature import OrderSigner
from robots.link.mqtt.topics import ANNOUNCE_INTERVAL_S
from robots.link.transport import ServiceEnd
from robots.world import WorldFile

FLAT_OUT = 200.0
"""Assumed maximum rate of a world that runs as fast as possible, world seconds per wall-clock second (our choice)."""


class WorldState(StrEnum):
    """Whether messages are exchanged with a world."""

    STARTING = "starting"
    """Its simulation is being built."""
    WAITING_FOR_FLEET = "waiting_for_fleet"
    """No fleet has announced that it drives the world, or none with which messages can be exchanged."""
    RUNNING = "running"
    """Its run is known."""
    FAILED = "failed"
    """Its simulation could not be built."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldStatus:
    """:param detail: what is waited for, or why it failed, in words."""

    state: WorldState
    detail: str = ""


class Driver(Protocol):
    """What drives a world and reports its run: a fleet, or a simulation that is being built."""

    @property
    def run(self) -> str | None:
        """The run of the world, None before it was announced."""
        ...

    @property
    def taken_up(self) -> str | None:
        """The run that messages are exchanged with."""
        ...

    def take_up(self, run: str) -> None: ...


@runtime_checkable
class AnnouncesWorld(Protocol):
    """A link on which the service can announce a world that has no fleet; those of packages need not."""

    @property
    def fleetless_s(self) -> float:
        """Wall-clock seconds, while connected, since a fleet of the world was last heard."""
        ...

    def announce(self, run: str, time_s: float) -> None:
        """Called often: tell robots the world's run and time, at least once a second."""
        ...


@runtime_checkable
class TellsFaults(Protocol):
    """A link that knows why no message can pass; those of packages need not."""

    @property
    def fault(self) -> LinkFault | None: ...

    @property
    def complaint(self) -> str:
        """The fault in words."""
        ...


@runtime_checkable
class RejectsMessages(Protocol):
    """A link that drops invalid messages and says so; those of packages need not."""

    @property
    def rejected(self) -> Rejected | None:
        """None: none so far."""
        ...


@runtime_checkable
class Debuggable(Protocol):
    """A simulation whose robots' rules may have breakpoints; each raises a RuntimeError if no process runs it."""

    def break_at(self, robot: str, rules: frozenset[str]) -> Debugging:
        """Set the breakpoints of a robot's rules, "guard:3" and the like; without any in the world, it goes on."""
        ...

    def go_on(self, *, one_cycle: bool) -> Debugging:
        """Let a world that stands at a breakpoint go on, or make one control cycle and stand again."""
        ...

    def debugging(self) -> Debugging:
        """The breakpoints, and where the world stands."""
        ...


class WorldHost(Protocol):
    """Makes worlds run that are added while the service runs."""

    @property
    def simulates(self) -> bool:
        """True if it starts their simulations itself, False if fleets drive them."""
        ...

    def open(self, file: WorldFile, *, rate: float | None) -> "RunningWorld":
        """The world, started anew or resumed; returns at once.

        :param rate: world seconds per wall-clock second; None: the host's.
        """
        ...

    def forget(self, file: WorldFile) -> None:
        """Drop what is kept of a world that was removed and has ended."""
        ...


@runtime_checkable
class Guarded(Protocol):
    """A link on which others may publish in a robot's name."""

    def guard(self, guard: Guard) -> None:
        """Set who judges messages; before `start`."""
        ...


@runtime_checkable
class SignsOrders(Protocol):
    """A link on which others may publish as the service."""

    def sign_orders(self, signer: OrderSigner) -> None:
        """Set who signs orders to robots that have a key; before `start`."""
        ...


def _nothing() -> None: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class RunningWorld:
    """A world whose robots are reached over `link`, in the time of `clock`.

    :param rate: world seconds per wall-clock second; None: as fast as possible.
    :param run: the id of the world's run, kept when it is resumed; None if `fleet` or `late` reports it.
    :param fleet: the link to the process that drives the world, if that starts and ends by itself.
    :param late: its simulation, if that is built while the service runs.
    :param close: called after the world was removed, or at the service's end; the default: the caller closes it.
    :param new_run_reason: why a new run was started, if an earlier one might have been resumed.
    :param start_new: start a new run if the service announces the world itself.
    :param resume: called once the service receives messages; a simulated world is paused until then.
    """

    file: WorldFile
    link: Link
    clock: Clock
    rate: float | None = 1.0
    run: str | None
    new_run_reason: str = ""
    start_new: bool = False
    resume: Callable[[], None] = _nothing
    fleet: ServiceEnd | None = None
    late: LateSimulation | None = None
    close: Callable[[], None] = _nothing

    @property
    def driver(self) -> Driver | None:
        """What reports the world's run, if that is not known from the start."""
        return self.fleet or self.late

    @property
    def debuggable(self) -> Debuggable | None:
        """Its simulation; None if no simulation of this process drives it, or it is not built yet."""
        simulation = self.clock if self.late is None else self.late.simulation
        return simulation if isinstance(simulation, Debuggable) else None

    def status(self) -> WorldStatus:
        if self.late is not None:
            if self.late.failure:
                return WorldStatus(state=WorldState.FAILED, detail=self.late.failure)
            if self.late.taken_up is None:
                return WorldStatus(state=WorldState.STARTING, detail=self.late.doing)
        if fault := self.fault_words():
            return WorldStatus(state=WorldState.WAITING_FOR_FLEET, detail=fault)
        if self.fleet is not None and self.fleet.run is None:
            detail = f"no fleet drives {self.file.name} yet: start `macta fleet` with the same world file"
            return WorldStatus(state=WorldState.WAITING_FOR_FLEET, detail=detail)
        return WorldStatus(state=WorldState.RUNNING)

    @property
    def fault(self) -> LinkFault | None:
        """Why no message can pass; None if nothing is known to keep them."""
        return self.fleet.fault if isinstance(self.fleet, TellsFaults) else None

    def fault_words(self) -> str:
        """The fault in words; empty if there is none."""
        return self.fleet.complaint if isinstance(self.fleet, TellsFaults) and self.fleet.fault else ""

    def lag_s(self) -> float:
        """World seconds by which `clock` may be behind the world's own clock."""
        if self.fleet is None:
            return 0.0
        pace = self.pace()
        return ANNOUNCE_INTERVAL_S * (FLAT_OUT if pace is None else pace)

    def pace(self) -> float | None:
        """The current rate."""
        return self.rate if self.fleet is None else self.fleet.clock.rate

    def listen(
        self, listener: Listener, guard: Guard | None = None, signer: OrderSigner | None = None
    ) -> None:
        """Start to receive from the fleet, if there is one.

        :param listener: is told of contact and telemetry. :param guard: judges messages, where the link can have that.
        :param signer: signs orders, likewise.
        """
        if self.fleet is not None:
            if guard is not None and isinstance(self.fleet, Guarded):
                self.fleet.guard(guard)
            if signer is not None and isinstance(self.fleet, SignsOrders):
                self.fleet.sign_orders(signer)
            self.fleet.listen(listener)
            self.fleet.start()
