"""The seam to a robot that is not ours: it is given one packet at a time."""

from collections.abc import Mapping, Set
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from robots.data import StrEnum
from robots.wire import BehaviourPacket, FailureCategory, PacketResult, SymbolicFact, Telemetry


class ProgressState(StrEnum):
    """What has become of a packet."""

    RUNNING = "running"
    """Not ended, also while it is paused or being cancelled."""
    FINISHED = "finished"
    """It has achieved what it is for."""
    FAILED = "failed"
    """It has ended otherwise: given up, refused by the robot, or cancelled; the robot stands."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """The progress of the packet that was begun.

    `perceived`: the facts that the robot senses now; None: when it finishes, what the packet is to achieve, otherwise
    nothing. `events`: those raised since the last poll. `detail` and `category`: of a failure; `detail` is for the
    operator and continues "TAG …".
    """

    state: ProgressState = ProgressState.RUNNING
    detail: str = ""
    category: FailureCategory = FailureCategory.ROBOT
    perceived: tuple[SymbolicFact, ...] | None = None
    results: tuple[PacketResult, ...] = ()
    events: tuple[str, ...] = ()


class PacketDriver(Protocol):
    """Carries packets out on a robot that is not ours. Called from one thread; never blocks.

    The `id` of a packet that a driver is given is unique among all that it is ever given: script and packet.
    """

    def start(self, packet: BehaviourPacket) -> str | None:
        """Begin a packet, or return the reason if it cannot be done.

        After a restart of this process it is called again with the packet that was begun, whether the robot has
        received it, still carries it out or has ended it meanwhile: the driver must not have it done twice, and `poll`
        tells how it stands. Outside of a restart the packet before has ended, or did not stop in time.

        What a driver adds to its memory here is saved before the next `poll`: ids that it gives to the robot at once
        must follow from the packet's; others are sent from then on.
        """
        ...

    def poll(self) -> Progress:
        """What has become of the packet begun last. An end is told again with each call; events are told once.

        Also called while the packet is paused; an end that it tells then counts only if it tells it afterwards, too.
        """
        ...

    def pause(self) -> None:
        """Stand still as soon as it can be done safely, and keep the packet."""
        ...

    def resume(self) -> None:
        """Go on with the packet after a pause."""
        ...

    def cancel(self) -> None:
        """End the packet. `poll` tells when the robot stands: `FAILED`, or `FINISHED` if it was done before."""
        ...

    def telemetry(self) -> Telemetry | None:
        """The robot's state; None if nothing is known yet. Script and packet are filled in by the caller."""
        ...


@runtime_checkable
class SensingDriver(Protocol):
    """A driver whose robot can wait until it senses a fact that another robot brings about."""

    @property
    def senses(self) -> Set[str]:
        """The predicates that it can sense."""
        ...

    def holds(self, fact: SymbolicFact) -> bool:
        """True if the robot senses now that the fact holds."""
        ...


@runtime_checkable
class HoldingDriver(Protocol):
    """A driver that keeps up what a packet has brought about until the script goes on or ends."""

    def hold(self, step_s: float) -> Progress:
        """Keep it up; called while the script's next packet waits. `FAILED` if that cannot be done.

        :param step_s: since the last call.
        """
        ...


@runtime_checkable
class DriverMemory(Protocol):
    """A driver that has something to remember over restarts. It is saved before `start` and with each change."""

    def memory(self) -> Mapping[str, Any]:
        """JSON data."""
        ...

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Restore what was saved; called once, before all else."""
        ...
