"""The effects of actions on facts, and the initial facts that a plan-net depends on."""

from app.domain.world_model.beliefs import Facts, revise_beliefs
from planner import INITIAL, Fact, PlanNet, PlanNetAction


def apply_action(facts: Facts, action: PlanNetAction) -> Facts:
    """The facts once the action has ended: without its deletes, with all its effects (table 3).

    Beliefs that the effects contradict are removed, too: facts may have been corrected during the action.
    """
    return revise_beliefs(facts, action.effects, gone=action.deletes)


def initial_support(plan_net: PlanNet) -> Facts:
    """The initial facts that the plan-net's causal links start from; they must still hold at its approval."""
    return frozenset(link.fact for link in plan_net.causal_links if link.producer == INITIAL)


def broken_support(plan_net: PlanNet, facts: Facts) -> tuple[Fact, ...]:
    """The initial facts that the plan-net depends on and that no longer hold, in order."""
    return tuple(sorted(initial_support(plan_net) - facts))
