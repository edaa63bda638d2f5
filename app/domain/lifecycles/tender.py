"""The life cycle of a goal's tender: robots bid for the legs of its first plan before it is planned.

Only this module assigns the state.
"""

from collections.abc import Mapping
from enum import StrEnum
from typing import Protocol

from app.domain.lifecycles.transitions import Stateful, change_state


class TenderState(StrEnum):
    """The state of a tender."""

    CALLED = "called"
    """Robots are called for proposals; the goal is planned once all have answered or their time is over."""
    AWARDED = "awarded"
    """Legs go to bidders, and the goal is planned with these."""
    CENTRAL = "central"
    """The goal is planned without awards. The reason says why."""
    POSTPONED = "postponed"
    """Robots that missions still need are the best bidders: the goal waits for them, and all are called again."""


_TRANSITIONS: Mapping[TenderState, tuple[TenderState, ...]] = {
    TenderState.CALLED: (TenderState.AWARDED, TenderState.CENTRAL, TenderState.POSTPONED),
    TenderState.AWARDED: (
        TenderState.AWARDED,  # failed legs go to the next best bidders
        TenderState.CENTRAL,  # no plan keeps to the awards
    ),
    TenderState.CENTRAL: (),
    TenderState.POSTPONED: (),
}


class Tender(Stateful, Protocol):
    """The fields of a tender that its life cycle assigns."""

    reason: str


def award(tender: Tender) -> None:
    """Have the goal planned with the awards."""
    change_state(tender, TenderState.AWARDED, _TRANSITIONS, what="tender")


def plan_centrally(tender: Tender, reason: str) -> None:
    """Have the goal planned without awards."""
    change_state(tender, TenderState.CENTRAL, _TRANSITIONS, what="tender")
    tender.reason = reason


def postpone(tender: Tender, reason: str) -> None:
    """Have the goal wait until its best bidders are free."""
    change_state(tender, TenderState.POSTPONED, _TRANSITIONS, what="tender")
    tender.reason = reason
