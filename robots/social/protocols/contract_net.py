"""The FIPA Contract Net Interaction Protocol (SC00029), towards one of the participants.

The initiator has a conversation with each participant, all with one conversation id.
"""

from robots.data import StrEnum
from robots.social.protocols.protocol import InteractionProtocol, Side
from robots.wire import Performative


class ContractNetState(StrEnum):
    """The state of a conversation."""

    CALLED = "called"
    """The initiator has called for proposals."""
    PROPOSED = "proposed"
    """The participant has made a bid, and is bound to it until it is answered."""
    REFUSED = "refused"
    """The participant makes no bid. An end."""
    REJECTED = "rejected"
    """Its bid was not taken. An end."""
    AWARDED = "awarded"
    """Its bid was taken: the participant does the task."""
    DONE = "done"
    """The participant has done the task. An end."""
    FAILED = "failed"
    """The participant could not do the task. An end."""


CONTRACT_NET = InteractionProtocol(
    name="fipa-contract-net",
    opens={Performative.CFP: ContractNetState.CALLED},
    transitions={
        ContractNetState.CALLED: {
            (Side.PARTICIPANT, Performative.PROPOSE): ContractNetState.PROPOSED,
            (Side.PARTICIPANT, Performative.REFUSE): ContractNetState.REFUSED,
        },
        ContractNetState.PROPOSED: {
            (Side.INITIATOR, Performative.ACCEPT_PROPOSAL): ContractNetState.AWARDED,
            (Side.INITIATOR, Performative.REJECT_PROPOSAL): ContractNetState.REJECTED,
        },
        ContractNetState.AWARDED: {
            (Side.PARTICIPANT, Performative.INFORM): ContractNetState.DONE,
            (Side.PARTICIPANT, Performative.FAILURE): ContractNetState.FAILED,
        },
    },
)
