"""Interaction protocols: who may say what when. One module each, as state machines."""

from collections.abc import Mapping

from robots.social.protocols.any_act import ANY, AnyState
from robots.social.protocols.contract_net import CONTRACT_NET, ContractNetState
from robots.social.protocols.inform import INFORM, InformState
from robots.social.protocols.protocol import (
    CANCELLED,
    NOT_UNDERSTOOD,
    TIMED_OUT,
    InteractionProtocol,
    Side,
)
from robots.social.protocols.query import QUERY, QueryState
from robots.social.protocols.request import REQUEST, RequestState
from robots.wire import Performative

PROTOCOLS: Mapping[str, InteractionProtocol] = {
    one.name: one for one in (INFORM, REQUEST, QUERY, CONTRACT_NET, ANY)
}
"""By name, as messages state it."""
OPENED_BY: Mapping[Performative, InteractionProtocol] = {
    performative: protocol for protocol in PROTOCOLS.values() for performative in protocol.opens
}
"""By the performative that opens a conversation."""

__all__ = [
    "ANY",
    "CANCELLED",
    "CONTRACT_NET",
    "INFORM",
    "NOT_UNDERSTOOD",
    "OPENED_BY",
    "PROTOCOLS",
    "QUERY",
    "REQUEST",
    "TIMED_OUT",
    "AnyState",
    "ContractNetState",
    "InformState",
    "InteractionProtocol",
    "QueryState",
    "RequestState",
    "Side",
]
