"""The FIPA Query Interaction Protocol (SC00027): whether something holds, or what it holds of."""

from robots.data import StrEnum
from robots.social.protocols.protocol import InteractionProtocol, Side
from robots.wire import Performative


class QueryState(StrEnum):
    """The state of a conversation."""

    ASKED = "asked"
    """The initiator has asked."""
    AGREED = "agreed"
    """The participant will find it out."""
    REFUSED = "refused"
    """The participant does not answer. An end."""
    ANSWERED = "answered"
    """The participant has said it. An end."""
    FAILED = "failed"
    """The participant could not find it out. An end."""


_RESULTS = {
    (Side.PARTICIPANT, Performative.INFORM): QueryState.ANSWERED,
    (Side.PARTICIPANT, Performative.FAILURE): QueryState.FAILED,
}
QUERY = InteractionProtocol(
    name="fipa-query",
    opens={Performative.QUERY_IF: QueryState.ASKED, Performative.QUERY_REF: QueryState.ASKED},
    transitions={
        QueryState.ASKED: {
            (Side.PARTICIPANT, Performative.AGREE): QueryState.AGREED,
            (Side.PARTICIPANT, Performative.REFUSE): QueryState.REFUSED,
            **_RESULTS,
        },
        QueryState.AGREED: _RESULTS,
    },
)
