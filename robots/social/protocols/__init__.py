"""Interaction protocols: who may say what when. One module each, as state machines."""

from collections.abc import Mapping

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

PROTOCOLS: Mapping[str, InteractionProtocol] = {
    one.name: one for one in (INFORM, REQUEST, QUERY, CONTRACT_NET)
}
"""By name, as messages state it."""

__all__ = [
    "CANCELLED",
    "CONTRACT_NET",
    "INFORM",
    "NOT_UNDERSTOOD",
    "PROTOCOLS",
    "QUERY",
    "REQUEST",
    "TIMED_OUT",
    "ContractNetState",
    "InformState",
    "InteractionProtocol",
    "QueryState",
    "RequestState",
    "Side",
]
