"""The seam between a robot's agent and its social level: what the two ask of each other."""

from collections.abc import Sequence
from typing import Protocol

from robots.contract.memory import SocialMemory
from robots.data import StrEnum
from robots.executive.offer import Declined, Offer
from robots.wire import (
    BehaviourPacket,
    BehaviourScript,
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

    def send(self, message: Message) -> None:
        """Send without guarantee that it arrives."""
        ...

    def tell_service(self, report: SpeechReport) -> None:
        """Report to the service; kept until its receipt."""
        ...


class Society(Protocol):
    """The social level as the robot's agent finds it."""

    def step(self, arrived: Sequence[Message], robot: Situated) -> None:
        """Handle what others than the service have said, and say what is due. Called in each control cycle."""
        ...

    def packet_ended(self, packet: BehaviourPacket) -> None:
        """The robot has finished a packet of its mission's script."""
        ...

    def told(self) -> tuple[ToldConversation, ...]:
        """The open conversations, the newest last."""
        ...

    def memory(self) -> SocialMemory: ...

    def recall(self, memory: SocialMemory) -> None:
        """Restore what was saved before a power failure."""
        ...
