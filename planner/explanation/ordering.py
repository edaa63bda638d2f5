"""Why actions come in this order: what each ordering is for, in words."""

from collections import defaultdict
from collections.abc import Mapping

from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.knowledge.phrases import enumeration, phrase
from planner.plan_nets.plan_net import GOAL, Keeping, Ordering, OrderingReason, PlanNet

KEPT = {
    Keeping.SENSING: "; the robot waits until it senses it",
    Keeping.CLEARANCE: "; the robot waits until it is cleared",
}


class Reasons:
    """What the orderings of one plan-net are for."""

    def __init__(self, plan_net: PlanNet, names: Mapping[str, str], knowledge_base: KnowledgeBase) -> None:
        """:param names: how actions are called, by id."""
        self._actions = {action.id: action for action in plan_net.actions}
        self._names = names
        self._senses = plan_net.senses
        self._base = knowledge_base
        self._given: dict[tuple[str, str], list[Fact]] = defaultdict(list)
        self._promised: dict[str, set[Fact]] = defaultdict(set)
        for link in plan_net.causal_links:
            self._given[link.producer, link.consumer].append(link.fact)
            self._promised[link.producer].add(link.fact)

    def why(self, ordering: Ordering) -> str:
        """`a2 DOCK brings about that yard_1 is at door_1 for a3 TRANSPORT`, and what keeps it."""
        words = {
            OrderingReason.CAUSAL: self._causal,
            OrderingReason.THREAT: self._threat,
            OrderingReason.RESOURCE: self._resource,
            OrderingReason.STAGE: self._stage,
            OrderingReason.ORDER: self._order,
        }[ordering.reason](ordering)
        return words + self._kept(ordering)

    def _kept(self, ordering: Ordering) -> str:
        if ordering.kept_by is Keeping.CLEARANCE and (blind := self._without_senses(ordering)):
            verb = "does" if len(blind) == 1 else "do"
            return f"; {enumeration(blind)} {verb} not sense that, and the robot waits until it is cleared"
        return KEPT.get(ordering.kept_by, "") if ordering.kept_by else ""

    def _without_senses(self, ordering: Ordering) -> list[str]:
        """The robots that do not sense what others sense in their place."""
        given = self._given[ordering.before, ordering.after]
        words = {self._base.to_relation(fact)[0] for fact in given} & self._base.sensed_words
        return sorted(
            robot
            for robot in self._actions[ordering.after].agents
            if robot in self._senses and words - self._senses[robot]
        )

    def _causal(self, ordering: Ordering) -> str:
        facts = [phrase(self._base, fact) for fact in self._given[ordering.before, ordering.after]]
        return (
            f"{self._names[ordering.before]} brings about that {enumeration(facts)} "
            f"for {self._names[ordering.after]}"
        )

    def _threat(self, ordering: Ordering) -> str:
        one = self._actions[ordering.before]
        other = self._actions[ordering.after]
        for fact in one.preconditions:
            if fact in other.deletes:
                what = phrase(self._base, fact)
                return f"{self._names[one.id]} needs that {what}, which {self._names[other.id]} ends"
        for fact in sorted(self._promised[other.id]):
            if fact in one.deletes:
                what = phrase(self._base, fact)
                return f"{self._names[one.id]} would undo that {what}, which {self._names[other.id]} brings about"
        return "else one would undo what the other relies on"

    def _resource(self, ordering: Ordering) -> str:
        both = set(self._actions[ordering.before].agents) & set(self._actions[ordering.after].agents)
        return f"{enumeration(sorted(both))} can do only one at a time"

    def _stage(self, ordering: Ordering) -> str:
        achieved = self._achieved(ordering.before)
        what = f"that {achieved}" if achieved else self._names[ordering.before]
        return f"the goal asks for {what} before {self._names[ordering.after]}"

    def _order(self, ordering: Ordering) -> str:
        earlier = self._achieved(ordering.before) or f"{self._names[ordering.before]} has ended"
        later = self._achieved(ordering.after) or f"{self._names[ordering.after]} begins"
        return f"the plan is edited so that {later} only once {earlier}"

    def _achieved(self, action: str) -> str:
        """The goals that an action achieves, in words; empty if there are none."""
        return enumeration([phrase(self._base, fact) for fact in self._given[action, GOAL]])
