"""Who may say what when: each protocol's whole table, and nothing beside it."""

from itertools import product

import pytest

from robots.social.protocols import CANCELLED, NOT_UNDERSTOOD, OPENED_BY, PROTOCOLS, InteractionProtocol, Side
from robots.wire import Performative

P = Performative
INITIATOR, PARTICIPANT = Side.INITIATOR, Side.PARTICIPANT
TABLES = {
    "macta-inform": {
        ("said", PARTICIPANT, P.CONFIRM): "confirmed",
        ("said", PARTICIPANT, P.REFUSE): "refused",
    },
    "macta-any": {
        ("said", PARTICIPANT, P.CONFIRM): "confirmed",
        ("said", PARTICIPANT, P.REFUSE): "refused",
    },
    "fipa-request": {
        ("requested", PARTICIPANT, P.AGREE): "agreed",
        ("requested", PARTICIPANT, P.REFUSE): "refused",
        ("requested", PARTICIPANT, P.INFORM): "done",
        ("requested", PARTICIPANT, P.FAILURE): "failed",
        ("agreed", PARTICIPANT, P.INFORM): "done",
        ("agreed", PARTICIPANT, P.FAILURE): "failed",
    },
    "fipa-query": {
        ("asked", PARTICIPANT, P.AGREE): "agreed",
        ("asked", PARTICIPANT, P.REFUSE): "refused",
        ("asked", PARTICIPANT, P.INFORM): "answered",
        ("asked", PARTICIPANT, P.FAILURE): "failed",
        ("agreed", PARTICIPANT, P.INFORM): "answered",
        ("agreed", PARTICIPANT, P.FAILURE): "failed",
    },
    "fipa-contract-net": {
        ("called", PARTICIPANT, P.PROPOSE): "proposed",
        ("called", PARTICIPANT, P.REFUSE): "refused",
        ("proposed", INITIATOR, P.ACCEPT_PROPOSAL): "awarded",
        ("proposed", INITIATOR, P.REJECT_PROPOSAL): "rejected",
        ("awarded", PARTICIPANT, P.INFORM): "done",
        ("awarded", PARTICIPANT, P.FAILURE): "failed",
    },
}
"""FIPA SC00026, SC00027 and SC00029; by state, who says what, and the state after it."""


@pytest.mark.parametrize("protocol", PROTOCOLS.values(), ids=PROTOCOLS)
def test_a_protocol_allows_what_its_table_says_and_nothing_else(protocol: InteractionProtocol) -> None:
    table = TABLES[protocol.name]
    states = {state for state, _, _ in table} | set(table.values())
    for state, side, performative in product(states, Side, Performative):
        wanted = table.get((state, side, performative))
        if any(one == state for one, _, _ in table):
            if performative is P.NOT_UNDERSTOOD:
                wanted = NOT_UNDERSTOOD
            elif performative is P.CANCEL and side is INITIATOR:
                wanted = CANCELLED
        assert protocol.after(state, side, performative) == wanted, (state, side, performative)
        assert protocol.has_ended(state) == all(one != state for one, _, _ in table)


def test_the_protocols_are_those_of_the_tables() -> None:
    assert PROTOCOLS.keys() == TABLES.keys()


def test_every_performative_but_not_understood_opens_one_protocol() -> None:
    assert OPENED_BY.keys() == set(P) - {P.NOT_UNDERSTOOD}
    assert sum(len(one.opens) for one in PROTOCOLS.values()) == len(OPENED_BY)
