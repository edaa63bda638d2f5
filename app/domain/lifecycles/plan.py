"""A plan's life cycle: its states, the allowed transitions, and the only code that assigns them."""

from collections.abc import Mapping
from enum import StrEnum
from typing import Protocol

from app.domain.lifecycles.transitions import Stateful, change_state


class PlanState(StrEnum):
    """The state of the decision on a plan."""

    PROPOSED = "proposed"
    """Open to decision."""
    APPROVED = "approved"
    """A mission carries it out, or has carried it out."""
    REJECTED = "rejected"
    """An operator has rejected it."""
    SUPERSEDED = "superseded"
    """Another plan of the goal was approved, or newer alternatives took its place."""
    EXPIRED = "expired"
    """It can no longer be approved: the world has changed, or its goal or mission has ended."""


_TRANSITIONS: Mapping[PlanState, tuple[PlanState, ...]] = {
    PlanState.PROPOSED: (
        PlanState.APPROVED,
        PlanState.REJECTED,
        PlanState.SUPERSEDED,
        PlanState.EXPIRED,
    ),
    PlanState.APPROVED: (),
    PlanState.REJECTED: (),
    PlanState.SUPERSEDED: (),
    PlanState.EXPIRED: (),
}


class Plan(Stateful, Protocol):
    """The fields of a plan that its life cycle assigns."""

    reason: str
    comment: str | None
    decided_by: str | None
    decided_at: str | None


def decide(plan: Plan, state: PlanState, *, actor: str, comment: str, at: str) -> None:
    """Approve or reject the plan.

    :param at: when it was decided (wall clock, ISO 8601).
    """
    change_state(plan, state, _TRANSITIONS, what="plan")
    plan.comment = comment
    plan.decided_by = actor
    plan.decided_at = at


def close(plan: Plan, state: PlanState, reason: str) -> None:
    """End the plan without a decision: it expires or is superseded."""
    change_state(plan, state, _TRANSITIONS, what="plan")
    plan.reason = reason
