"""What an action makes of the facts, and what a plan-net rests on."""

from app.domain.world_model.beliefs import Facts, revised
from planner import INITIAL, Fact, PlanNet, PlanNetAction


def applied(facts: Facts, action: PlanNetAction) -> Facts:
    """The facts once the action has ended: without its deletes, with all its effects (table 3).

    Beliefs that the effects contradict go too: facts may have been corrected while the action went on.
    """
    return revised(facts, action.effects, gone=action.deletes)


def rests_on(plan_net: PlanNet) -> Facts:
    """The initial facts that the plan-net's causal links start from: they must still hold at its approval."""
    return frozenset(link.fact for link in plan_net.causal_links if link.producer == INITIAL)


def broken(plan_net: PlanNet, facts: Facts) -> tuple[Fact, ...]:
    """What the plan-net rests on and does not hold any more, in order."""
    return tuple(sorted(rests_on(plan_net) - facts))
