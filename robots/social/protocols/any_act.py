"""A single speech act that opens none of the other protocols, and its answer.

FIPA has none for it: our choice, so that a person can say any performative to a robot, and hears whether its rules have
taken it.
"""

from robots.data import StrEnum
from robots.social.protocols.protocol import InteractionProtocol, Side
from robots.wire import Performative


class AnyState(StrEnum):
    """The state of a conversation."""

    SAID = "said"
    """The initiator has said it; it repeats it until there is an answer."""
    CONFIRMED = "confirmed"
    """The participant has taken it. An end."""
    REFUSED = "refused"
    """The participant does not take it; its content says why. An end."""


ELSEWHERE = frozenset(
    {
        Performative.REQUEST,
        Performative.QUERY_IF,
        Performative.QUERY_REF,
        Performative.CFP,
        Performative.INFORM,
        Performative.NOT_UNDERSTOOD,
    }
)
"""What opens other protocols, or nothing."""
ANY = InteractionProtocol(
    name="macta-any",
    opens={one: AnyState.SAID for one in Performative if one not in ELSEWHERE},
    transitions={
        AnyState.SAID: {
            (Side.PARTICIPANT, Performative.CONFIRM): AnyState.CONFIRMED,
            (Side.PARTICIPANT, Performative.REFUSE): AnyState.REFUSED,
        }
    },
)
