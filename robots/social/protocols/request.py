"""The FIPA Request Interaction Protocol (SC00026)."""

from robots.data import StrEnum
from robots.social.protocols.protocol import InteractionProtocol, Side
from robots.wire import Performative


class RequestState(StrEnum):
    """The state of a conversation."""

    REQUESTED = "requested"
    """The initiator has asked for an action."""
    AGREED = "agreed"
    """The participant will do it, or does it."""
    REFUSED = "refused"
    """The participant will not do it. An end."""
    DONE = "done"
    """The participant has done it. An end."""
    FAILED = "failed"
    """The participant could not do it. An end."""


_RESULTS = {
    (Side.PARTICIPANT, Performative.INFORM): RequestState.DONE,
    (Side.PARTICIPANT, Performative.FAILURE): RequestState.FAILED,
}
REQUEST = InteractionProtocol(
    name="fipa-request",
    opens={Performative.REQUEST: RequestState.REQUESTED},
    transitions={
        RequestState.REQUESTED: {
            (Side.PARTICIPANT, Performative.AGREE): RequestState.AGREED,
            (Side.PARTICIPANT, Performative.REFUSE): RequestState.REFUSED,
            **_RESULTS,  # the agreement may be left out, or arrive later (SC00026, figure 1)
        },
        RequestState.AGREED: _RESULTS,
    },
)
