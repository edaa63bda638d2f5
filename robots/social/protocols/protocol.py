"""What an interaction protocol is: states, and which performative of which side leads from one to the next."""

from collections.abc import Mapping
from dataclasses import dataclass

from robots.data import StrEnum
from robots.wire import Performative


class Side(StrEnum):
    """The two sides of a conversation."""

    INITIATOR = "initiator"
    """It has opened the conversation."""
    PARTICIPANT = "participant"
    """It was spoken to."""


Said = tuple[Side, Performative]
TIMED_OUT = "timed_out"
"""The end of every conversation whose answer does not come in time."""
NOT_UNDERSTOOD = "not_understood"
"""The end of every conversation in which one side did not understand the other."""
CANCELLED = "cancelled"
"""The end of a conversation that its initiator has given up (the FIPA Cancel Meta-Protocol, without its answer)."""
COMMON_ENDS = frozenset({TIMED_OUT, NOT_UNDERSTOOD, CANCELLED})


@dataclass(frozen=True, slots=True, kw_only=True)
class InteractionProtocol:
    """A FIPA interaction protocol between an initiator and one participant.

    :param opens: by the performative that opens a conversation, its first state.
    :param transitions: by state, what may be said in it, and the state after that. A state without any is an end.
    """

    name: str
    opens: Mapping[Performative, str]
    transitions: Mapping[str, Mapping[Said, str]]

    def has_ended(self, state: str) -> bool:
        return not self.transitions.get(state)

    def after(self, state: str, side: Side, performative: Performative) -> str | None:
        """The state after this was said; None if it may not be said now.

        Not-understood may be said by both sides until the end, and cancel by the initiator.
        """
        if self.has_ended(state):
            return None
        if performative is Performative.NOT_UNDERSTOOD:
            return NOT_UNDERSTOOD
        if performative is Performative.CANCEL and side is Side.INITIATOR:
            return CANCELLED
        return self.transitions[state].get((side, performative))
