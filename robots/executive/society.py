"""The seam between a robot's agent and its social level: what the two ask of each other."""

from collections.abc import Sequence
from typing import Protocol

from robots.contract.memory import SocialMemory
from robots.data import StrEnum
from robots.executive.delegation import DelegatedLeg
from robots.executive.offer import Declined, Offer
from robots.perception.percepts import Needs, Percepts
from robots.wire import (
    BehaviourPacket,
    BehaviourScript,
    DelegationReport,
    Message,
    ScriptState,
    SpeechReport,
    ToldConversation,
)


class Clearing(StrEnum):
    """What has become of another robot's word that an action has ended."""

    NOTED = "noted"
    """The script knows it; said again, it changes nothing."""
    UNKNOWN_SCRIPT = "unknown_script"
    """The script is not here; it may still come."""
    SCRIPT_ENDED = "script_ended"
    """The script has ended, or another has replaced it."""
    NOT_NAMED = "not_named"
    """The script does not name this robot for this action."""


class Situated(Protocol):
    """The robot as its social level finds it."""

    def clear_by(self, script_id: str, action: str, robot: str) -> Clearing:
        """Note that another robot says to have ended its part of an action that the script waits for."""
        ...

    def offer(self, leg: BehaviourScript, *, promised_s: float) -> Offer | Declined:
        """The robot's bid for a leg now, or why it makes none.

        :param promised_s: the time of other legs that it was awarded and has no script of.
        """
        ...

    def state_of(self, script_id: str) -> ScriptState | None:
        """The state of one of the robot's last scripts; None for one that it does not know."""
        ...

    def perform(self, script: BehaviourScript) -> str | None:
        """Begin a script of the robot's own at another's word, or return the reason against it."""
        ...

    def halt(self, prefix: str) -> str | None:
        """End the robot's own script if its id begins so, or return why there is none to end."""
        ...

    def withdraw(self, script_id: str) -> None:
        """End a script of the robot's own, if it has not ended."""
        ...

    def why_ended(self, script_id: str) -> str:
        """Why one of the robot's last scripts has ended, in words; empty if it has finished or that is not known."""
        ...

    @property
    def delegated(self) -> DelegatedLeg | None:
        """The leg of its script that is put to other robots now; None if there is none."""
        ...

    def make_way(self, own: BehaviourScript) -> str | None:
        """Run own packets while a leg is put to others, or return the reason against it."""
        ...

    def end_delegated(self, robot: str) -> None:
        """Another robot has done the leg: the script goes on after it."""
        ...

    def take_back(self, reason: str) -> None:
        """No other robot does the leg: the script has failed."""
        ...

    def packets_ended(self, script_id: str) -> int | None:
        """How many packets of the present script, or the last one, have finished; None if that is not known."""
        ...

    def moves_jaws(self, packet: BehaviourPacket) -> bool:
        """True if a packet takes something or puts it down; also if this robot does not know it."""
        ...

    @property
    def service_heard_s(self) -> float:
        """When the service was last heard (world's clock)."""
        ...

    @property
    def service_answers_s(self) -> float:
        """In what time the service answers a report, if the link is up."""
        ...

    @property
    def percepts(self) -> Percepts | None:
        """Those of the present tick, or the last ones."""
        ...

    @property
    def activity(self) -> tuple[str, ...]:
        """The packet that the robot is at, its state and its script; nothing without one."""
        ...

    @property
    def beliefs(self) -> tuple[str, ...]:
        """What its agents believe, as in rule files, the newest last."""
        ...

    def send(self, message: Message) -> None:
        """Send without guarantee that it arrives."""
        ...

    def tell_service(self, report: SpeechReport | DelegationReport) -> None:
        """Report to the service; kept until its receipt."""
        ...


class Society(Protocol):
    """The social level as the robot's agent finds it."""

    def step(self, arrived: Sequence[Message], robot: Situated) -> None:
        """Handle what others than the service have said, and say what is due. Called in each control cycle."""
        ...

    @property
    def needs(self) -> Needs:
        """The sensors that it needs now."""
        ...

    def packet_ended(self, packet: BehaviourPacket) -> None:
        """The robot has finished a packet of its mission's script."""
        ...

    def told(self) -> tuple[ToldConversation, ...]:
        """The open conversations, the newest last."""
        ...

    def memory(self) -> SocialMemory: ...

    def hand_over(self) -> SocialMemory:
        """The memory with all conversations, for another program that goes on with them."""
        ...

    def recall(self, memory: SocialMemory) -> None:
        """Restore what was saved before a power failure, or handed over."""
        ...
