"""How the plan-net's orderings reach the robots: facts to await by sensing, and actions to be cleared of.

Robots do not talk to each other: what one brings about, the next perceives (MACTA §3, "the pre-condition for
the next is encountered"; §5, no need for robots to communicate directly). Where that does not suffice, the
robot waits for clearance.
"""

from collections import defaultdict
from collections.abc import Mapping

from app.domain.world_model.vocabulary import types_in
from planner import Fact, Keeping, KnowledgeBase, PlanNet, awaits_of

Awaits = Mapping[tuple[str, str], tuple[Fact, ...]]
"""By action id and robot."""


def awaited(plan_net: PlanNet, knowledge_base: KnowledgeBase) -> Awaits:
    """For each robot's start of an action the conditions that others bring about and it can sense."""
    changed = (f for action in plan_net.actions for f in (*action.deletes, *action.effects))
    facts = [*changed, *(f for action in plan_net.actions for f in action.preconditions)]
    return awaits_of(plan_net, types_in(facts, knowledge_base), knowledge_base)


def exchanges(plan_net: PlanNet) -> int:
    """How many words of the service robots wait for, one after the other at most: the script, and clearances."""
    return 1 + len(cleared(plan_net))


def cleared(plan_net: PlanNet) -> Mapping[str, tuple[str, ...]]:
    """For each action those that must have ended and that its robots have to be told of."""
    found: dict[str, list[str]] = defaultdict(list)
    for ordering in plan_net.orderings:
        # An ordering of which nobody says what keeps it is safe with clearance, too.
        if ordering.kept_by not in (Keeping.ROBOT, Keeping.SENSING):
            found[ordering.after].append(ordering.before)
    return {action: tuple(before) for action, before in found.items()}
