"""A plan's life cycle: it is decided on or closed once."""

from dataclasses import dataclass

import pytest

from app.domain.errors import IllegalTransition
from app.domain.lifecycles import plan as plan_lifecycle
from app.domain.lifecycles.plan import PlanState

DECISIONS = (PlanState.APPROVED, PlanState.REJECTED)
CLOSED = (PlanState.SUPERSEDED, PlanState.EXPIRED)


@dataclass
class Plan:
    state: str = PlanState.PROPOSED
    reason: str = ""
    comment: str | None = None
    decided_by: str | None = None
    decided_at: str | None = None


def change(plan: Plan, state: PlanState) -> None:
    if state in DECISIONS:
        plan_lifecycle.decide(plan, state, actor="ada", comment="good", at="2026-01-01T00:00:00Z")
    else:
        plan_lifecycle.close(plan, state, "the world has changed")


@pytest.mark.parametrize("state", [*DECISIONS, *CLOSED])
def test_a_proposed_plan_is_decided_on_or_closed(state: PlanState) -> None:
    plan = Plan()
    change(plan, state)
    assert plan.state == state
    assert (plan.decided_by, plan.reason) == (
        ("ada", "") if state in DECISIONS else (None, "the world has changed")
    )


@pytest.mark.parametrize("state", [*DECISIONS, *CLOSED])
@pytest.mark.parametrize("other", PlanState)
def test_what_is_decided_or_closed_stays_so(state: PlanState, other: PlanState) -> None:
    plan = Plan(state=state)
    with pytest.raises(IllegalTransition, match=f"a plan that is {state} cannot become"):
        change(plan, other)
    assert plan == Plan(state=state)
