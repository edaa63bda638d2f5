"""An inform that is confirmed. FIPA has no protocol for it, for its informs are not answered: our choice, since a
message may be lost.
"""

from robots.data import StrEnum
from robots.social.protocols.protocol import InteractionProtocol, Side
from robots.wire import Performative


class InformState(StrEnum):
    """The state of a conversation."""

    SAID = "said"
    """The initiator has said it; it repeats it until there is an answer."""
    CONFIRMED = "confirmed"
    """The participant has taken it. An end."""
    REFUSED = "refused"
    """The participant does not take it; its content says why. An end."""


INFORM = InteractionProtocol(
    name="macta-inform",
    opens={Performative.INFORM: InformState.SAID},
    transitions={
        InformState.SAID: {
            (Side.PARTICIPANT, Performative.CONFIRM): InformState.CONFIRMED,
            (Side.PARTICIPANT, Performative.REFUSE): InformState.REFUSED,
        }
    },
)
